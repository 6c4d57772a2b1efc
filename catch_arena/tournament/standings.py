"""What the matches say about the entrants, and how sure that is."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.runner import Played

RESAMPLES: Final = 2000
"""How often the blocks are drawn again for the intervals."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A mean, with the interval that holds it with 95 % confidence; an interval of NaN where there is but one block."""

    mean: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Standing:
    """One entrant's line of the table."""

    place: int
    """1 is best, by mean score; equal mean scores share a place."""
    name: str
    matches: int
    score: Estimate
    """Catches in a match."""
    win_share: Estimate
    """Matches won in [0, 1]; those who share the first rank share the win."""
    mean_rank: float
    contests_lost: float
    """Requests in a match that a rival won (R5.6)."""
    refused: float
    """Requests in a match that were refused for any other reason."""


def standings(entrants: Sequence[Entrant], played: Sequence[Played]) -> list[Standing]:
    """The table of those who played, best mean score first.

    Intervals come from a bootstrap over blocks, not matches: the matches of a block have their targets in common, so
    they are not independent. The draws are the same every time.
    """
    count, blocks = len(entrants), max((one.match.block for one in played), default=-1) + 1
    matches, scores, wins = (np.zeros((blocks, count)) for _ in range(3))
    ranks = np.zeros(count)
    verdicts: list[Counter[str]] = [Counter() for _ in entrants]
    for one in played:
        result, block = one.result, one.match.block
        winners = result.ranks.count(1)
        for seat, place in enumerate(one.match.seating):
            matches[block, place] += 1
            scores[block, place] += result.scores[seat]
            wins[block, place] += (result.ranks[seat] == 1) / winners
            ranks[place] += result.ranks[seat]
            verdicts[place].update(result.verdicts[seat])
    totals = matches.sum(axis=0)
    score, win_share = _estimates(scores, matches), _estimates(wins, matches)
    present = [place for place in range(count) if totals[place]]
    order = sorted(present, key=lambda place: (-score[place].mean, entrants[place].name))
    return [
        Standing(
            place=1 + sum(other.mean > score[place].mean for other in score),
            name=entrants[place].name,
            matches=int(totals[place]),
            score=score[place],
            win_share=win_share[place],
            mean_rank=float(ranks[place] / totals[place]),
            contests_lost=verdicts[place]["LOST_CONTEST"] / float(totals[place]),
            refused=(verdicts[place].total() - verdicts[place]["LOST_CONTEST"] - verdicts[place]["GRANTED"])
            / float(totals[place]),
        )
        for place in order
    ]


def _estimates(sums: NDArray[np.float64], counts: NDArray[np.float64]) -> list[Estimate]:
    """Per column: the mean, and the middle 95 % of the means over blocks drawn with replacement.

    Args: `sums` and `counts`, both (blocks, entrants).
    """
    blocks, entrants = sums.shape
    draws = np.full((RESAMPLES, entrants), np.nan)
    bits = np.random.PCG64(0)  # its raw stream is fixed by NumPy's policy; that of Generator's methods is not
    for resample in range(RESAMPLES):
        weights = np.bincount((bits.random_raw(blocks) % np.uint64(blocks)).astype(np.int64), minlength=blocks)
        with np.errstate(invalid="ignore"):  # an entrant without a match in this draw
            draws[resample] = (weights @ sums) / (weights @ counts)
    with np.errstate(invalid="ignore"):
        means = sums.sum(axis=0) / counts.sum(axis=0)
    played_blocks = (counts > 0).sum(axis=0)
    estimates = []
    for place in range(entrants):
        low, high = math.nan, math.nan
        if played_blocks[place] > 1:
            low, high = np.nanpercentile(draws[:, place], (2.5, 97.5))
        estimates.append(Estimate(float(means[place]), float(low), float(high)))
    return estimates
