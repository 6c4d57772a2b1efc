"""Chases the soonest race that it wins, turns counted."""

import math
from typing import Any

from catch_arena.batch_policy import BatchView
from catch_arena.policy import Limits, SeenHunter, View


class Agent:
    """Like `contested`, with arrival times in place of distances."""

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: View) -> int:
        """The rank of the race that suits it best, or 0 (hold)."""
        return choose(view)

    def act_batch(self, view: BatchView) -> Any:
        """The same for N hunters: (N,)."""
        from catch_arena.training.compiled import ranks_for_each  # a match must not wait for the compiler

        return ranks_for_each(choose, view)


def choose(view: View) -> int:
    """The best of all races in view."""
    return best_race(range(1, len(view.targets) + 1), view)


def best_race(ranks: range, view: View, lost_by_s: float = math.inf) -> int:
    """The target, among these ranks, whose race is soonest won; where none is won, the one that is lost by least; 0
    where each is lost by `lost_by_s` or more, and where there is none.
    """
    soonest, closest = math.inf, lost_by_s
    won = lost = 0
    for rank in ranks:
        forward, left = view.targets[rank - 1].forward, view.targets[rank - 1].left
        mine = arrival_s(forward, left, view.limits, soonest)
        if mine >= soonest:
            continue
        late = mine - rivals_arrival_s(forward, left, view, mine)
        if late <= 0.0:
            won, soonest = rank, mine
        elif late < closest:
            lost, closest = rank, late
    return won or lost


def rivals_arrival_s(forward: float, left: float, view: View, mine: float = math.inf) -> float:
    """When the first of the visible rivals on the move could reach a point [s]; `mine` where none is sooner."""
    soonest = mine
    for rival in view.rivals:
        if rival.linear_velocity:  # who stands still races for nothing
            soonest = min(soonest, rival_arrival_s(rival, forward, left, view.limits, soonest))
    return soonest


def rival_arrival_s(rival: SeenHunter, forward: float, left: float, limits: Limits, soonest: float = math.inf) -> float:
    """How long a rival takes to a point [s], with one's own speed and turn rate: its own are not known."""
    dx, dy = forward - rival.forward, left - rival.left
    cosine, sine = rival.heading_cos, rival.heading_sin
    return arrival_s(cosine * dx + sine * dy, cosine * dy - sine * dx, limits, soonest)


def arrival_s(forward: float, left: float, limits: Limits, soonest: float = math.inf) -> float:
    """How long a hunter takes to a point of its own frame [s]: the way at full speed, and what the turn costs. The turn
    is not counted where the way alone takes as long as `soonest`, so that the race is lost anyway.
    """
    way = max(0.0, math.hypot(forward, left) - limits.reach_m) / limits.max_speed_mps
    if way >= soonest:
        return way
    # half the turn: a hunter drives on while it turns
    return way + 0.5 * abs(math.atan2(left, forward)) / limits.max_turn_rate_radps
