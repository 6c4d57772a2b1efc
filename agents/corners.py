"""Prey that runs to the corner with the greatest lead over the nearest hunter; hunts as `contested` does."""

import math
from typing import Final

from catch_arena.agents.contested import Agent
from catch_arena.policy import PreyView
from catch_arena.steering import turn_towards

__all__ = ["Agent", "Prey"]

WALL_M: Final = 1.0
"""Distance of its corners from the walls [m]."""
ALARM_M: Final = 3.0
"""Least lead at its corner [m]; below it, the prey chooses a corner again."""

Point = tuple[float, float]


class Prey:
    """Prey that stays in a corner for as long as its lead is large enough."""

    def reset(self, seed: int) -> None:
        """Forget the chosen corner."""
        del seed
        self.corner: Point | None = None

    def act(self, view: PreyView) -> tuple[float, float]:
        """Return speed and turn rate as fractions of the limits, in [-1, 1]."""
        near, far = WALL_M, view.limits.side_m - WALL_M
        if self.corner is None or lead_m(self.corner, view) < ALARM_M:
            self.corner = max(
                ((x, y) for x in (near, far) for y in (near, far)), key=lambda corner: lead_m(corner, view)
            )
        forward, left = view.to_own_frame(*self.corner)
        return min(1.0, math.hypot(forward, left) / WALL_M), turn_towards(math.atan2(left, forward), view.limits)


def lead_m(corner: Point, view: PreyView) -> float:
    """Return the distance by which the prey is nearer to a corner than any hunter [m]; infinite without hunters."""
    place = view.to_own_frame(*corner)
    return min(
        (math.dist(place, (hunter.forward, hunter.left)) for hunter in view.hunters), default=math.inf
    ) - math.hypot(*place)
