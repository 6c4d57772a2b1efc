"""turtlesim's part on the bus, from the description of what it does and of the wire: poses, cmd_vel, spawn and kill.

Arguments: domain, seconds. It has the physics of one turtle, turtle1, and the names of the others.
"""

import math
import sys
import time

from ros import cdr, wire

SIDE = 11.088889122009277


class Turtlesim:
    """One tick every 16 ms, in which each topic and each service is looked at."""

    def __init__(self, domain):
        node = wire.Node(domain)
        self.x = self.y = SIDE / 2
        self.theta = self.v = self.w = 0.0
        self.commanded = time.monotonic()
        self.names = {"turtle1"}
        self.cmd_vel = node.reader("rt/turtle1/cmd_vel", wire.TWIST)
        self.pose = node.writer("rt/turtle1/pose", wire.POSE)
        self.spawns, self.spawned = node.server("/spawn", wire.SPAWN)
        self.kills, self.killed = node.server("/kill", wire.KILL)

    def tick(self):
        for data in self.cmd_vel.take():
            reader = cdr.Reader(data)
            numbers = [reader.number("d") for _ in range(6)]
            self.v, self.w, self.commanded = numbers[0], numbers[5], time.monotonic()
        for data in self.spawns.take():
            reader = cdr.Reader(data)
            client, number = reader.number("Q"), reader.number("q")
            _, _, _, name = (reader.number("f"), reader.number("f"), reader.number("f"), reader.text())
            free = name not in self.names
            self.names.add(name)
            self.spawned.write(cdr.begin(client, number).text(name if free else "").whole())
        for data in self.kills.take():
            reader = cdr.Reader(data)
            client, number = reader.number("Q"), reader.number("q")
            self.names.discard(reader.text())
            self.killed.write(cdr.begin(client, number).number("B", 0).whole())
        if time.monotonic() > self.commanded + 1.0:
            self.v = self.w = 0.0
        self.theta = math.remainder(self.theta + self.w * 0.016, math.tau)
        self.x = min(max(self.x + math.cos(self.theta) * self.v * 0.016, 0.0), SIDE)
        self.y = min(max(self.y + math.sin(self.theta) * self.v * 0.016, 0.0), SIDE)
        self.pose.write(cdr.pose((self.x, self.y, self.theta, abs(self.v), self.w)))


if __name__ == "__main__":
    domain, seconds = sys.argv[1:]
    simulator = Turtlesim(int(domain))
    end = time.monotonic() + float(seconds)
    while time.monotonic() < end:
        simulator.tick()
        time.sleep(0.016)
    sys.stdout.write(f"{len(simulator.names)} turtles\n")
