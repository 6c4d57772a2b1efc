"""Takes away what the leader wants next, where it is there first and the detour is small.

A view says how much more each visible rival has caught (`score_difference`, R7.1), so among those in view the leader is
known. Of three who shoot at each other each does best to aim at the strongest: D. M. Kilgour, "The simultaneous truel",
International Journal of Game Theory 1 (1972). What costs more than a small detour helps the others more than oneself.
"""

from typing import Final

from catch_arena.agents.contested_by_time import arrival_s, best_race, rival_arrival_s, rivals_arrival_s
from catch_arena.agents.intercept import meeting_point
from catch_arena.agents.patrol import drive, rest
from catch_arena.agents.triage import lost_by_s, worth_chasing
from catch_arena.policy import SeenHunter, View

DETOUR_S: Final = 0.4
"""How much more time it spends on what the leader wants than on another target."""


class Agent:
    """Where it leads itself, the strongest of its rivals is the one to hold back."""

    control = "velocity"

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: View) -> tuple[float, float]:
        """Speed and turn rate as parts of the limits, in [-1, 1]."""
        ranks = worth_chasing(view)
        best = best_race(ranks, view, lost_by_s(view.limits))
        wanted = wanted_target(ranks, view)
        if wanted and (not best or mine_s(wanted, view) <= mine_s(best, view) + DETOUR_S):
            best = wanted
        return drive(*meeting_point(view.targets[best - 1], view), view) if best else rest(view)


def wanted_target(ranks: range, view: View) -> int:
    """What the leader reaches soonest, if this hunter is there before all others; 0 where there is no leader."""
    leader = leading_rival(view)
    if leader is None or not ranks:
        return 0
    places = [(view.targets[rank - 1].forward, view.targets[rank - 1].left) for rank in ranks]
    times_s = [rival_arrival_s(leader, *place, view.limits) for place in places]
    soonest = times_s.index(min(times_s))
    return ranks[soonest] if mine_s(ranks[soonest], view) <= rivals_arrival_s(*places[soonest], view) else 0


def leading_rival(view: View) -> SeenHunter | None:
    """Who has caught most of the visible rivals that are no team-mates and on the move; of equals the nearest."""
    rivals = [rival for rival in view.rivals if rival.linear_velocity and not rival.mate]
    return max(rivals, key=lambda rival: rival.score_difference, default=None)


def mine_s(rank: int, view: View) -> float:
    """When this hunter can be there [s]."""
    return arrival_s(view.targets[rank - 1].forward, view.targets[rank - 1].left, view.limits)
