"""Figures for an agent over many scenarios, as Agarwal et al. 2021 define them ("Deep reinforcement learning at the
edge of the statistical precipice", and its library rliable).

Scores are tables (runs, scenarios). A *run* is the repeated unit: a block of matches, or a training seed.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.tournament.statistics.intervals import Estimate
from catch_arena.tournament.statistics.outcomes import Floats, Ints

RESAMPLES: Final = 5000
"""Number of bootstrap resamples of the runs of each scenario."""
FEWEST_RUNS: Final = 4
"""Smallest number of runs for an interval: with fewer it would be far too narrow."""
_TRIMMED: Final = 0.25
_TAIL: Final = 0.025


def interquartile_mean(scores: Floats) -> Floats:
    """Return the mean of the middle half of all runs of all scenarios: a quarter is cut off at either end.

    Args:
        scores: (..., runs, scenarios).
    """
    flat = np.sort(scores.reshape(*scores.shape[:-2], -1))
    cut = int(_TRIMMED * flat.shape[-1])
    means: Floats = flat[..., cut : flat.shape[-1] - cut].mean(axis=-1)
    return means


def interquartile_estimate(scores: Floats) -> Estimate:
    """Return the interquartile mean with its interval: percentiles of a bootstrap, stratified by scenario."""
    return _estimate(interquartile_mean(scores), interquartile_mean(_resampled(scores)), len(scores))


def interquartile_gap(first: Floats, second: Floats) -> Estimate:
    """Return the interquartile mean of `first` less that of `second`; the scenarios may differ."""
    drawn = interquartile_mean(_resampled(first)) - interquartile_mean(_resampled(second, 1))
    return _estimate(interquartile_mean(first) - interquartile_mean(second), drawn, min(len(first), len(second)))


def probability_of_improvement(scores: Floats, others: Floats) -> Estimate:
    """Return the probability that a run in `scores` beats a run in `others` in the same scenario, as a mean over these.

    A tie counts one half.

    Args:
        scores: (runs, scenarios).
        others: (runs, scenarios), of the same scenarios; there may be more or fewer runs.
    """
    # (runs, other runs, scenarios): every pair is compared once, and a resample counts the pairs that it drew
    above = (scores[:, None] > others[None]) + 0.5 * (scores[:, None] == others[None])
    mine, theirs = _weights(scores.shape, 0), _weights(others.shape, 1)
    drawn = np.einsum("nrs,rqs,nqs->n", mine, above, theirs, optimize=True) / scores.shape[1]
    return _estimate(above.mean(), drawn, min(len(scores), len(others)))


def performance_profile(scores: Floats, levels: Floats) -> list[Estimate]:
    """Return for each level the share of all runs of all scenarios with a higher score."""
    drawn = _resampled(scores)
    return [
        _estimate((scores > level).mean(), (drawn > level).mean(axis=(1, 2)), len(scores)) for level in levels.tolist()
    ]


def _drawn_runs(shape: tuple[int, ...], stream: int) -> Ints:
    """Return the indices of the drawn runs, (RESAMPLES, runs, scenarios), independent in each scenario."""
    bits = np.random.PCG64(stream)  # its raw stream is fixed by NumPy's policy
    return (bits.random_raw((RESAMPLES, *shape)) % np.uint64(shape[0])).astype(np.int64)


def _resampled(scores: Floats, stream: int = 0) -> Floats:
    return np.take_along_axis(scores[None], _drawn_runs(scores.shape, stream), axis=1)


def _weights(shape: tuple[int, ...], stream: int) -> Floats:
    """Return each run's share of its scenario's draws: (RESAMPLES, runs, scenarios)."""
    runs, scenarios = shape
    drawn = _drawn_runs((runs, scenarios), stream)
    found: Floats = np.stack([(drawn == run).mean(axis=1) for run in range(runs)], axis=1)
    return found


def _estimate(mean: Floats | float, drawn: NDArray[np.floating], runs: int) -> Estimate:
    if runs < FEWEST_RUNS:
        return Estimate(float(mean), math.nan, math.nan)
    low, high = np.quantile(drawn, (_TAIL, 1.0 - _TAIL))
    return Estimate(float(mean), float(low), float(high))
