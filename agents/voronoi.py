"""Chases targets that it reaches before all rivals, and prefers those with more such targets nearby.

T. Taki, J. Hasegawa, "Visualization of dominant region in team games and its application to teamwork analysis",
Computer Graphics International (2000): a Voronoi cell by arrival times in place of distances. With nothing in view it
waits in the middle of its own ground: J. Cortés and others, "Coverage control for mobile sensing networks", IEEE
Transactions on Robotics and Automation 20 (2004).
"""

import math
from typing import Final

from catch_arena.agents.contested_by_time import arrival_s, rivals_arrival_s
from catch_arena.agents.intercept import meeting_point
from catch_arena.agents.patrol import Point
from catch_arena.agents.triage import race_or_rest, worth_chasing
from catch_arena.policy import View
from catch_arena.steering import drive

COMPANY_M: Final = 1.5
"""Distance over which the worth of another target nearby falls to 1/e [m]."""
COMPANY_S: Final = 0.3
"""Detour that another target in the same place is worth [s]."""


class Agent:
    """Agent for which a target in its dominant region is worth more if others of that region are near."""

    control = "velocity"

    def reset(self, seed: int) -> None:
        """Do nothing: the agent keeps no state."""

    def act(self, view: View) -> tuple[float, float]:
        """Return speed and turn rate as fractions of the limits, in [-1, 1]."""
        ranks = worth_chasing(view)
        places = [meeting_point(view.targets[rank - 1], view) for rank in ranks]
        own = [place for place in places if is_own(place, view)]
        if not own:
            return race_or_rest(ranks, view)
        return drive(*min(own, key=lambda place: cost_s(place, own, view)), view.limits)


def is_own(place: Point, view: View) -> bool:
    """Return whether no moving rival reaches a place sooner."""
    return rivals_arrival_s(*place, view) >= arrival_s(*place, view.limits)


def cost_s(place: Point, own: list[Point], view: View) -> float:
    """Return the time to a target [s], less the worth of other own targets near it."""
    company = sum(math.exp(-math.dist(place, other) / COMPANY_M) for other in own)
    return arrival_s(*place, view.limits) - COMPANY_S * company
