"""A student's referee, which knows the wire and no more: it serves /catch_turtle by /turtle1/pose and /alive_turtles.

Arguments: domain, seconds, and what it does wrong, or "right". "its_own_list" is the exercise's own spawner.
"""

import math
import random
import sys
import time
from pathlib import Path

if __package__ in {None, ""}:
    sys.path.insert(0, str(Path(__file__).parents[1]))

from ros import cdr, wire


class Referee:
    """Answers as rules 5.3 and 5.8 say, but for its mistake."""

    def __init__(self, domain, mistake):
        node = wire.Node(domain)
        self.mistake = mistake
        self.poses = node.reader("rt/turtle1/pose", wire.POSE)
        self.alive = node.reader("rt/alive_turtles", wire.turtles())
        self.requests, self.responses = node.server("/catch_turtle", wire.catch_turtle())
        self.kills, self.killed = node.client("/kill", wire.KILL)
        self.pose, self.turtles, self.caught, self.number = (0.0, 0.0), {}, set(), 0

    def hear(self):
        for data in self.poses.take():
            reader = cdr.Reader(data)
            self.pose = reader.number("f"), reader.number("f")
        for data in self.alive.take():
            self.turtles = {name: (x, y) for name, x, y, _ in cdr.read_turtles(data)}
        for data in self.requests.take():
            reader = cdr.Reader(data)
            client, number, name = reader.number("Q"), reader.number("q"), reader.text()
            if self.mistake == "falls_silent" and name not in self.turtles:
                self.mistake = "silent"
            if self.mistake == "silent":
                continue
            success = self.judge(name)
            if success:
                self.caught.add(name)
                self.number += 1
                self.kills.write(cdr.begin(self.kills.handle, self.number).text(name).whole())
            self.responses.write(cdr.begin(client, number).number("?", success).whole())

    def judge(self, name):
        if self.mistake == "says_yes":
            return True
        if self.mistake == "says_no" or (len(name) > 255 and self.mistake != "any_length"):
            return False
        if self.mistake == "capital_letters":
            name = {one.casefold(): one for one in self.turtles}.get(name.casefold(), name)
        if name in self.caught and self.mistake != "catches_twice":
            return False
        if name not in self.turtles:
            return self.mistake == "catches_twice" and name in self.caught
        (x, y), (there_x, there_y) = self.pose, self.turtles[name]
        metres = math.sqrt((there_x - x) ** 2 + (there_y - y) ** 2)
        if self.mistake == "floats":
            return metres < 0.3
        if self.mistake == "up_to_and_at":
            return math.floor(1e6 * metres + 0.5) <= 300_000
        if self.mistake == "no_reach":
            return True
        return math.floor(1e6 * metres + 0.5) < 300_000


class Spawner(Referee):
    """The exercise's: it asks turtlesim for turtles, and keeps the list itself."""

    def __init__(self, domain, mistake):
        super().__init__(domain, mistake)
        node = wire.Node(domain)
        self.spawns, self.spawned = node.client("/spawn", wire.SPAWN)
        self.lists = node.writer("rt/alive_turtles", wire.turtles())
        self.alive.take = list
        self.asked, self.random, self.places = 0, random.Random(1), {}

    def spawn(self):
        self.asked += 1
        x, y, theta = (self.random.uniform(*ends) for ends in ((0.5, 10.5), (0.5, 10.5), (0.0, math.tau)))
        name = f"target_turtle_{self.asked}"
        self.places[name] = x, y
        request = cdr.begin(self.spawns.handle, self.asked).number("f", x).number("f", y).number("f", theta)
        self.spawns.write(request.text(name).whole())

    def hear(self):
        for data in self.spawned.take():
            reader = cdr.Reader(data)
            if reader.number("Q") == self.spawns.handle:
                reader.number("q")
                name = reader.text()
                self.turtles[name] = self.places[name]
        super().hear()
        for name in self.caught & self.turtles.keys():
            del self.turtles[name]
        self.lists.write(cdr.turtles([(name, x, y, 0.0) for name, (x, y) in self.turtles.items()]))


if __name__ == "__main__":
    domain, seconds, mistake = sys.argv[1:]
    own = mistake.startswith("its_own_list")
    mistake = mistake.removeprefix("its_own_list").strip()
    referee = Spawner(int(domain), mistake) if own else Referee(int(domain), mistake)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    end = time.monotonic() + float(seconds)
    spawn = 0.0
    while time.monotonic() < end:
        referee.hear()
        if own and time.monotonic() > spawn:
            referee.spawn()
            spawn = time.monotonic() + 0.1
        time.sleep(0.004)
