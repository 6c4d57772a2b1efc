"""The exercise's turtle_controller, as a student without our package would write it: it knows DDS, and no more.

Arguments: domain, turtle, service, seconds. Prints how many catches it was told of.
"""

import math
import signal
import sys
import time

from ros import wire


class Controller:
    """Drives to the closest turtle, ten times a second, and asks for it when it is near."""

    def __init__(self, domain, turtle, service):
        node = wire.Node(domain)
        self.poses = node.reader(f"rt/{turtle}/pose", wire.POSE)
        self.alive = node.reader("rt/alive_turtles", wire.TURTLES)
        self.cmd_vel = node.writer(f"rt/{turtle}/cmd_vel", wire.TWIST)
        self.requests, self.responses = node.client(service, wire.CATCH_TURTLE)
        self.pose, self.turtles, self.number, self.caught = None, [], 0, 0

    def receive(self):
        for pose in self.poses.take():
            self.pose = pose
        for message in self.alive.take():
            self.turtles = message.turtles
        self.caught += sum(one.success for one in self.responses.take() if one.client == self.requests.handle)

    def drive(self):
        x, y, theta = self.pose.x, self.pose.y, self.pose.theta
        near = min(self.turtles, key=lambda one: math.hypot(one.x - x, one.y - y))
        distance = math.hypot(near.x - x, near.y - y)
        turn = math.remainder(math.atan2(near.y - y, near.x - x) - theta, math.tau)
        self.cmd_vel.write(*wire.twist(2.0 * distance, 6.0 * turn))
        if distance < 0.3:
            self.number += 1
            self.requests.write(self.requests.handle, self.number, near.name)


if __name__ == "__main__":
    domain, turtle, service, seconds = sys.argv[1:]
    controller = Controller(int(domain), turtle, service)
    end = time.monotonic() + float(seconds)
    ended = []
    signal.signal(signal.SIGTERM, lambda *_: ended.append(True))
    while time.monotonic() < end and not ended:
        controller.receive()
        if controller.pose and controller.turtles:
            controller.drive()
        time.sleep(0.1)
    controller.receive()
    sys.stdout.write(f"{controller.caught}\n")
