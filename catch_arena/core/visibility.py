"""Rulebook R7.5, R7.6: limits of a hunter's view, and the noise in it."""

from typing import Final

import numpy as np

from catch_arena.core.arbiter import measure_um, within_reach
from catch_arena.core.jit import rule
from catch_arena.core.random import VIEW_NOISE, draw, fraction, stream
from catch_arena.core.state import Settings
from catch_arena.core.vectors import sqrt

TARGET_KIND: Final = np.uint64(0)
RIVAL_KIND: Final = np.uint64(1)
ALL_ROUND: Final = -2.0
"""Value in place of the cosine of half the angle of view: the hunter sees in all directions."""
_SPREAD: Final = 1.7320508075688772


@rule
def is_seen(dx: float, dy: float, sine: float, cosine: float, reach_um: float, s: Settings) -> bool:
    """R7.5: return whether a hunter sees a body at `dx`, `dy` [m]: near enough and ahead of it, or within its reach."""
    distance_um = measure_um(dx, dy)
    seen = distance_um < s.view_radius_um
    if s.view_cosine > ALL_ROUND:
        seen = seen & (cosine * dx + sine * dy >= sqrt(dx * dx + dy * dy) * s.view_cosine)
    return seen | within_reach(distance_um, reach_um)


@rule
def blur_key(seed: np.uint64, step: float, observer: int, kind: np.uint64) -> np.uint64:
    """R7.6: return the key of the errors in an observer's view; `kind` is TARGET_KIND or RIVAL_KIND."""
    return draw(draw(draw(stream(seed, VIEW_NOISE), np.uint64(step)), np.uint64(observer)), kind)


@rule
def blur(key: np.uint64, axis: int, noise: float) -> float:
    """R7.6: return the error that is added to a seen position along one axis, 0 for forward or 1 for left [m]. The key
    is draw(blur_key(...), the target's number or the rival's seat); `noise` is the standard deviation [m].
    """
    own = draw(key, np.uint64(axis))
    total = fraction(draw(own, np.uint64(0))) + fraction(draw(own, np.uint64(1)))
    total = total + fraction(draw(own, np.uint64(2))) + fraction(draw(own, np.uint64(3)))
    return noise * _SPREAD * (total - 2.0)
