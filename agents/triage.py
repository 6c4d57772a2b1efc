"""Drives itself like `patrol`, but not to targets that are as good as caught or as good as lost."""

import math
from typing import Any, Final

from catch_arena.agents.contested import nearest_rival_m
from catch_arena.agents.contested_by_time import best_race
from catch_arena.agents.intercept import meeting_point
from catch_arena.agents.patrol import middle_of_own_ground
from catch_arena.batch_policy import BatchView
from catch_arena.policy import View
from catch_arena.steering import drive

LOST_BY_S: Final = 0.4
"""Least lead of a rival at which a race is not run [s]; rivals seldom turn away."""


class Agent:
    """Agent that chases only targets for which its effort changes the result (triage).

    `patrol` drives on to a target within reach, although the arena requests that target already (R4.4). In half of its
    steps `patrol` runs a race that it cannot win.
    """

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
    """Return the command for the best race that is worth running, else for a place to wait."""
    return race_or_rest(worth_chasing(view), view)


def race_or_rest(ranks: range, view: View) -> tuple[float, float]:
    """Return the command for the best race among these ranks; if none is worth running, to wait on its own ground."""
    forward, left, rests = goal(race_worth_running(ranks, view), view)
    return drive(forward, left, view.limits, rests)


def goal(rank: int, view: View) -> tuple[float, float, bool]:
    """Return the point (forward, left) [m] to go to for a rank, and whether to rest there: only on the own ground."""
    if rank == 0:
        forward, left = middle_of_own_ground(view)
        return forward, left, True
    forward, left = meeting_point(view.targets[rank - 1], view)
    return forward, left, False


def race_worth_running(ranks: range, view: View) -> int:
    """Return the rank, among the given ones, of the best race, or 0 if each is lost by LOST_BY_S or more.

    If targets flee, no race is lost by too much, since they turn from rivals too.
    """
    flee = view.limits.alarm_m or view.limits.prey
    return best_race(ranks, view, math.inf if flee else LOST_BY_S)


def worth_chasing(view: View) -> range:
    """Return the ranks of the targets in view, without the nearest if that is as good as caught."""
    return range(2 if as_good_as_caught(view) else 1, len(view.targets) + 1)


def as_good_as_caught(view: View) -> bool:
    """R5.9: return whether this hunter catches the nearest target in this step: in reach, and nearer than rivals."""
    if len(view.targets) == 0:
        return False
    forward, left = view.targets[0].forward, view.targets[0].left
    distance = math.hypot(forward, left)
    return distance < view.limits.reach_m and distance < nearest_rival_m(forward, left, view)
