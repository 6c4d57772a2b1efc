"""A student's referee: it serves /catch_turtle by /turtle1/pose and /alive_turtles.

Arguments: domain, seconds, and what it does wrong, or "right". "its_own_list" is the exercise's own spawner.
"""

import math
import os
import random
import sys
import time

from catch_arena.messages import CatchTurtleResponse, Turtle, TurtleArray
from catch_arena.ros.middleware.interfaces import Interfaces, Name, SpawnRequest
from catch_arena.ros.middleware.opening import open_bus

TYPES = Interfaces()


class Referee:
    """Answers as rules 5.3 and 5.8 say, but for its mistake."""

    def __init__(self, bus, mistake="right"):
        self.bus, self.mistake = bus, mistake
        self.place, self.turtles, self.caught = (0.0, 0.0), {}, set()
        bus.subscribe("/turtle1/pose", TYPES.pose, self.on_pose)
        self.begin()
        bus.serve("/catch_turtle", TYPES.catch_turtle, self.on_request)
        self.kill = bus.client("/kill", TYPES.kill)

    def begin(self):
        self.bus.subscribe("/alive_turtles", TYPES.turtle_array, self.on_list)

    def tick(self):
        self.bus.spin(0.004)

    def on_pose(self, pose):
        self.place = pose.x, pose.y

    def on_list(self, message):
        self.turtles = {name: (x, y) for name, x, y, _ in message.turtles}

    def on_request(self, request):
        name = request.message.name
        if self.mistake == "falls_silent" and name not in self.turtles:
            self.mistake = "silent"
        if self.mistake == "silent":
            return
        success = self.judge(name)
        if success:
            self.caught.add(name)
            self.kill.call(Name(name))
        request.answer(CatchTurtleResponse(success))

    def judge(self, name):
        if self.mistake == "says_yes":
            return True
        if len(name) > 255:
            return False
        if name in self.caught or name not in self.turtles:
            return False
        metres = math.dist(self.place, self.turtles[name])
        if self.mistake == "floats":
            return metres < 0.3
        return math.floor(1e6 * metres + 0.5) < 300_000


class Spawner(Referee):
    """The exercise's: it asks turtlesim for turtles, and keeps the list itself."""

    def begin(self):
        self.client = self.bus.client("/spawn", TYPES.spawn)
        self.publish = self.bus.publisher("/alive_turtles", TYPES.turtle_array)
        self.random, self.calls, self.next = random.Random(1), [], 0.0

    def tick(self):
        super().tick()
        if time.monotonic() > self.next:
            self.next = time.monotonic() + 0.1
            x, y = self.random.uniform(0.5, 10.5), self.random.uniform(0.5, 10.5)
            request = SpawnRequest(x, y, 0.0, f"target_turtle_{len(self.calls) + 1}")
            self.calls.append((self.client.call(request), (x, y)))
        there = [(call.result().name, *place) for call, place in self.calls if call.done()]
        self.turtles = {name: (x, y) for name, x, y in there if name not in self.caught}
        self.publish(TurtleArray(tuple(Turtle(name, *place, 0.0) for name, place in self.turtles.items())))


if __name__ == "__main__":
    domain, seconds, mistake = sys.argv[1:]
    own = mistake.startswith("its_own_list")
    os.environ["ROS_DOMAIN_ID"] = domain
    bus = open_bus("cyclonedds", log=lambda _: None)
    referee = (Spawner if own else Referee)(bus, mistake.removeprefix("its_own_list").strip())
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    end = time.monotonic() + float(seconds)
    while time.monotonic() < end:
        referee.tick()
