"""R7.5: targets that each hunter saw, and the reasons why it did not see the others."""

import math
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.core.arbiter import measure_um
from catch_arena.core.math import sincos
from catch_arena.core.state import SeatLimits
from catch_arena.core.visibility import is_seen
from catch_arena.engine.core_settings import limits_by_seat, settings_of
from catch_arena.world import World


@dataclass(frozen=True, slots=True)
class Unseen:
    """A target that a hunter did not see."""

    target: str
    distance_um: int
    off_heading_deg: float
    """Angle between the hunter's heading and the target's direction [degrees], 0 to 180."""
    too_far: bool
    """True if the target was not within view_radius_m."""
    outside_cone: bool
    """True if the target was not within the cone of view_angle_deg."""


class SeenTargets:
    """Visibility of targets in the arenas of a config."""

    def __init__(self, config: ArenaConfig) -> None:
        self._config = config
        self._settings = settings_of(config, with_parts=False)
        self._reach_limits_m2 = limits_by_seat(config)[:, SeatLimits._fields.index("reach_limit_m2")].tolist()

    def of(self, world: World, seat: int) -> NDArray[np.bool_]:
        """Return whether a seat sees each target: (targets,), in the order of `world.targets`. A withdrawn hunter
        counts like an active one in its place.
        """
        me = world.hunters[seat]
        x, y = np.array([(target.x, target.y) for target in world.targets]).reshape(-1, 2).T
        sine, cosine = sincos(me.theta)
        # the core's rule takes arrays, too, since it branches on the settings alone
        rule = cast("Any", is_seen)
        return cast(
            "NDArray[np.bool_]", rule(x - me.x, y - me.y, sine, cosine, self._reach_limits_m2[seat], self._settings)
        )

    def unseen(self, world: World, seat: int) -> list[Unseen]:
        """Return the targets out of a seat's sight, the nearest first."""
        config, me, found = self._config, world.hunters[seat], []
        for target, seen in zip(world.targets, self.of(world, seat), strict=True):
            if seen:
                continue
            um = int(measure_um(target.x - me.x, target.y - me.y))
            off = math.remainder(math.atan2(target.y - me.y, target.x - me.x) - me.theta, 2.0 * math.pi)
            too_far = config.view_radius_um is not None and um >= config.view_radius_um
            # a target within the radius can only be outside the cone
            outside = not too_far or abs(math.degrees(off)) > config.view_angle_deg / 2.0
            found.append(Unseen(target.name, um, abs(math.degrees(off)), too_far, outside))
        return sorted(found, key=lambda target: target.distance_um)
