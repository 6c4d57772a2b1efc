"""Drives itself like `patrol`, and wastes no way on targets that are as good as caught or as good as lost."""

import math
from typing import Any, Final

from catch_arena.agents.contested_by_time import best_race
from catch_arena.agents.intercept import meeting_point
from catch_arena.agents.patrol import drive, rest
from catch_arena.batch_policy import BatchView
from catch_arena.policy import Limits, SeenTarget, View

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
        return race_or_rest(worth_chasing(view), view)

    def act_batch(self, view: BatchView) -> Any:
        """The same for N hunters: (N, 2)."""
        from catch_arena.training.scripted import triage  # a match must not wait for the compiler

        return triage(view)


def race_or_rest(targets: tuple[SeenTarget, ...], view: View) -> tuple[float, float]:
    """The command for the race that suits it best; where none is worth it, it waits on its own ground."""
    target = best_race(targets, view, lost_by_s(view.limits))
    return rest(view) if target is None else drive(*meeting_point(target, view), view)


def lost_by_s(limits: Limits) -> float:
    """By how much a race may be lost and yet be run [s]; by any where targets flee: they turn away from rivals too."""
    return math.inf if limits.alarm_m or limits.prey else LOST_BY_S


def worth_chasing(view: View) -> tuple[SeenTarget, ...]:
    """The targets in view, without the nearest where that is as good as caught."""
    targets = view.targets
    return targets[1:] if targets and as_good_as_caught(targets[0], view) else targets


def as_good_as_caught(target: SeenTarget, view: View) -> bool:
    """Whether the nearest target is caught by this hunter in this very step: it is within reach, and nobody is nearer
    to it (R5.9).
    """
    distance = target.distance
    return distance < view.limits.reach_m and all(rival.distance_to(target) > distance for rival in view.rivals)
