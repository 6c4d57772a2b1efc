"""Confidence intervals of figures, by resampling blocks: the matches of a block share their targets, so they are not
independent. docs/explanation/ratings.md has the formulas, their sources, and the measured coverage of the intervals.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from catch_arena.tournament.statistics.outcomes import Floats, Ints, sums_by
from catch_arena.tournament.statistics.tail_probabilities import student_critical

RESAMPLES: Final = 2000
"""Number of bootstrap resamples of the blocks."""
FEWEST_BLOCKS: Final = 4
"""Smallest number of blocks for an interval: fewer may be equal by chance."""
_DIGITS: Final = 6
"""Number of decimals in files."""
_CONFIDENCE: Final = 0.95
_BATCH: Final = 100
_MOST_DRAWN: Final = 4096
"""Largest number of blocks that are drawn singly; more are put into this number of bags first."""
_TOLERANCE: Final = 1e-12
"""Relative size of a sum of squares below which it is taken for a rounding error."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """Figure with its 95 % confidence interval, whose ends are NaN if there are too few blocks."""

    mean: float
    low: float
    high: float

    @property
    def margin(self) -> float:
        """Half the width of the interval."""
        return (self.high - self.low) / 2

    @property
    def as_share(self) -> "Estimate":
        """Estimate of a value in [0, 1], with its interval cut to these bounds."""
        low, high = np.clip((self.low, self.high), 0.0, 1.0).tolist()  # NaN stays
        return Estimate(self.mean, low, high)

    def to_dict(self) -> dict[str, float | None]:
        """Return `mean`, `low` and `high` as in files."""
        return {"mean": rounded(self.mean), "low": rounded(self.low), "high": rounded(self.high)}


def rounded(value: float) -> float | None:
    """Return a figure as in files: rounded, so that the last bit of a sum does not show; None instead of NaN."""
    return None if math.isnan(value) else round(value, _DIGITS)


def estimates(
    means: Floats, residuals: Floats, counts: Floats, pseudo_variance: Floats | float = 0.0
) -> list[Estimate]:
    """Return the intervals of figures that are means over blocks.

    `residuals` are the sums of value minus mean in each block, (blocks, figures), as are `counts`, the numbers of
    values. `pseudo_variance` is added to the variance of the blocks.
    """
    blocks = (counts > 0).sum(axis=0).astype(np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        correction = blocks / np.maximum(blocks - 1.0, 0.0)  # Bessel's: a variance among n is too small by this factor
        variances = correction * (residuals**2).sum(axis=0) / counts.sum(axis=0) ** 2 + pseudo_variance
        # Student's t is the critical value for blocks that vary normally: the bootstrap must not fall below it
        students = student_critical(np.maximum(blocks - 1.0, 1.0), (1.0 - _CONFIDENCE) / 2.0)
        critical = np.maximum(_critical(residuals, counts, correction, pseudo_variance), students)
        margins = critical * np.sqrt(variances)
    margins[~np.isfinite(margins) | (blocks < FEWEST_BLOCKS)] = math.nan
    return [
        Estimate(float(mean), float(mean - margin), float(mean + margin))
        for mean, margin in zip(means, margins, strict=True)
    ]


def ratios(sums: Floats, counts: Floats, pseudo_variance: Floats | float = 0.0) -> list[Estimate]:
    """Return the means over all blocks, from each block's sums and counts, both (blocks, figures)."""
    with np.errstate(invalid="ignore"):
        means = sums.sum(axis=0) / counts.sum(axis=0)
    return estimates(means, sums - np.nan_to_num(means) * counts, counts, pseudo_variance)


def shares(sums: Floats, counts: Floats) -> list[Estimate]:
    """Return the means of values in [0, 1].

    For their variance one win and one loss are added, so that a share of 0 or 1 still has an interval (similar to
    Agresti and Coull, 1998).
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        totals = counts.sum(axis=0)
        means = sums.sum(axis=0) / totals
        pseudo = (means**2 + (1.0 - means) ** 2) / totals**2
    return [one.as_share for one in ratios(sums, counts, pseudo)]


def _critical(residuals: Floats, counts: Floats, correction: Floats, pseudo_variance: Floats | float) -> Floats:
    """Return the critical distance of each figure from its mean, in standard errors: (figures,).

    5 % of the resamples exceed it (the symmetric studentised bootstrap, Hall 1988). It is infinite if too many
    resamples have no standard error.
    """
    residuals, counts = _bags(residuals), _bags(counts)
    tolerance = _TOLERANCE * (residuals**2).sum(axis=0)
    products = np.concatenate((residuals, counts, residuals**2, residuals * counts, counts**2), axis=1)
    blocks, figures = residuals.shape
    found = np.empty((RESAMPLES, figures))
    bits = np.random.PCG64(0)
    for begin in range(0, RESAMPLES, _BATCH):
        drawn = draw_with_replacement(bits, (_BATCH, blocks), blocks)
        weights = sums_by(_BATCH, blocks, np.arange(_BATCH)[:, None], drawn)
        moved, totals, squares, mixed, spread = np.split(weights @ products, 5, axis=1)
        shift = moved / totals
        centred = squares - 2.0 * shift * mixed + shift**2 * spread
        centred[centred <= tolerance] = 0.0
        distance = np.abs(shift) / np.sqrt(correction * centred / totals**2 + pseudo_variance)
        still = moved**2 <= tolerance
        found[begin : begin + _BATCH] = np.where(still, 0.0, np.where(totals > 0, distance, math.inf))
    critical: Floats = np.quantile(found, _CONFIDENCE, axis=0, method="inverted_cdf")
    return critical


def draw_with_replacement(bits: np.random.PCG64, shape: tuple[int, ...], count: int) -> Ints:
    """Draw numbers below `count` with replacement.

    They come from the raw stream, which NumPy's policy fixes; that of Generator's methods may change.
    """
    return (bits.random_raw(shape) % np.uint64(count)).astype(np.int64)


def _bags(values: Floats) -> Floats:
    """Return the sums of blocks in random bags if there are very many blocks: as good to draw, and cheaper."""
    blocks = len(values)
    if blocks <= _MOST_DRAWN:
        return values
    order = np.argsort(np.random.PCG64(1).random_raw(blocks), kind="stable")
    return np.add.reduceat(values[order], np.arange(_MOST_DRAWN) * blocks // _MOST_DRAWN)
