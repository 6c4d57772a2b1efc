"""turtlesim's part on a bus, from the description of what it does: poses, cmd_vel, spawn and kill.

Arguments: domain, seconds. Only turtle1 moves.
"""

import math
import os
import sys
import time

from catch_arena.messages import Pose
from catch_arena.ros.middleware.interfaces import TWIST, Empty, Interfaces, Name
from catch_arena.ros.middleware.opening import open_bus

TYPES = Interfaces()
SIDE = 11.088889122009277


class Turtlesim:
    """Spawns every name once, and publishes the poses of all turtles in each tick of 16 ms."""

    def __init__(self, bus):
        self.bus = bus
        self.there = {"turtle1": Pose(5.0, 5.0, 0.0, 0.0, 0.0)}
        self.requested, self.publishers = [], {}
        bus.subscribe("/turtle1/cmd_vel", TWIST, self.on_twist)
        bus.serve("/spawn", TYPES.spawn, self.on_spawn)
        bus.serve("/kill", TYPES.kill, self.on_kill)

    def on_twist(self, twist):
        self.there["turtle1"] = Pose(*self.there["turtle1"][:3], twist.linear.x, twist.angular.z)

    def on_spawn(self, request):
        requested = request.message
        self.requested.append(requested.name)
        free = requested.name not in self.there
        if free:
            self.there[requested.name] = Pose(requested.x, requested.y, requested.theta, 0.0, 0.0)
        request.answer(Name(requested.name if free else ""))

    def on_kill(self, request):
        self.there.pop(request.message.name, None)
        request.answer(Empty())

    def tick(self):
        self.bus.spin()
        x, y, theta, v, w = self.there["turtle1"]
        theta = math.remainder(theta + w * 0.016, math.tau)
        x, y = (place + part * v * 0.016 for place, part in ((x, math.cos(theta)), (y, math.sin(theta))))
        self.there["turtle1"] = Pose(min(max(x, 0.0), SIDE), min(max(y, 0.0), SIDE), theta, v, w)
        for name, pose in self.there.items():
            if name not in self.publishers:
                self.publishers[name] = self.bus.publisher(f"/{name}/pose", TYPES.pose)
            self.publishers[name](pose)


if __name__ == "__main__":
    domain, seconds = sys.argv[1:]
    os.environ["ROS_DOMAIN_ID"] = domain
    simulator = Turtlesim(open_bus("cyclonedds", log=lambda _: None))
    end = time.monotonic() + float(seconds)
    while time.monotonic() < end:
        simulator.tick()
        time.sleep(0.016)
