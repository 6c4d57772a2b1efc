"""The exercise's turtle_controller, as a student without our package would write it: it knows the wire, and no more.

Arguments: domain, turtle, service, seconds. Prints how many catches it was told of.
"""

import math
import signal
import sys
import time

from ros import cdr, wire


class Controller:
    """Drives to the closest turtle, ten times a second, and asks for it when it is near."""

    def __init__(self, domain, turtle, service):
        node = wire.Node(domain)
        self.poses = node.reader(f"rt/{turtle}/pose", wire.POSE)
        self.alive = node.reader("rt/alive_turtles", wire.turtles())
        self.cmd_vel = node.writer(f"rt/{turtle}/cmd_vel", wire.TWIST)
        self.requests, self.responses = node.client(service, wire.catch_turtle())
        self.pose, self.turtles, self.number, self.caught = None, [], 0, 0

    def hear(self):
        for data in self.poses.take():
            reader = cdr.Reader(data)
            self.pose = [reader.number("f") for _ in range(5)]
        for data in self.alive.take():
            self.turtles = cdr.read_turtles(data)
        for data in self.responses.take():
            reader = cdr.Reader(data)
            if reader.number("Q") == self.requests.handle:
                reader.number("q")
                self.caught += reader.number("?")

    def drive(self):
        x, y, theta = self.pose[:3]
        name, there_x, there_y, _ = min(self.turtles, key=lambda one: math.hypot(one[1] - x, one[2] - y))
        distance = math.hypot(there_x - x, there_y - y)
        turn = math.remainder(math.atan2(there_y - y, there_x - x) - theta, math.tau)
        self.cmd_vel.write(cdr.twist((2 * distance, 0, 0), (0, 0, 6 * turn)))
        if distance < 0.3:
            self.number += 1
            self.requests.write(cdr.begin(self.requests.handle, self.number).text(name).whole())


if __name__ == "__main__":
    domain, turtle, service, seconds = sys.argv[1:]
    controller = Controller(int(domain), turtle, service)
    end = time.monotonic() + float(seconds)
    ended = []
    signal.signal(signal.SIGTERM, lambda *_: ended.append(True))
    while time.monotonic() < end and not ended:
        controller.hear()
        if controller.pose and controller.turtles:
            controller.drive()
        time.sleep(0.1)
    controller.hear()
    sys.stdout.write(f"{controller.caught}\n")
