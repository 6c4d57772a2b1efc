"""R7.5: targets that a hunter did not see, and the reasons."""

import math
from dataclasses import dataclass

from catch_arena.config import ArenaConfig
from catch_arena.core.arbiter import measure_um
from catch_arena.core.math import sincos
from catch_arena.core.visibility import is_seen
from catch_arena.engine.core_settings import settings_of
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


def unseen_targets(config: ArenaConfig, world: World, seat: int) -> list[Unseen]:
    """Return the targets that a seat does not see, the nearest first; a withdrawn hunter counts like an active one."""
    settings = settings_of(config, with_parts=False)
    me, found = world.hunters[seat], []
    sine, cosine = sincos(me.theta)
    for target in world.targets:
        dx, dy = target.x - me.x, target.y - me.y
        if is_seen(dx, dy, sine, cosine, config.reaches_um[seat], settings):
            continue
        um = int(measure_um(dx, dy))
        off_deg = abs(math.degrees(math.remainder(math.atan2(dy, dx) - me.theta, 2.0 * math.pi)))
        too_far = config.view_radius_um is not None and um >= config.view_radius_um
        # a target within the radius can only be outside the cone
        outside_cone = not too_far or off_deg > config.view_angle_deg / 2.0
        found.append(Unseen(target.name, um, off_deg, too_far, outside_cone))
    return sorted(found, key=lambda target: target.distance_um)
