"""Chases the nearest target that no rival is nearer to."""

import math
from typing import Any

from catch_arena.batch_policy import BatchView
from catch_arena.policy import View


class Agent:
    """Agent that compares distances only; `contested_by_time` counts the turn as well."""

    def reset(self, seed: int) -> None:
        """Do nothing: the agent keeps no state."""

    def act(self, view: View) -> int:
        """Return the rank of a target, or 0 (hold)."""
        return choose(view)

    def act_batch(self, view: BatchView) -> Any:
        """Return the choices of N hunters, (N,); `act` makes the same choice for one."""
        from catch_arena.training.compiled import ranks_for_each  # a match must not wait for the compiler

        return ranks_for_each(choose, view)


def choose(view: View) -> int:
    """Return the rank of the nearest target that no rival is nearer to, else of the least deficit; 0 if none."""
    choice, lowest_deficit = 0, math.inf
    for place, target in enumerate(view.targets):
        distance = math.hypot(target.forward, target.left)
        deficit = distance - nearest_rival_m(target.forward, target.left, view)
        if deficit <= 0.0:
            return place + 1
        if deficit < lowest_deficit:
            choice, lowest_deficit = place + 1, deficit
    return choice


def nearest_rival_m(forward: float, left: float, view: View) -> float:
    """Return the distance [m] from a point of the own frame to its nearest rival; infinite without rivals."""
    nearest = math.inf
    for rival in view.rivals:
        nearest = min(nearest, math.hypot(forward - rival.forward, left - rival.left))
    return nearest
