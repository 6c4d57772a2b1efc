"""Drives itself to where a target will be: leads those that move."""

import math
from typing import Any, Final

from catch_arena.agents.contested_by_time import arrival_s
from catch_arena.agents.patrol import drive, middle_of_own_ground
from catch_arena.batch_policy import BatchView
from catch_arena.policy import SeenTarget, View

LOOKS: Final = 3
"""How often the time to a target and its place by then are found from one another."""
LONGEST_LEAD_S: Final = 1.5
"""Nobody knows where a target turns to after that."""


class Agent:
    """Under velocity control what is within reach is requested for it (R4.4)."""

    control = "velocity"

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: View) -> tuple[float, float]:
        """Speed and turn rate as parts of the limits, in [-1, 1]."""
        return decide(view)

    def act_batch(self, view: BatchView) -> Any:
        """The same for N hunters: (N, 2)."""
        from catch_arena.training.compiled import commands_for_each  # a match must not wait for the compiler

        return commands_for_each(decide, view)


def decide(view: View) -> tuple[float, float]:
    """The command for the target that costs least; without any, it keeps to its own ground."""
    best, least = 0, math.inf
    for place, target in enumerate(view.targets):
        cost = cost_s(target, view, least)
        if cost < least:
            best, least = place + 1, cost
    forward, left = meeting_point(view.targets[best - 1], view) if best else middle_of_own_ground(view)
    return drive(forward, left, view)


def meeting_point(target: SeenTarget, view: View) -> tuple[float, float]:
    """Where the hunter can meet a target that drives straight on: (forward, left) [m]."""
    forward, left = target.forward, target.left
    if not target.linear_velocity:
        return forward, left
    for _ in range(LOOKS):
        lead_s = min(LONGEST_LEAD_S, arrival_s(forward, left, view.limits))
        forward = target.forward + target.linear_velocity * target.heading_cos * lead_s
        left = target.left + target.linear_velocity * target.heading_sin * lead_s
    return forward, left


def cost_s(target: SeenTarget, view: View, most: float) -> float:
    """How soon the hunter meets a target [s], and how much later than the first rival; not counted on from `most`."""
    forward, left = meeting_point(target, view)
    mine = arrival_s(forward, left, view.limits, most)
    if mine >= most:
        return mine
    nearest = math.inf
    for rival in view.rivals:
        if rival.linear_velocity:
            nearest = min(nearest, math.hypot(forward - rival.forward, left - rival.left))
    return mine + 2.0 * max(0.0, mine - nearest / view.limits.max_speed_mps)
