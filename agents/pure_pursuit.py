"""Drives arcs to a point that runs ahead of it along its path: to the race that suits it best, and on to the next target.

R. C. Coulter, "Implementation of the pure pursuit path tracking algorithm", Carnegie Mellon University, CMU-RI-TR-92-01
(1992). Where to drive to is chosen as by `triage`; how to drive is the controller that most robots begin with.
"""

import math
from typing import Final

from catch_arena.agents.contested_by_time import best_race
from catch_arena.agents.intercept import meeting_point
from catch_arena.agents.patrol import Point, middle_of_own_ground
from catch_arena.agents.triage import LOST_BY_S, worth_chasing
from catch_arena.policy import Limits, View

LOOKAHEAD_M: Final = 0.8
"""How far ahead of it that point runs: nearer, and it turns sharply; farther, and it cuts corners."""
BRAKE_GAIN: Final = 2.0
"""Speed per metre that is left to the end of the path [1/s]."""


class Agent:
    """Its path is two straight lines, planned anew in each step."""

    control = "velocity"

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: View) -> tuple[float, float]:
        """Speed and turn rate as parts of the limits, in [-1, 1]."""
        targets = worth_chasing(view)
        first = best_race(targets, view, LOST_BY_S)
        if first is None:
            goal = middle_of_own_ground(view)
            speed, turn = follow(goal, view.limits)
            return min(speed, BRAKE_GAIN * math.hypot(*goal) / view.limits.max_speed_mps), turn
        goal = meeting_point(first, view)
        others = [meeting_point(target, view) for target in targets if target is not first]
        then = min(others, key=lambda other: math.dist(goal, other), default=goal)
        return follow(lookahead_point(goal, then), view.limits)


def lookahead_point(goal: Point, then: Point) -> Point:
    """The point of the path, by way of one place to another, that is the lookahead distance away along it; the end of
    the path where that is nearer: (forward, left) [m].
    """
    first, second = math.hypot(*goal), math.dist(goal, then)
    if first >= LOOKAHEAD_M:
        return goal[0] * LOOKAHEAD_M / first, goal[1] * LOOKAHEAD_M / first
    share = min(1.0, (LOOKAHEAD_M - first) / second) if second > 0.0 else 0.0
    return goal[0] + share * (then[0] - goal[0]), goal[1] + share * (then[1] - goal[1])


def follow(point: Point, limits: Limits) -> tuple[float, float]:
    """The command for the arc that leaves along the heading and passes through a point, as fast as it can be driven."""
    forward, left = point
    squared = forward * forward + left * left
    if squared == 0.0:
        return 0.0, 0.0
    if forward <= 0.0:
        return 0.0, math.copysign(1.0, left)  # no arc to what lies behind: it turns on the spot
    curvature = 2.0 * left / squared
    speed_mps = min(limits.max_speed_mps, limits.max_turn_rate_radps / max(1e-9, abs(curvature)))
    turn = speed_mps * curvature / limits.max_turn_rate_radps
    return speed_mps / limits.max_speed_mps, max(-1.0, min(1.0, turn))
