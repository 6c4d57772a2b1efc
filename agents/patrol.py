"""Drives itself: flat out to a race, or to good ground."""

import math
from typing import Any

from catch_arena.agents.contested_by_time import best_race
from catch_arena.batch_policy import BatchView
from catch_arena.policy import View

GRID = 5
"""The spawn area is looked at in GRID x GRID points."""
SPAWN_LOW_M, SPAWN_WALL_M = 0.5, 0.5889
"""R3.2: spawns keep these distances from the walls at 0 and from those opposite."""
TURN_GAIN = 6.0
"""Turn rate per radian of bearing [1/s]."""
BRAKE_GAIN = 2.0
"""Speed per metre that is left to a resting place [1/s]."""

Point = tuple[float, float]
"""(forward, left) in the hunter's own frame [m]."""


class Agent:
    """Catches as it drives by: under velocity control what is within reach is requested for it (R4.4)."""

    control = "velocity"

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: View) -> tuple[float, float]:
        """Speed and turn rate as parts of the limits, in [-1, 1]."""
        return decide(view)

    def act_batch(self, view: BatchView) -> Any:
        """The same for N hunters: (N, 2)."""
        from catch_arena.training.compiled import commands_for_each  # a match must not wait for the compiler

        return commands_for_each(decide, view)


def decide(view: View) -> tuple[float, float]:
    """The command for the best of all races in view, or for a place to wait."""
    rank = best_race(range(1, len(view.targets) + 1), view)
    return drive(view.targets[rank - 1].forward, view.targets[rank - 1].left, view) if rank else rest(view)


def rest(view: View) -> tuple[float, float]:
    """The command that brings the hunter to the middle of its own ground, and lets it stay there."""
    forward, left = middle_of_own_ground(view)
    speed, turn = drive(forward, left, view)
    return min(speed, BRAKE_GAIN * math.hypot(forward, left) / view.limits.max_speed_mps), turn


def drive(forward: float, left: float, view: View) -> tuple[float, float]:
    """The command that brings a point of the own frame [m] within reach, as fast as the arc to it allows."""
    limits = view.limits
    bearing = math.atan2(left, forward)
    turn = max(-1.0, min(1.0, TURN_GAIN * bearing / limits.max_turn_rate_radps))
    if abs(bearing) >= math.pi / 2:
        return 0.0, turn  # driving would only lead away
    # the circle that is tangent to the heading and passes half a reach from the point has a diameter of:
    diameter = (math.hypot(forward, left) + limits.reach_m / 2) / max(1e-6, abs(math.sin(bearing)))
    return min(1.0, limits.max_turn_rate_radps * diameter / 2 / limits.max_speed_mps), turn


def middle_of_own_ground(view: View) -> Point:
    """The mean (forward, left) [m] of those points of the spawn area that no rival is nearer to."""
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
    """Whether no rival is nearer to a point of the own frame."""
    for rival in view.rivals:
        dx, dy = forward - rival.forward, left - rival.left
        if dx * dx + dy * dy < forward * forward + left * left:
            return False
    return True
