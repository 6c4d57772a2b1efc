"""Rulebook R7.5, R7.6: what a hunter sees of the arena, and how blurred."""

import math
from typing import Final

import numpy as np

from catch_arena.core.arbiter import to_micrometres
from catch_arena.core.jit import rule
from catch_arena.core.random import VIEW_NOISE, draw, fraction, stream
from catch_arena.core.state import Settings
from catch_arena.core.vectors import sqrt

TARGET_KIND: Final = np.uint64(0)
RIVAL_KIND: Final = np.uint64(1)
ALL_ROUND: Final = -2.0
"""Instead of the cosine of half the angle of view: nothing is behind."""
_SPREAD: Final = 1.7320508075688772


@rule
def is_seen(dx: float, dy: float, sine: float, cosine: float, reach_limit_m2: float, s: Settings) -> bool:
    """R7.5: whether a hunter sees what is dx, dy [m] from it: near enough and in front of it, or within its reach.

    Args:
        dx: east of it [m]; infinite for what nobody sees.
        dy: north of it [m].
        sine: of the hunter's heading.
        cosine: of the same.
        reach_limit_m2: of its own reach: see `squared_limit`.
    """
    square = dx * dx + dy * dy
    seen = square < s.view_limit_m2
    if s.view_cosine > ALL_ROUND:
        seen = seen & (cosine * dx + sine * dy >= sqrt(square) * s.view_cosine)
    return seen | (square < reach_limit_m2)


def squared_limit(limit_um: float) -> float:
    """R3.10, R5.3, R7.5: the least square [m2] of a distance that is not less than so many whole micrometres.

    Squares are compared with it in place of distances, which takes no root, and is the same in every bit: each step
    from a square to micrometres keeps the order.
    """
    limit = (max(limit_um - 0.5, 0.0) / 1e6) ** 2
    while limit > 0.0 and to_micrometres(math.sqrt(limit)) >= limit_um:
        limit = math.nextafter(limit, 0.0)
    while to_micrometres(math.sqrt(limit)) < limit_um:
        limit = math.nextafter(limit, math.inf)
    return limit


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
