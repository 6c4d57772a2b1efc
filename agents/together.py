"""Goes with its team-mates to the target that enough of them reach soonest, and waits for them there."""

import math
from typing import Any, Final

from catch_arena.agents.contested_by_time import arrival_s, rival_arrival_s
from catch_arena.agents.intercept import meeting_point
from catch_arena.agents.patrol import middle_of_own_ground
from catch_arena.batch_policy import BatchView
from catch_arena.policy import View
from catch_arena.steering import drive

ALONE_S: Final = 1e3
"""Time added to every target if too few team-mates are in view, so that the soonest one is still chosen [s]."""


class Agent:
    """Agent for scenarios in which a catch needs several hunters of one team (R5.10)."""

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
    """Return the command for the target at which the last of the hunters that a catch needs is soonest."""
    best, soonest_s = 0, math.inf
    for place, target in enumerate(view.targets):
        forward, left = meeting_point(target, view)
        last_s = max(arrival_s(forward, left, view.limits), last_partner_s(forward, left, view))
        if last_s < soonest_s:
            best, soonest_s = place + 1, last_s
    if best == 0:
        forward, left = middle_of_own_ground(view)
        return drive(forward, left, view.limits)
    forward, left = meeting_point(view.targets[best - 1], view)
    waits = arrival_s(forward, left, view.limits) < soonest_s and not view.limits.targets_move
    return drive(forward, left, view.limits, waits)


def last_partner_s(forward: float, left: float, view: View) -> float:
    """Return the time at which as many team-mates as a catch needs besides the hunter can be at a point [s]."""
    needed = view.limits.hunters_per_catch - 1
    if needed < 1:
        return 0.0
    for place, mate in enumerate(view.rivals):
        if mate.mate:
            own_s = rival_arrival_s(mate, forward, left, view.limits)
            sooner = 0
            for other_place, other in enumerate(view.rivals):
                if other.mate:
                    other_s = rival_arrival_s(other, forward, left, view.limits)
                    if other_s < own_s or (other_s == own_s and other_place < place):
                        sooner += 1
            if sooner == needed - 1:
                return own_s
    return ALONE_S
