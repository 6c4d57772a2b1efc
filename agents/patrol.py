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
        target = best_race(view.targets, view)
        return rest(view) if target is None else drive(target.forward, target.left, view)

    def act_batch(self, view: BatchView) -> Any:
        """The same for N hunters: (N, 2)."""
        from catch_arena.training.scripted import patrol  # a match must not wait for the compiler

        return patrol(view)


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
    places = [SPAWN_LOW_M + (i + 0.5) * step for i in range(GRID)]
    rivals = [(rival.forward, rival.left) for rival in view.rivals]
    own = [
        (forward, left)
        for forward, left in (view.to_own_frame(x, y) for x in places for y in places)
        if all(math.hypot(forward, left) <= math.hypot(forward - ahead, left - aside) for ahead, aside in rivals)
    ]
    if not own:
        return 0.0, 0.0
    return sum(forward for forward, _ in own) / len(own), sum(left for _, left in own) / len(own)
