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
from catch_arena.policy import SeenHunter, SeenTarget, View

DETOUR_S: Final = 0.4
"""How much more time it spends on what the leader wants than on another target."""


class Agent:
    """Where it leads itself, the strongest of its rivals is the one to hold back."""

    control = "velocity"

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: View) -> tuple[float, float]:
        """Speed and turn rate as parts of the limits, in [-1, 1]."""
        targets = worth_chasing(view)
        best = best_race(targets, view, lost_by_s(view.limits))
        wanted = wanted_target(targets, view)
        if wanted is not None and (best is None or mine_s(wanted, view) <= mine_s(best, view) + DETOUR_S):
            best = wanted
        return rest(view) if best is None else drive(*meeting_point(best, view), view)


def wanted_target(targets: tuple[SeenTarget, ...], view: View) -> SeenTarget | None:
    """What the leader reaches soonest, if this hunter is there before all others; None where there is no leader."""
    leader = leading_rival(view)
    if leader is None or not targets:
        return None
    wanted = min(targets, key=lambda target: rival_arrival_s(leader, target.forward, target.left, view.limits))
    return wanted if mine_s(wanted, view) <= rivals_arrival_s(wanted, view) else None


def leading_rival(view: View) -> SeenHunter | None:
    """Who has caught most of the visible rivals that are no team-mates and on the move; of equals the nearest."""
    rivals = [rival for rival in view.rivals if rival.linear_velocity and not rival.mate]
    return max(rivals, key=lambda rival: rival.score_difference, default=None)


def mine_s(target: SeenTarget, view: View) -> float:
    """When this hunter can be there [s]."""
    return arrival_s(target.forward, target.left, view.limits)
