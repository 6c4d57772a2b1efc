"""Drives itself with two PID loops, on distance and on heading, as a controller node on /cmd_vel does.

The gains are those of the ROS 2 course "catch them all" and of the hosted controllers (R4.3). The integral is frozen
while the command is at its limit (conditional integration), and is reset with each goal: K. J. Åström, T. Hägglund,
"PID controllers: theory, design, and tuning" (1995), chapter 3.5. The goal is chosen as by `triage`.
"""

import math
from typing import Final, NamedTuple

from catch_arena.agents.patrol import Point
from catch_arena.agents.triage import goal, race_worth_running, worth_chasing
from catch_arena.geometry import world_frame
from catch_arena.policy import View

SAME_GOAL_M: Final = 0.6
"""Longest move of a goal in one step [m]; a goal that moves farther counts as a new one."""


class Gains(NamedTuple):
    """Gains of one PID loop."""

    proportional: float
    integral: float
    derivative: float


LINEAR: Final = Gains(2.0, 1.0, 0.0)
"""Gains of the speed [m/s]: per metre, per metre-second, and per metre per second."""
ANGULAR: Final = Gains(6.0, 0.0, 0.1)
"""Gains of the turn rate [rad/s]: per radian, radian-second, and radian per second, which damps the end of a turn."""


class Loop:
    """PID controller that turns an error into a command within a limit."""

    def __init__(self, gains: Gains) -> None:
        self.gains = gains
        self.restart()

    def restart(self) -> None:
        """Reset the integral and the last error."""
        self.integral = 0.0
        self.last: float | None = None

    def command(self, error: float, period_s: float, limit: float) -> float:
        """Return the command for an error, in [-limit, limit]."""
        proportional, integral, derivative = self.gains
        rate = 0.0 if self.last is None else (error - self.last) / period_s
        self.last = error
        sum_so_far = self.integral + error * period_s
        command = proportional * error + integral * sum_so_far + derivative * rate
        if abs(command) <= limit:
            self.integral = sum_so_far
        return max(-limit, min(limit, command))


class Agent:
    """Agent that turns before it drives, and slows down towards each target as turtlesim's controller does."""

    control = "velocity"

    def reset(self, seed: int) -> None:
        """Begin with new control loops and without a goal."""
        del seed
        self.linear, self.angular = Loop(LINEAR), Loop(ANGULAR)
        self.goal: Point | None = None

    def act(self, view: View) -> tuple[float, float]:
        """Return speed and turn rate as fractions of the limits, in [-1, 1]."""
        forward, left, _ = goal(race_worth_running(worth_chasing(view), view), view)
        dx, dy = world_frame(view.heading_cos, view.heading_sin, forward, left)
        place = view.x + dx, view.y + dy
        if self.goal is None or math.dist(place, self.goal) > SAME_GOAL_M:
            self.linear.restart()
            self.angular.restart()
        self.goal = place
        limits, period_s = view.limits, view.limits.control_period_ms / 1000.0
        bearing = math.atan2(left, forward)
        ahead = math.hypot(forward, left) * max(0.0, math.cos(bearing))  # 0 for a goal at the back
        speed = self.linear.command(ahead, period_s, limits.max_speed_mps) / limits.max_speed_mps
        turn = self.angular.command(bearing, period_s, limits.max_turn_rate_radps) / limits.max_turn_rate_radps
        return max(0.0, speed), turn
