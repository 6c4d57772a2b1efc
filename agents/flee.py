"""Prey that runs in the direction that takes it farthest from the nearest hunter; hunts as `nearest` does."""

import math
from typing import Final

from catch_arena.agents.nearest import Agent
from catch_arena.policy import PreyView, SeenBody

__all__ = ["Agent", "Prey"]

BEARINGS: Final = tuple(2.0 * math.pi * number / 16 - math.pi for number in range(16))
"""Bearings that are compared, evenly spaced over the full circle [rad]."""
AHEAD_S: Final = (0.4, 1.2)
"""Times at which distances are compared [s]: soon, and when a wall may have stopped the prey."""
TURN_GAIN: Final = 6.0
"""Turn rate per radian of bearing [1/s]."""

Point = tuple[float, float]


class Prey:
    """Prey that assumes that hunters drive straight on."""

    def reset(self, seed: int) -> None:
        """Do nothing: the agent keeps no state."""

    def act(self, view: PreyView) -> tuple[float, float]:
        """Return speed and turn rate as fractions of the limits, in [-1, 1]."""
        if not view.hunters:
            return 0.0, 0.0
        later = [(time_s, [moved(hunter, time_s) for hunter in view.hunters]) for time_s in AHEAD_S]

        def room_m(bearing: float) -> float:
            """Return the distance to the nearest hunter [m], summed over the times of AHEAD_S."""
            return sum(
                min(math.dist(place, hunter) for hunter in hunters)
                for time_s, hunters in later
                for place in (place_after(bearing, time_s, view),)
            )

        return steer(max(BEARINGS, key=room_m), view)


def place_after(bearing: float, time_s: float, view: PreyView) -> Point:
    """Return the prey's place (forward, left) [m] after a time on a bearing; walls and half of the turn count."""
    limits, heading = view.limits, view.heading + bearing
    way = max(0.0, time_s - 0.5 * abs(bearing) / limits.max_turn_rate_radps) * limits.max_speed_mps
    x = min(max(view.x + way * math.cos(heading), 0.0), limits.side_m)
    y = min(max(view.y + way * math.sin(heading), 0.0), limits.side_m)
    return view.to_own_frame(x, y)


def moved(body: SeenBody, time_s: float) -> Point:
    """Return the place (forward, left) [m] of a body that drives straight on for a time."""
    way = body.linear_velocity * time_s
    return body.forward + way * body.heading_cos, body.left + way * body.heading_sin


def steer(bearing: float, view: PreyView) -> tuple[float, float]:
    """Return the command, as fractions of the limits, that turns to a bearing at full speed."""
    return 1.0, max(-1.0, min(1.0, TURN_GAIN * bearing / view.limits.max_turn_rate_radps))
