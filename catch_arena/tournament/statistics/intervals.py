"""How sure a figure is. Blocks are drawn again, never matches: the matches of a block have their targets in common, so
they are not independent. docs/ratings.md has the formulas, their sources, and how often the intervals hold the truth.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from catch_arena.tournament.statistics.outcomes import Floats, sums_by
from catch_arena.tournament.statistics.tail_probabilities import student_critical

RESAMPLES: Final = 2000
"""How often the blocks are drawn again."""
FEWEST_BLOCKS: Final = 4
"""With fewer there is no interval: they may be equal by chance."""
_CONFIDENCE: Final = 0.95
_AT_A_TIME: Final = 100
_MOST_DRAWN: Final = 4096
"""More blocks than this are drawn by the bag."""
_NOTHING: Final = 1e-12
"""A part of a sum of squares that rounding may leave."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A figure, with the interval that holds the truth with 95 % confidence; NaN where too few blocks tell."""

    mean: float
    low: float
    high: float

    @property
    def margin(self) -> float:
        """Half of the interval's width."""
        return (self.high - self.low) / 2

    def to_dict(self, digits: int | None = None) -> dict[str, float | None]:
        """For programs: `mean`, `low` and `high`, rounded to `digits` behind the point where they are given; None where
        too few blocks tell.
        """
        numbers = {"mean": self.mean, "low": self.low, "high": self.high}
        return {
            name: None if math.isnan(number) else number if digits is None else round(number, digits)
            for name, number in numbers.items()
        }


def estimates(
    means: Floats, residuals: Floats, counts: Floats, pseudo_variance: Floats | float = 0.0
) -> list[Estimate]:
    """The intervals of figures that are means over blocks.

    Args:
        means: (figures,).
        residuals: (blocks, figures), the sums of value less mean in each block.
        counts: (blocks, figures), of how many values.
        pseudo_variance: what the figures vary by besides.
    """
    blocks = (counts > 0).sum(axis=0).astype(np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        correction = blocks / np.maximum(blocks - 1.0, 0.0)  # a variance among n is too small by as much
        variances = correction * (residuals**2).sum(axis=0) / counts.sum(axis=0) ** 2 + pseudo_variance
        # Student's t is exceeded by what so many blocks give where they vary normally
        students = student_critical(np.maximum(blocks - 1.0, 1.0), (1.0 - _CONFIDENCE) / 2.0)
        critical = np.maximum(_critical(residuals, counts, correction, pseudo_variance), students)
        margins = critical * np.sqrt(variances)
    margins[~np.isfinite(margins) | (blocks < FEWEST_BLOCKS)] = math.nan
    return [
        Estimate(float(mean), float(mean - margin), float(mean + margin))
        for mean, margin in zip(means, margins, strict=True)
    ]


def ratios(sums: Floats, counts: Floats, pseudo_variance: Floats | float = 0.0) -> list[Estimate]:
    """Means over all blocks, given each block's sums and counts, both (blocks, figures)."""
    with np.errstate(invalid="ignore"):
        means = sums.sum(axis=0) / counts.sum(axis=0)
    return estimates(means, sums - np.nan_to_num(means) * counts, counts, pseudo_variance)


def shares(sums: Floats, counts: Floats) -> list[Estimate]:
    """Means of values in [0, 1]. One more win and one more loss are imagined for their variance, so that a share of 0
    or 1 is not taken for certain (in the manner of Agresti and Coull, 1998).
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        totals = counts.sum(axis=0)
        means = sums.sum(axis=0) / totals
        pseudo = (means**2 + (1.0 - means) ** 2) / totals**2
    return [
        Estimate(one.mean, max(one.low, 0.0), min(one.high, 1.0)) if not math.isnan(one.low) else one
        for one in ratios(sums, counts, pseudo)
    ]


def _critical(residuals: Floats, counts: Floats, correction: Floats, pseudo_variance: Floats | float) -> Floats:
    """(figures,): the distance from the truth, in standard errors, that 5 % of the resamples exceed (the symmetric
    studentised bootstrap, Hall 1988); infinite where too many resamples have no standard error.
    """
    residuals, counts = _bags(residuals), _bags(counts)
    nothing = _NOTHING * (residuals**2).sum(axis=0)
    products = np.concatenate((residuals, counts, residuals**2, residuals * counts, counts**2), axis=1)
    blocks, figures = residuals.shape
    found = np.empty((RESAMPLES, figures))
    bits = np.random.PCG64(0)  # its raw stream is fixed by NumPy's policy; that of Generator's methods is not
    for begin in range(0, RESAMPLES, _AT_A_TIME):
        drawn = (bits.random_raw((_AT_A_TIME, blocks)) % np.uint64(blocks)).astype(np.int64)
        weights = sums_by(_AT_A_TIME, blocks, np.arange(_AT_A_TIME)[:, None], drawn)
        moved, totals, squares, mixed, spread = np.split(weights @ products, 5, axis=1)
        shift = moved / totals
        around_its_own_mean = squares - 2.0 * shift * mixed + shift**2 * spread
        around_its_own_mean[around_its_own_mean <= nothing] = 0.0
        distance = np.abs(shift) / np.sqrt(correction * around_its_own_mean / totals**2 + pseudo_variance)
        still = moved**2 <= nothing
        found[begin : begin + _AT_A_TIME] = np.where(still, 0.0, np.where(totals > 0, distance, math.inf))
    critical: Floats = np.quantile(found, _CONFIDENCE, axis=0, method="inverted_cdf")
    return critical


def _bags(values: Floats) -> Floats:
    """Blocks put together at random where there are very many: as good to draw, and cheaper."""
    blocks = len(values)
    if blocks <= _MOST_DRAWN:
        return values
    order = np.argsort(np.random.PCG64(1).random_raw(blocks), kind="stable")
    return np.add.reduceat(values[order], np.arange(_MOST_DRAWN) * blocks // _MOST_DRAWN)
