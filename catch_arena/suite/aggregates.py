"""Figures for an agent over many scenarios, as Agarwal et al. 2021 define them ("Deep reinforcement learning at the
edge of the statistical precipice", and its library rliable).

Scores are tables (runs, scenarios). A *run* is the repeated unit: a block of matches, or a training seed.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.tournament.statistics.intervals import Estimate, draw_with_replacement
from catch_arena.tournament.statistics.outcomes import Floats, middle_half

RESAMPLES: Final = 5000
"""Number of bootstrap resamples of the runs of each scenario."""
FEWEST_RUNS: Final = 4
"""Smallest number of runs for an interval: with fewer it would be far too narrow."""


def interquartile_mean(scores: Floats) -> Floats:
    """Return the mean of the middle half of all runs of all scenarios; the table may have further axes in front."""
    means: Floats = middle_half(scores.reshape(*scores.shape[:-2], -1)).mean(axis=-1)
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

    A tie counts one half. The numbers of runs may differ.
    """
    drawn = _share_above(_resampled(scores), _resampled(others, 1))
    return _estimate(_share_above(scores, others), drawn, min(len(scores), len(others)))


def performance_profile(scores: Floats, levels: Floats) -> list[Estimate]:
    """Return for each level the share of all runs of all scenarios with a higher score."""
    drawn = _resampled(scores)
    return [
        _estimate((scores > level).mean(), (drawn > level).mean(axis=(1, 2)), len(scores)) for level in levels.tolist()
    ]


def _resampled(scores: Floats, stream: int = 0) -> Floats:
    """Return resamples of the runs, (RESAMPLES, runs, scenarios), independent in each scenario."""
    drawn = draw_with_replacement(np.random.PCG64(stream), (RESAMPLES, *scores.shape), len(scores))
    return np.take_along_axis(scores[None], drawn, axis=1)


def _share_above(scores: Floats, others: Floats) -> Floats:
    """Return the share of pairs of runs in one scenario in which the first score is above; a tie counts one half."""
    mine, theirs = scores[..., :, None, :], others[..., None, :, :]
    shares: Floats = (0.5 * (mine > theirs) + 0.5 * (mine >= theirs)).mean(axis=(-3, -2, -1))
    return shares


def _estimate(mean: Floats | float, drawn: NDArray[np.floating], runs: int) -> Estimate:
    if runs < FEWEST_RUNS:
        return Estimate(float(mean), math.nan, math.nan)
    low, high = np.quantile(drawn, (0.025, 0.975))
    return Estimate(float(mean), float(low), float(high))
