"""Measure how the arena keeps time on a ROS 2 bus; docs/reference/ros_names.md has the results.

python scripts/measure_ros.py [--bus rclpy] [--seconds 60] [--hunters 4] [--targets 16]

`catch-arena ros serve` plays a match. A node in this process drives all hunters ten times a second, receives all poses,
and calls /hunter_0/catch_turtle, all on the loopback interface. Use the machine for nothing else meanwhile.
`make ros` runs it over rclpy with ROS's default middleware.
"""

import argparse
import math
import os
import re
import subprocess
import sys
import time
from collections import Counter
from random import uniform
from statistics import median, quantiles

from catch_arena.core.physics import TICK_MS
from catch_arena.messages import CatchTurtleRequest, Pose, TurtleArray
from catch_arena.ros.middleware.bus import BACKENDS, Bus, Call
from catch_arena.ros.middleware.interfaces import CLOCK, TWIST, Interfaces, TwistMessage
from catch_arena.ros.middleware.opening import open_bus

JUST_NOT_ONE = "1.000001"
"""Simulation speed: a millionth above real time, so that /clock is published; a gap in it is a lost message."""


class Driver:
    """Node that drives all hunters and counts messages."""

    def __init__(self, bus: Bus, hunters: int) -> None:
        self.poses: dict[str, Pose] = {}
        self.received: Counter[str] = Counter()
        self.turtles: TurtleArray = TurtleArray(())
        self.times: list[int] = []
        self.drive = {}
        types = bus.interfaces(Interfaces())
        for hunter in (f"hunter_{seat}" for seat in range(hunters)):
            self.drive[hunter] = bus.publisher(f"/{hunter}/cmd_vel", TWIST)
            bus.subscribe(f"/{hunter}/pose", types.pose, lambda pose, hunter=hunter: self._receive(hunter, pose))
        bus.subscribe("/alive_turtles", types.turtle_array, lambda turtles: setattr(self, "turtles", turtles))
        bus.subscribe("/clock", CLOCK, lambda time: self._tick(time.clock.sec * 1000 + time.clock.nanosec // 10**6))
        self.catch_turtle = bus.client("/hunter_0/catch_turtle", types.catch_turtle)

    def act(self) -> str:
        """Drive every hunter to its nearest turtle; return the name of hunter_0's turtle, or "nothing"."""
        wanted = "nothing"
        for hunter, pose in self.poses.items():
            if not self.turtles.turtles:
                continue
            near = min(self.turtles.turtles, key=lambda one: math.hypot(one.x - pose.x, one.y - pose.y))
            distance = math.hypot(near.x - pose.x, near.y - pose.y)
            turn = math.remainder(math.atan2(near.y - pose.y, near.x - pose.x) - pose.theta, math.tau)
            self.drive[hunter](TwistMessage.of(2.0 * distance, 6.0 * turn))
            if hunter == "hunter_0":
                wanted = near.name
        return wanted

    def _receive(self, hunter: str, pose: Pose) -> None:
        self.poses[hunter] = pose
        if self.times and self.times[-1] > 0:
            self.received[hunter] += 1

    def _tick(self, time_ms: int) -> None:
        if not self.times or time_ms > self.times[-1]:
            self.times.append(time_ms)


def main() -> None:
    """Measure, and print the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bus", choices=BACKENDS, help="middleware; without it, the first that works")
    parser.add_argument("--seconds", type=int, default=60, help="length of the match")
    parser.add_argument("--hunters", type=int, default=4, help="number of hunters")
    parser.add_argument("--targets", type=int, default=16, help="number of targets")
    given = parser.parse_args()
    os.environ |= {"ROS_LOCALHOST_ONLY": "1", "ROS_DOMAIN_ID": os.environ.get("ROS_DOMAIN_ID", "77")}
    settings = {
        "hunters": given.hunters,
        "initial_targets": given.targets,
        "max_targets": given.targets,
        "spawn_frequency_hz": 10.0,
        "time_limit_s": given.seconds,
    }
    bus = open_bus(given.bus, node="measure_ros")
    command = [sys.executable, "-m", "catch_arena", "ros", "serve", "-s", "standard", "--bus", bus.backend]
    command += ["--speed", JUST_NOT_ONE, *(f"--set={name}={value}" for name, value in settings.items())]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as arena:
        driver = Driver(bus, given.hunters)
        calls, busy = round_trips(bus, driver, arena, given.seconds)
        out = arena.communicate()[0]
    steps = len(driver.times) - 1
    lost = sum(late - early != TICK_MS for early, late in zip(driver.times[1:], driver.times[2:], strict=False))
    print(re.search(r".* ticks were late .*", out)[0])
    print(f"{steps} steps on /clock, {lost} gaps; poses received: {dict(driver.received)}")
    late = quantiles(calls, n=100)[98]
    print(f"catch_turtle, round trip: {len(calls)}, median {1e3 * median(calls):.2f} ms, p99 {1e3 * late:.2f} ms")
    print(f"processor time of the arena: {100 * busy:.0f} % of one core")


def round_trips(bus: Bus, driver: Driver, arena: "subprocess.Popen[str]", seconds: int) -> tuple[list[float], float]:
    """Drive at 10 Hz, and call whenever the last call has been answered, at uneven times.

    Returns: the round trips [s], and the arena's processor time as a fraction of elapsed time.
    """
    calls: list[float] = []
    call: Call | None = None
    called_s = next_drive = next_call = 0.0
    wanted = "nothing"
    begin = used = None
    busy = 0.0
    while arena.poll() is None:
        bus.spin(0.002)
        now = time.perf_counter()
        if driver.times and driver.times[-1] > 0 and begin is None:
            begin, used = now, processor_time(arena.pid)
        if begin is not None and begin < now and driver.times[-1] < (seconds - 1) * 1000:
            busy = (processor_time(arena.pid) - used) / (now - begin)
        if call is not None and call.response is not None:
            calls.append(now - called_s)
            call, next_call = None, now + uniform(0.05, 0.15)
        if now > next_drive:
            wanted, next_drive = driver.act(), now + 0.1
        if call is None and begin is not None and now > next_call and driver.catch_turtle.ready:
            call, called_s = driver.catch_turtle.call(CatchTurtleRequest(wanted)), time.perf_counter()
    return calls, busy


def processor_time(pid: int) -> float:
    """Return the processor time of all threads of a process [s]."""
    with open(f"/proc/{pid}/stat", encoding="utf-8") as file:  # noqa: PTH123 - two hundred times a second
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    main()
