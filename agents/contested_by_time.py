"""Chases the soonest target that it reaches before all rivals, turns counted."""

import math
from typing import Any

from catch_arena.batch_policy import BatchView
from catch_arena.geometry import own_frame
from catch_arena.policy import Limits, SeenHunter, View
from catch_arena.steering import travel_s


class Agent:
    """Agent like `contested`, with arrival times in place of distances."""

    def reset(self, seed: int) -> None:
        """Do nothing: the agent keeps no state."""

    def act(self, view: View) -> int:
        """Return the rank of the target with the best race, or 0 (hold)."""
        return choose(view)

    def act_batch(self, view: BatchView) -> Any:
        """Return the choices of N hunters, (N,); `act` makes the same choice for one."""
        from catch_arena.training.compiled import ranks_for_each  # a match must not wait for the compiler

        return ranks_for_each(choose, view)


def choose(view: View) -> int:
    """Return the rank of the target with the best race of all in view, or 0 without targets."""
    return best_race(range(1, len(view.targets) + 1), view)


def best_race(ranks: range, view: View, lost_by_s: float = math.inf) -> int:
    """Return the rank, among the given ones, of the race that is won soonest.

    If no race is won, it is the one that is lost by least; 0 if each is lost by `lost_by_s` or more, or without ranks.
    """
    soonest, closest = math.inf, lost_by_s
    won = lost = 0
    for rank in ranks:
        forward, left = view.targets[rank - 1].forward, view.targets[rank - 1].left
        own_s = arrival_s(forward, left, view.limits, soonest)
        if own_s >= soonest:
            continue
        late = own_s - rivals_arrival_s(forward, left, view, own_s)
        if late <= 0.0:
            won, soonest = rank, own_s
        elif late < closest:
            lost, closest = rank, late
    return won or lost


def rivals_arrival_s(forward: float, left: float, view: View, own_s: float = math.inf) -> float:
    """Return the soonest time at which a visible, moving rival could reach a point [s]; `own_s` if none is sooner."""
    soonest = own_s
    for rival in view.rivals:
        if rival.linear_velocity:  # a rival that stands still races for nothing
            soonest = min(soonest, rival_arrival_s(rival, forward, left, view.limits, soonest))
    return soonest


def rival_arrival_s(rival: SeenHunter, forward: float, left: float, limits: Limits, soonest: float = math.inf) -> float:
    """Return the time that a rival takes to a point [s]; its limits are unknown, so the hunter's own are used."""
    ahead, aside = own_frame(rival.heading_cos, rival.heading_sin, forward - rival.forward, left - rival.left)
    return arrival_s(ahead, aside, limits, soonest)


def arrival_s(forward: float, left: float, limits: Limits, soonest: float = math.inf) -> float:
    """Return the time until a point of the own frame is within reach of a hunter [s], see `travel_s`.

    If the way alone takes `soonest` or longer, the race is lost anyway, and the turn is not counted.
    """
    way = max(0.0, math.hypot(forward, left) - limits.reach_m)
    if way / limits.max_speed_mps >= soonest:
        return way / limits.max_speed_mps
    return travel_s(way, math.atan2(left, forward), limits)
