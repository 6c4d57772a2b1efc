"""Times and commands of a hunter that drives to a point, for agents in agents/ and for trained networks.

Compiled agents call these functions too: catch_arena/training/compiled.py says what they may contain. Functions of a
`Number` take arrays as well.
"""

import math
from typing import Final

from catch_arena.geometry import Number
from catch_arena.policy import AnyLimits, Limits

TYPE_CHECKING = False  # agents that do not use NumPy need not load it
if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

TURN_GAIN: Final = 6.0
"""Turn rate per radian of bearing [1/s]. Trained networks drive with this gain and the next."""
BRAKE_GAIN: Final = 2.0
"""Speed per metre of distance to a resting place [1/s]."""
LONGEST_LEAD_S: Final = 1.5
"""Longest time for which a target is assumed to drive straight on [s]; later turns are unknown."""
SPAWN_LOW_M: Final = 0.5
SPAWN_WALL_M: Final = 0.5889
"""R3.2: distance of spawns from the walls opposite those at 0 [m]; SPAWN_LOW_M is that from the walls at 0.

It is rounded. engine/core_settings.py has all digits, but with those agents could decide differently than when they
were rated.
"""


def travel_s(way: Number, bearing: Number, limits: Limits) -> Number:
    """Return the time for a way [m] that begins with a turn by a bearing [s]: at full speed, plus half of the turn.

    Only half counts, since a hunter drives on while it turns.
    """
    return way / limits.max_speed_mps + 0.5 * abs(bearing) / limits.max_turn_rate_radps


def arc_speed_mps(distance: Number, sine: Number, limits: Limits) -> Number:
    """Return the fastest speed [m/s] on the circle that is tangent to the heading and passes half a reach from a point.

    The point is at a distance [m] and at a bearing whose sine has this absolute value, above 0.
    """
    diameter = (distance + limits.reach_m / 2) / sine
    return limits.max_turn_rate_radps * diameter / 2


def spawn_at(number: Number, points: int, limits: Limits) -> Number:
    """R3.2: return a coordinate [m] in a grid of points x points over the spawn area, by its number from 0."""
    step = (limits.side_m - SPAWN_LOW_M - SPAWN_WALL_M) / points
    return SPAWN_LOW_M + (number + 0.5) * step


def drive(forward: float, left: float, limits: Limits, rests: bool = False) -> tuple[float, float]:
    """Return the command that brings a point of the own frame [m] within reach, as fast as the arc allows.

    With `rests` the hunter slows down before the point, and stays there.
    """
    distance, bearing = math.hypot(forward, left), math.atan2(left, forward)
    turn = turn_towards(bearing, limits)
    if abs(bearing) >= math.pi / 2:
        return 0.0, turn  # driving would only increase the distance
    speed = min(1.0, arc_speed_mps(distance, max(1e-6, abs(math.sin(bearing))), limits) / limits.max_speed_mps)
    return braked(speed, distance, limits) if rests else speed, turn


def turn_towards(bearing: float, limits: AnyLimits) -> float:
    """Return the turn rate, as a fraction of the limit, for a point at a bearing [rad]."""
    return max(-1.0, min(1.0, TURN_GAIN * bearing / limits.max_turn_rate_radps))


def braked(speed: float, distance: float, limits: Limits) -> float:
    """Return a speed, as a fraction of the limit, at which a hunter comes to rest at a distance [m]."""
    return min(speed, BRAKE_GAIN * distance / limits.max_speed_mps)


def drive_each(
    forward: "NDArray[np.float64]", left: "NDArray[np.float64]", rests: "NDArray[np.bool_]", limits: Limits
) -> "NDArray[np.float64]":
    """Return the commands of N hunters, (N, 2), each by `drive` to its point and with its `rests`: (N,) each."""
    import numpy as np

    points = zip(forward.tolist(), left.tolist(), rests.tolist(), strict=True)
    commands = [drive(ahead, aside, limits, stays) for ahead, aside, stays in points]
    return np.array(commands, np.float64).reshape(-1, 2)
