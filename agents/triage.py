"""Drives itself like `patrol`, and wastes no way on targets that are as good as caught or as good as lost."""

import math
from typing import Any, Final

from catch_arena.agents.contested import nearest_rival_m
from catch_arena.agents.contested_by_time import best_race
from catch_arena.agents.intercept import meeting_point
from catch_arena.agents.patrol import drive, rest
from catch_arena.batch_policy import BatchView
from catch_arena.policy import Limits, View

LOST_BY_S: Final = 0.4
"""A race that a rival wins by more than this is not run: rivals seldom turn away."""


class Agent:
    """Triage sorts by what effort can change. `patrol` drives on at what it has within reach, though the request for
    that is made already (R4.4), and in half of its steps it runs a race that it cannot win.
    """

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
    """The command for the best race that is worth it."""
    return race_or_rest(worth_chasing(view), view)


def race_or_rest(ranks: range, view: View) -> tuple[float, float]:
    """The command for the race that suits it best, among these ranks; where none is worth it, it waits on its own
    ground.
    """
    rank = best_race(ranks, view, lost_by_s(view.limits))
    if rank == 0:
        return rest(view)
    forward, left = meeting_point(view.targets[rank - 1], view)
    return drive(forward, left, view)


def lost_by_s(limits: Limits) -> float:
    """By how much a race may be lost and yet be run [s]; by any where targets flee: they turn away from rivals too."""
    return math.inf if limits.alarm_m or limits.prey else LOST_BY_S


def worth_chasing(view: View) -> range:
    """The ranks of the targets in view, without the nearest where that is as good as caught."""
    return range(2 if as_good_as_caught(view) else 1, len(view.targets) + 1)


def as_good_as_caught(view: View) -> bool:
    """Whether the nearest target is caught by this hunter in this very step: it is within reach, and nobody is nearer
    to it (R5.9).
    """
    if len(view.targets) == 0:
        return False
    forward, left = view.targets[0].forward, view.targets[0].left
    distance = math.hypot(forward, left)
    return distance < view.limits.reach_m and distance < nearest_rival_m(forward, left, view)
