"""Rulebook R7.5, R7.6: what a hunter sees of the arena, and how blurred."""

from typing import Final

import numpy as np

from catch_arena.core.arbiter import measure_um, within_reach
from catch_arena.core.jit import rule
from catch_arena.core.random import VIEW_NOISE, draw, fraction, stream
from catch_arena.core.state import Settings
from catch_arena.core.vectors import sqrt

TARGET_KIND: Final = np.uint64(0)
RIVAL_KIND: Final = np.uint64(1)
_SPREAD: Final = 1.7320508075688772


@rule
def is_seen(dx: float, dy: float, sine: float, cosine: float, reach_um: float, s: Settings) -> bool:
    """R7.5: whether a hunter sees what is dx, dy [m] from it: near enough and in front of it, or within its reach.

    Args:
        dx: east of it [m].
        dy: north of it [m].
        sine: of the hunter's heading.
        cosine: of the same.
        reach_um: its own reach [micrometres].
        s: the settings.
    """
    distance_um = measure_um(dx, dy)
    in_front = cosine * dx + sine * dy >= sqrt(dx * dx + dy * dy) * s.view_cosine
    return ((distance_um < s.view_radius_um) & in_front) | within_reach(distance_um, reach_um)


@rule
def blur_key(seed: np.uint64, step: float, observer: int, kind: np.uint64) -> np.uint64:
    """R7.6: the stream of errors of what one hunter sees.

    Args:
        seed: the arena's.
        step: that of the state that is observed.
        observer: the seat that sees.
        kind: TARGET_KIND or RIVAL_KIND.
    """
    return draw(draw(draw(stream(seed, VIEW_NOISE), np.uint64(step)), np.uint64(observer)), kind)


@rule
def blur(key: np.uint64, axis: int, noise: float) -> float:
    """R7.6: what is added to where something is seen [m].

    Args:
        key: draw(blur_key(...), the target's number or the rival's seat).
        axis: 0 for forward, 1 for left.
        noise: the standard deviation [m].
    """
    own = draw(key, np.uint64(axis))
    total = fraction(draw(own, np.uint64(0))) + fraction(draw(own, np.uint64(1)))
    total = total + fraction(draw(own, np.uint64(2))) + fraction(draw(own, np.uint64(3)))
    return noise * _SPREAD * (total - 2.0)
