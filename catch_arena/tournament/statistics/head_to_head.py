"""Results of each entrant against each other."""

import math
from dataclasses import dataclass

import numpy as np

from catch_arena.tournament.statistics.intervals import Estimate, shares
from catch_arena.tournament.statistics.outcomes import Floats, Pairs, SideResults, sums_by


@dataclass(frozen=True, slots=True)
class Encounter:
    """Results of a first entrant against a second."""

    matches: int
    """Number of matches in which both played."""
    wins: int
    """Number of these in which the first ranked above the second."""
    ties: int
    share: Estimate
    """Share of these matches that the first won, in [0, 1]: a win counts 1, a tie one half; NaN if they never met."""
    improvement: float
    """Probability that a random match of the first has a better score than a random match of the second, with a tie as
    one half (Agarwal et al. 2021). Unlike the share, it is known also if they never met. For hunters more catches are
    better, for prey fewer.
    """


def head_to_head(results: SideResults) -> dict[tuple[str, str], Encounter]:
    """Return the results of all ordered pairs of different entrants that played, by their names."""
    names, outcomes = [entrant.name for entrant in results.entrants], results.outcomes
    pairs = Pairs.of(outcomes)
    wins, ties = pairs.table(1), pairs.table(0)
    met = wins + wins.T + ties
    size = len(names)
    low, high = np.minimum(pairs.first, pairs.second), np.maximum(pairs.first, pairs.second)
    column = low * size + high
    present, number = np.unique(column, return_inverse=True)
    result: Floats = 0.5 + pairs.result * np.where(pairs.first == low, 0.5, -0.5)
    estimates = shares(
        sums_by(pairs.blocks, len(present), pairs.block, number, result),
        sums_by(pairs.blocks, len(present), pairs.block, number),
    )
    share = {divmod(int(cell), size): estimate for cell, estimate in zip(present, estimates, strict=True)}
    share |= {(j, i): Estimate(1 - one.mean, 1 - one.high, 1 - one.low) for (i, j), one in share.items()}
    unknown = Estimate(math.nan, math.nan, math.nan)

    histogram = sums_by(size, int(outcomes.scores.max()) + 1, outcomes.seating, outcomes.scores)
    totals = histogram.sum(axis=1)
    below_or_half = np.cumsum(histogram, axis=1) - histogram / 2.0
    with_matches = np.flatnonzero(totals)

    def improvement(i: int, j: int) -> float:
        better, worse = (i, j) if results.side == "hunter" else (j, i)
        return float(histogram[better] @ below_or_half[worse] / (totals[i] * totals[j]))

    return {
        (names[i], names[j]): Encounter(
            matches=int(met[i, j]),
            wins=int(wins[i, j]),
            ties=int(ties[i, j]),
            share=share.get((i, j), unknown),
            improvement=improvement(i, j),
        )
        for i in with_matches.tolist()
        for j in with_matches.tolist()
        if i != j
    }
