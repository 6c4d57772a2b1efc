"""Tail probabilities of the two distributions that significance tests need, on arrays.

SciPy has them too, but needs 140 MB of disk, and a quarter of a second at every start, as Numba imports it if it is
installed. The tests compare with SciPy.
"""

import math
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from catch_arena.tournament.statistics.outcomes import Floats

_MOST_TERMS: Final = 100_000
_PRECISION: Final = 1e-15
_TINY: Final = 1e-300
"""Value in place of a zero divisor (Lentz 1976)."""

_log_gamma = np.vectorize(math.lgamma, otypes=[np.float64])


def incomplete_beta(a: ArrayLike, b: ArrayLike, x: ArrayLike) -> Floats:
    """Return the regularised incomplete beta function I_x(a, b), for a, b > 0 and x in [0, 1]; the arguments broadcast.

    It uses the continued fraction (DLMF 8.17.22), on the side of the mean on which it converges fast.
    """
    a, b, x = np.broadcast_arrays(*(np.asarray(one, dtype=np.float64) for one in (a, b, x)))
    far = x > (a + 1.0) / (a + b + 2.0)
    a, b, x = np.where(far, b, a), np.where(far, a, b), np.where(far, 1.0 - x, x)
    with np.errstate(divide="ignore"):
        front = np.exp(_log_gamma(a + b) - _log_gamma(a) - _log_gamma(b) + a * np.log(x) + b * np.log1p(-x)) / a
    found: Floats = front / _continued_fraction(a, b, x)
    return np.where(far, 1.0 - found, found)


def _continued_fraction(a: Floats, b: Floats, x: Floats) -> Floats:
    """Return 1 + d_1 / (1 + d_2 / (1 + ...)), by the modified method of Lentz."""
    value, upper, lower = np.ones_like(x), np.ones_like(x), np.zeros_like(x)
    for term in range(1, _MOST_TERMS):
        m = term // 2
        if term % 2:
            d = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))
        else:
            d = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))
        lower = 1.0 + d * lower
        lower = 1.0 / np.where(np.abs(lower) < _TINY, _TINY, lower)
        upper = 1.0 + d / upper
        upper = np.where(np.abs(upper) < _TINY, _TINY, upper)
        value = value * upper * lower
        if not np.any(np.abs(upper * lower - 1.0) >= _PRECISION):  # NaN does not converge: it must not go on
            break
    return value


def fair_coin_tail(heads: Floats, tails: Floats) -> Floats:
    """Return the probability of at least `heads` heads in `heads + tails` throws of a fair coin, for heads >= 1."""
    return incomplete_beta(heads, tails + 1.0, 0.5)


def student_tail(freedom: Floats, t: Floats) -> Floats:
    """Return the probability that Student's t with `freedom` degrees of freedom exceeds t, for t >= 0."""
    return 0.5 * incomplete_beta(0.5 * freedom, 0.5, freedom / (freedom + t * t))


def student_critical(freedom: Floats, tail: float) -> Floats:
    """Return the value that Student's t exceeds with probability `tail`, in (0, 0.5)."""
    critical: Floats = np.vectorize(_critical, otypes=[np.float64])(freedom, tail)
    return critical


@lru_cache(maxsize=4096)
def _critical(freedom: float, tail: float) -> float:
    """Return the critical value by Newton's method from 0: the tail is convex, so each step stays below the root."""
    log_scale = math.lgamma(0.5 * (freedom + 1.0)) - math.lgamma(0.5 * freedom) - 0.5 * math.log(math.pi * freedom)
    t = 0.0
    for _ in range(200):
        density = math.exp(log_scale - 0.5 * (freedom + 1.0) * math.log1p(t * t / freedom))
        step = (float(student_tail(np.array(freedom), np.array(t))) - tail) / density
        t += step
        if step <= 1e-12 * t:
            break
    return t
