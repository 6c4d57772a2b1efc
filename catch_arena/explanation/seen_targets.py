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


def unseen_targets(config: ArenaConfig, world: World, seat: int) -> list[Unseen]:
    """Return the targets that a seat does not see, the nearest first; a withdrawn hunter counts like an active one."""
    settings = settings_of(config, with_parts=False)
    me, found = world.hunters[seat], []
    sine, cosine = sincos(me.theta)
    for target in world.targets:
        dx, dy = target.x - me.x, target.y - me.y
        if is_seen(dx, dy, sine, cosine, config.reaches_um[seat], settings):
            continue
        off_deg = abs(math.degrees(math.remainder(math.atan2(dy, dx) - me.theta, 2.0 * math.pi)))
        found.append(Unseen(target.name, int(measure_um(dx, dy)), off_deg))
    return sorted(found, key=lambda target: target.distance_um)
