"""Chases the soonest race that it wins, turns counted."""

import math
from collections.abc import Iterable
from typing import Any

from catch_arena.batch_policy import BatchView
from catch_arena.policy import Limits, SeenHunter, SeenTarget, View


class Agent:
    """Like `contested`, with arrival times in place of distances."""

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: View) -> int:
        """The rank of the race that suits it best, or 0 (hold)."""
        target = best_race(view.targets, view)
        return 0 if target is None else target.rank

    def act_batch(self, view: BatchView) -> Any:
        """The same for N hunters: (N,)."""
        from catch_arena.training.scripted import contested_by_time  # a match must not wait for the compiler

        return contested_by_time(view)


def best_race(targets: Iterable[SeenTarget], view: View, lost_by_s: float = math.inf) -> SeenTarget | None:
    """The race that is soonest won; where none is won, the one that is lost by least; None where each is lost by
    `lost_by_s` or more, and where there is none.
    """
    soonest, closest = math.inf, lost_by_s
    won = lost = None
    for target in targets:
        mine = arrival_s(target.forward, target.left, view.limits)
        if mine >= soonest:
            continue
        late = mine - rivals_arrival_s(target, view)
        if late <= 0.0:
            won, soonest = target, mine
        elif late < closest:
            lost, closest = target, late
    return won or lost


def rivals_arrival_s(target: SeenTarget, view: View) -> float:
    """When the first of the visible rivals on the move could reach the target [s]; infinite without any."""
    racing = (rival for rival in view.rivals if rival.linear_velocity)  # who stands still races for nothing
    return min((rival_arrival_s(rival, target.forward, target.left, view.limits) for rival in racing), default=math.inf)


def rival_arrival_s(rival: SeenHunter, forward: float, left: float, limits: Limits) -> float:
    """How long a rival takes to a point [s], with one's own speed and turn rate: its own are not known."""
    dx, dy = forward - rival.forward, left - rival.left
    cosine, sine = rival.heading_cos, rival.heading_sin
    return arrival_s(cosine * dx + sine * dy, cosine * dy - sine * dx, limits)


def arrival_s(forward: float, left: float, limits: Limits) -> float:
    """How long a hunter takes to a point of its own frame [s]: the way at full speed, and what the turn costs."""
    way = max(0.0, math.hypot(forward, left) - limits.reach_m)
    turn = abs(math.atan2(left, forward))
    # half the turn: a hunter drives on while it turns
    return way / limits.max_speed_mps + 0.5 * turn / limits.max_turn_rate_radps
