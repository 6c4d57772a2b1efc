"""Catches the leader's next target first if the detour is small.

A view has each visible rival's lead in catches (`score_difference`, R7.1), so the leader among those in view is known.
In a duel of three (truel), each player does best to aim at the strongest: D. M. Kilgour, "The simultaneous truel",
International Journal of Game Theory 1 (1972). More than a small detour helps the other rivals more than this hunter.
"""

from typing import Final

from catch_arena.agents.contested_by_time import arrival_s, rival_arrival_s, rivals_arrival_s
from catch_arena.agents.triage import goal, race_worth_running, worth_chasing
from catch_arena.policy import SeenHunter, View
from catch_arena.steering import drive

DETOUR_S: Final = 0.4
"""Most extra time that it spends on the leader's target, compared with its own best target [s]."""


class Agent:
    """Agent that holds back the strongest rival in view, even if it leads itself."""

    control = "velocity"

    def reset(self, seed: int) -> None:
        """Do nothing: the agent keeps no state."""

    def act(self, view: View) -> tuple[float, float]:
        """Return speed and turn rate as fractions of the limits, in [-1, 1]."""
        ranks = worth_chasing(view)
        best = race_worth_running(ranks, view)
        wanted = wanted_target(ranks, view)
        if wanted and (not best or mine_s(wanted, view) <= mine_s(best, view) + DETOUR_S):
            best = wanted
        forward, left, rests = goal(best, view)
        return drive(forward, left, view.limits, rests)


def wanted_target(ranks: range, view: View) -> int:
    """Return the rank of the target that the leader reaches soonest; 0 without a leader, or if a rival is first."""
    leader = leading_rival(view)
    if leader is None or not ranks:
        return 0
    places = [(view.targets[rank - 1].forward, view.targets[rank - 1].left) for rank in ranks]
    times_s = [rival_arrival_s(leader, *place, view.limits) for place in places]
    soonest = times_s.index(min(times_s))
    return ranks[soonest] if mine_s(ranks[soonest], view) <= rivals_arrival_s(*places[soonest], view) else 0


def leading_rival(view: View) -> SeenHunter | None:
    """Return the moving rival in view with most catches, no team-mate; of equals the nearest; None if there is none."""
    rivals = [rival for rival in view.rivals if rival.linear_velocity and not rival.mate]
    return max(rivals, key=lambda rival: rival.score_difference, default=None)


def mine_s(rank: int, view: View) -> float:
    """Return the time at which this hunter can reach the target of a rank [s]."""
    return arrival_s(view.targets[rank - 1].forward, view.targets[rank - 1].left, view.limits)
