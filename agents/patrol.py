"""Drives itself at full speed to the target with the best race, or to the middle of its own ground."""

import math
from typing import Any

from catch_arena.agents.contested_by_time import best_race
from catch_arena.batch_policy import BatchView
from catch_arena.policy import View

GRID = 5
"""Points along each side of the grid that stands for the spawn area."""
SPAWN_LOW_M, SPAWN_WALL_M = 0.5, 0.5889
"""R3.2: distances of spawns from the walls at 0, and from the opposite walls [m]."""
TURN_GAIN = 6.0
"""Turn rate per radian of bearing [1/s]."""
BRAKE_GAIN = 2.0
"""Speed per metre of distance to the resting place [1/s]."""

Point = tuple[float, float]
"""Point (forward, left) in the hunter's own frame [m]."""


class Agent:
    """Agent that catches as it drives by: under velocity control the arena requests what is within reach (R4.4)."""

    control = "velocity"

    def reset(self, seed: int) -> None:
        """Do nothing: the agent keeps no state."""

    def act(self, view: View) -> tuple[float, float]:
        """Return speed and turn rate as fractions of the limits, in [-1, 1]."""
        return decide(view)

    def act_batch(self, view: BatchView) -> Any:
        """Return the commands of N hunters, (N, 2); `act` gives the same command for one."""
        from catch_arena.training.compiled import commands_for_each  # a match must not wait for the compiler

        return commands_for_each(decide, view)


def decide(view: View) -> tuple[float, float]:
    """Return the command for the best of all races in view, or for a place to wait."""
    rank = best_race(range(1, len(view.targets) + 1), view)
    return drive(view.targets[rank - 1].forward, view.targets[rank - 1].left, view) if rank else rest(view)


def rest(view: View) -> tuple[float, float]:
    """Return the command that brings the hunter to the middle of its own ground and keeps it there."""
    forward, left = middle_of_own_ground(view)
    speed, turn = drive(forward, left, view)
    return min(speed, BRAKE_GAIN * math.hypot(forward, left) / view.limits.max_speed_mps), turn


def drive(forward: float, left: float, view: View) -> tuple[float, float]:
    """Return the command that brings a point of the own frame [m] within reach, as fast as the arc allows."""
    limits = view.limits
    bearing = math.atan2(left, forward)
    turn = max(-1.0, min(1.0, TURN_GAIN * bearing / limits.max_turn_rate_radps))
    if abs(bearing) >= math.pi / 2:
        return 0.0, turn  # driving would only increase the distance
    # diameter of the circle that is tangent to the heading and passes half a reach from the point
    diameter = (math.hypot(forward, left) + limits.reach_m / 2) / max(1e-6, abs(math.sin(bearing)))
    return min(1.0, limits.max_turn_rate_radps * diameter / 2 / limits.max_speed_mps), turn


def middle_of_own_ground(view: View) -> Point:
    """Return the mean (forward, left) [m] of the points of the spawn area that no rival is nearer to."""
    step = (view.limits.side_m - SPAWN_LOW_M - SPAWN_WALL_M) / GRID
    points, ahead, aside = 0, 0.0, 0.0
    for i in range(GRID):
        for j in range(GRID):
            dx, dy = SPAWN_LOW_M + (i + 0.5) * step - view.x, SPAWN_LOW_M + (j + 0.5) * step - view.y
            forward = view.heading_cos * dx + view.heading_sin * dy
            left = view.heading_cos * dy - view.heading_sin * dx
            if is_own(forward, left, view):
                points, ahead, aside = points + 1, ahead + forward, aside + left
    return ahead / max(1, points), aside / max(1, points)


def is_own(forward: float, left: float, view: View) -> bool:
    """Return whether no rival is nearer to a point of the own frame."""
    for rival in view.rivals:
        dx, dy = forward - rival.forward, left - rival.left
        if dx * dx + dy * dy < forward * forward + left * left:
            return False
    return True
