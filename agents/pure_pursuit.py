"""Drives arcs to a lookahead point on the straight line to its goal (pure pursuit).

R. C. Coulter, "Implementation of the pure pursuit path tracking algorithm", Carnegie Mellon University, CMU-RI-TR-92-01
(1992). The goal is chosen as by `triage`. Pure pursuit is the controller that most robots begin with.
"""

import math
from typing import Final

from catch_arena.agents.patrol import Point
from catch_arena.agents.triage import goal, race_worth_running, worth_chasing
from catch_arena.policy import Limits, View
from catch_arena.steering import braked

LOOKAHEAD_M: Final = 0.8
"""Distance to the lookahead point [m]: if less, the hunter stops to turn; if more, it arrives in wide arcs."""


class Agent:
    """Agent whose path is the straight line to the goal, planned again in each step."""

    control = "velocity"

    def reset(self, seed: int) -> None:
        """Do nothing: the agent keeps no state."""

    def act(self, view: View) -> tuple[float, float]:
        """Return speed and turn rate as fractions of the limits, in [-1, 1]."""
        forward, left, rests = goal(race_worth_running(worth_chasing(view), view), view)
        speed, turn = follow(lookahead_point((forward, left)), view.limits)
        return braked(speed, math.hypot(forward, left), view.limits) if rests else speed, turn


def lookahead_point(place: Point) -> Point:
    """Return the point (forward, left) [m] of the path at the lookahead distance, or the goal if that is nearer."""
    share = min(1.0, LOOKAHEAD_M / max(1e-9, math.hypot(*place)))
    return share * place[0], share * place[1]


def follow(point: Point, limits: Limits) -> tuple[float, float]:
    """Return the fastest command for the arc that leaves along the heading and passes through a point."""
    forward, left = point
    squared = forward * forward + left * left
    if squared == 0.0:
        return 0.0, 0.0
    if forward <= 0.0:
        return 0.0, math.copysign(1.0, left)  # no arc leads to a point at the back: turn on the spot
    curvature = 2.0 * left / squared
    speed_mps = min(limits.max_speed_mps, limits.max_turn_rate_radps / max(1e-9, abs(curvature)))
    turn = speed_mps * curvature / limits.max_turn_rate_radps
    return speed_mps / limits.max_speed_mps, max(-1.0, min(1.0, turn))
