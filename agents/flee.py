"""As prey: runs to where the nearest hunter will be farthest. Hunts as `nearest` does."""

import math
from typing import Final

from catch_arena.agents.nearest import Agent
from catch_arena.policy import PreyView, SeenBody

__all__ = ["Agent", "Prey"]

BEARINGS: Final = tuple(2.0 * math.pi * number / 16 - math.pi for number in range(16))
"""The directions that are looked at, all round [rad]."""
AHEAD_S: Final = (0.4, 1.2)
"""At which times: soon, and when a wall may have stopped it."""
TURN_GAIN: Final = 6.0
"""Turn rate per radian of bearing [1/s]."""

Point = tuple[float, float]


class Prey:
    """Hunters are taken to drive straight on."""

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: PreyView) -> tuple[float, float]:
        """Speed and turn rate as parts of the limits, in [-1, 1]."""
        if not view.hunters:
            return 0.0, 0.0
        later = [(time_s, [moved(hunter, time_s) for hunter in view.hunters]) for time_s in AHEAD_S]

        def room_m(bearing: float) -> float:
            """How far the nearest hunter would be [m], at all these times together."""
            return sum(
                min(math.dist(place, hunter) for hunter in hunters)
                for time_s, hunters in later
                for place in (place_after(bearing, time_s, view),)
            )

        return steer(max(BEARINGS, key=room_m), view)


def place_after(bearing: float, time_s: float, view: PreyView) -> Point:
    """Where it is after that time if it runs in that direction, walls and half of the turn's time counted: (forward,
    left) [m].
    """
    limits, heading = view.limits, view.heading + bearing
    way = max(0.0, time_s - 0.5 * abs(bearing) / limits.max_turn_rate_radps) * limits.max_speed_mps
    x = min(max(view.x + way * math.cos(heading), 0.0), limits.side_m)
    y = min(max(view.y + way * math.sin(heading), 0.0), limits.side_m)
    return view.to_own_frame(x, y)


def moved(body: SeenBody, time_s: float) -> Point:
    """Where a body is after that time, if it drives straight on: (forward, left) [m]."""
    way = body.linear_velocity * time_s
    return body.forward + way * body.heading_cos, body.left + way * body.heading_sin


def steer(bearing: float, view: PreyView) -> tuple[float, float]:
    """Flat out, while it turns to that bearing."""
    return 1.0, max(-1.0, min(1.0, TURN_GAIN * bearing / view.limits.max_turn_rate_radps))
