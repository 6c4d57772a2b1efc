"""As prey: runs to where the nearest hunter will be farthest. Hunts as `nearest` does."""

import math
from typing import Final

from catch_arena.agents.nearest import Agent
from catch_arena.policy import PreyView, SeenBody

__all__ = ["Agent", "Prey"]

DIRECTIONS: Final = 24
"""How many are looked at, all round."""
AHEAD_S: Final = (0.4, 1.2)
"""At which times: soon, and when a wall may have stopped it."""
TURN_GAIN: Final = 6.0
"""Turn rate per radian of bearing [1/s]."""


class Prey:
    """Hunters are taken to drive straight on."""

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: PreyView) -> tuple[float, float]:
        """Speed and turn rate as parts of the limits, in [-1, 1]."""
        if not view.hunters:
            return 0.0, 0.0
        bearings = [2.0 * math.pi * number / DIRECTIONS - math.pi for number in range(DIRECTIONS)]
        return steer(max(bearings, key=lambda bearing: room_m(bearing, view)), view)


def room_m(bearing: float, view: PreyView) -> float:
    """How far the nearest hunter would be, at the times of AHEAD_S together, if it ran in that direction [m]."""
    heading, side = view.heading + bearing, view.limits.side_m
    total = 0.0
    for time_s in AHEAD_S:
        way = max(0.0, time_s - lost_s(bearing, view)) * view.limits.max_speed_mps
        x = min(max(view.x + way * math.cos(heading), 0.0), side)
        y = min(max(view.y + way * math.sin(heading), 0.0), side)
        place = view.to_own_frame(x, y)
        total += min(math.dist(place, moved(hunter, time_s)) for hunter in view.hunters)
    return total


def lost_s(bearing: float, view: PreyView) -> float:
    """What a turn costs it [s]: half of its time, since it drives on while it turns."""
    return 0.5 * abs(bearing) / view.limits.max_turn_rate_radps


def moved(body: SeenBody, time_s: float) -> tuple[float, float]:
    """Where a body is after that time, if it drives straight on: (forward, left) [m]."""
    way = body.linear_velocity * time_s
    return body.forward + way * body.heading_cos, body.left + way * body.heading_sin


def steer(bearing: float, view: PreyView) -> tuple[float, float]:
    """Flat out, while it turns to that bearing."""
    return 1.0, max(-1.0, min(1.0, TURN_GAIN * bearing / view.limits.max_turn_rate_radps))
