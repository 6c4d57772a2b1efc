"""Rulebook R7.5, R7.6: limits of a hunter's view, and the noise in it."""

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
"""Value in place of the cosine of half the angle of view: the hunter sees in all directions."""
_SPREAD: Final = 1.7320508075688772


@rule
def is_seen(dx: float, dy: float, sine: float, cosine: float, reach_limit_m2: float, s: Settings) -> bool:
    """R7.5: return whether a hunter sees a body: near enough and in front of it, or within its reach.

    Args:
        dx: eastern distance to the body [m]; infinite for a body that no hunter sees.
        dy: northern distance to the body [m].
        reach_limit_m2: limit of the hunter's own reach: see `squared_limit`.
    """
    square = dx * dx + dy * dy
    seen = square < s.view_limit_m2
    if s.view_cosine > ALL_ROUND:
        seen = seen & (cosine * dx + sine * dy >= sqrt(square) * s.view_cosine)
    return seen | (square < reach_limit_m2)


def squared_limit(limit_um: float) -> float:
    """R3.10, R5.3, R7.5: return the least square [m2] of a distance of at least a number of whole micrometres.

    Comparing squares with it replaces comparing distances: it needs no root, and gives the same result in every bit.
    The reason is that each operation from a square to micrometres keeps the order.
    """
    limit = (max(limit_um - 0.5, 0.0) / 1e6) ** 2
    while limit > 0.0 and to_micrometres(math.sqrt(limit)) >= limit_um:
        limit = math.nextafter(limit, 0.0)
    while to_micrometres(math.sqrt(limit)) < limit_um:
        limit = math.nextafter(limit, math.inf)
    return limit


@rule
def blur_key(seed: np.uint64, step: float, observer: int, kind: np.uint64) -> np.uint64:
    """R7.6: return the key of the errors in one hunter's view.

    Args:
        observer: the seat that sees.
        kind: TARGET_KIND or RIVAL_KIND.
    """
    return draw(draw(draw(stream(seed, VIEW_NOISE), np.uint64(step)), np.uint64(observer)), kind)


@rule
def blur(key: np.uint64, axis: int, noise: float) -> float:
    """R7.6: return the error that is added to a seen position along one axis [m].

    Args:
        key: draw(blur_key(...), the target's number or the rival's seat).
        axis: 0 for forward, 1 for left.
        noise: the standard deviation [m].
    """
    own = draw(key, np.uint64(axis))
    total = fraction(draw(own, np.uint64(0))) + fraction(draw(own, np.uint64(1)))
    total = total + fraction(draw(own, np.uint64(2))) + fraction(draw(own, np.uint64(3)))
    return noise * _SPREAD * (total - 2.0)
