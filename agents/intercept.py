"""Drives itself to the point at which it can meet a moving target."""

import math
from typing import Any, Final

from catch_arena.agents.contested_by_time import arrival_s
from catch_arena.agents.patrol import middle_of_own_ground
from catch_arena.batch_policy import BatchView
from catch_arena.geometry import place_after
from catch_arena.policy import SeenTarget, View
from catch_arena.steering import LONGEST_LEAD_S, drive

LOOKS: Final = 3
"""Number of iterations between the time to a target and the target's place at that time."""


class Agent:
    """Agent that only drives: under velocity control the arena requests what is within reach (R4.4)."""

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
    """Return the command for the target of lowest cost; without targets, for the middle of its own ground."""
    best, lowest_cost_s = 0, math.inf
    for place, target in enumerate(view.targets):
        cost = cost_s(target, view, lowest_cost_s)
        if cost < lowest_cost_s:
            best, lowest_cost_s = place + 1, cost
    forward, left = meeting_point(view.targets[best - 1], view) if best else middle_of_own_ground(view)
    return drive(forward, left, view.limits)


def meeting_point(target: SeenTarget, view: View) -> tuple[float, float]:
    """Return the point (forward, left) [m] at which the hunter can meet a target that drives straight on."""
    forward, left = target.forward, target.left
    if not target.linear_velocity:
        return forward, left
    for _ in range(LOOKS):
        forward, left = place_after(target, min(LONGEST_LEAD_S, arrival_s(forward, left, view.limits)))
    return forward, left


def cost_s(target: SeenTarget, view: View, limit_s: float) -> float:
    """Return the time to meet a target plus twice the delay after a rival [s]; just the time if it is >= `limit_s`."""
    forward, left = meeting_point(target, view)
    own_s = arrival_s(forward, left, view.limits, limit_s)
    if own_s >= limit_s:
        return own_s
    nearest = math.inf
    for rival in view.rivals:
        if rival.linear_velocity:
            nearest = min(nearest, math.hypot(forward - rival.forward, left - rival.left))
    return own_s + 2.0 * max(0.0, own_s - nearest / view.limits.max_speed_mps)
