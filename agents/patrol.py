"""Drives itself at full speed to the target with the best race, or to the middle of its own ground."""

from typing import Any

from catch_arena.agents.contested_by_time import best_race
from catch_arena.batch_policy import BatchView
from catch_arena.geometry import is_nearer, own_frame
from catch_arena.policy import View
from catch_arena.steering import drive, spawn_at

GRID = 5
"""Points along each side of the grid that stands for the spawn area."""

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
    return drive(view.targets[rank - 1].forward, view.targets[rank - 1].left, view.limits) if rank else rest(view)


def rest(view: View) -> tuple[float, float]:
    """Return the command that brings the hunter to the middle of its own ground and keeps it there."""
    forward, left = middle_of_own_ground(view)
    return drive(forward, left, view.limits, rests=True)


def middle_of_own_ground(view: View) -> Point:
    """Return the mean (forward, left) [m] of the points of the spawn area that no rival is nearer to."""
    points, ahead, aside = 0, 0.0, 0.0
    for i in range(GRID):
        for j in range(GRID):
            dx, dy = spawn_at(i, GRID, view.limits) - view.x, spawn_at(j, GRID, view.limits) - view.y
            forward, left = own_frame(view.heading_cos, view.heading_sin, dx, dy)
            if is_own(forward, left, view):
                points, ahead, aside = points + 1, ahead + forward, aside + left
    return ahead / max(1, points), aside / max(1, points)


def is_own(forward: float, left: float, view: View) -> bool:
    """Return whether no rival is nearer to a point of the own frame."""
    for rival in view.rivals:  # noqa: SIM110 - Numba compiles no generators
        if is_nearer(rival, forward, left):
            return False
    return True
