"""Separation of entrants: tests of significant differences between them, and of the whole order."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from catch_arena.tournament.statistics.outcomes import Floats, SideResults
from catch_arena.tournament.statistics.ratings import Ratings, rate
from catch_arena.tournament.statistics.tail_probabilities import fair_coin_tail, student_tail

LEVEL: Final = 0.05
"""Significance level: the largest probability of a false difference between equal entrants."""
_FIRST_LOOK: Final = 8


@dataclass(frozen=True, slots=True)
class Separation:
    """Result of one look at a running tournament."""

    clear: bool
    pair: tuple[str, str]
    """Names of the pair with the least significant difference, the higher entrant first."""
    p: float
    """P-value of the pair's difference, corrected for the number of pairs."""
    level: float
    """Level that `p` must be below at this look."""

    def __str__(self) -> str:
        """Return the result in words."""
        if self.clear:
            return "the order is clear"
        pair = " and ".join(self.pair)
        return f"{pair} are not yet significantly different (p = {self.p:.3g}, to be below {self.level:.2g})"


def p_values(ratings: Ratings) -> Floats:
    """Return the p-value of each pair's difference, (entrants, entrants); 1 if one of the pair did not play.

    Two tests are made, with Bonferroni's correction for two. The first takes a difference divided by its standard error
    for Student's t; the degrees of freedom are the smaller number of blocks of the two, minus one. The second is the
    sign test over the blocks in which the two met: the rating of an entrant that never wins is very uncertain, but the
    entrant is certainly worse.
    """
    above, below = ratings.blocks_above, ratings.blocks_above.T
    higher = np.greater.outer(ratings.points, ratings.points)
    agree = (higher & (above > below)) | (higher.T & (above < below))
    most, least = np.maximum(np.maximum(above, below), 1.0), np.minimum(above, below)
    by_sign = np.where(agree, 2.0 * fair_coin_tail(most, least), 1.0)
    freedom = np.minimum.outer(ratings.blocks, ratings.blocks) - 1.0
    distance = ratings.distances()
    known = (freedom > 0) & np.isfinite(distance)
    by_distance = np.where(known, 2.0 * student_tail(np.maximum(freedom, 1.0), distance), 1.0)
    return np.minimum(2.0 * np.minimum(by_sign, by_distance), 1.0)


def p_values_of_all(ratings: Ratings) -> Floats:
    """Return the p-values of all pairs, corrected for their number (Holm 1979): (entrants, entrants)."""
    table = p_values(ratings)
    one, other = np.triu_indices(len(table), 1)
    table[one, other] = table[other, one] = holm(table[one, other])
    return table


def holm(p: Floats) -> Floats:
    """Return p-values corrected for their number: the level bounds the probability of any false one below it."""
    order = np.argsort(p, kind="stable")
    corrected = np.empty_like(p)
    corrected[order] = np.minimum(np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1)), 1.0)
    return corrected


def groups(ratings: Ratings, order: Sequence[int]) -> list[tuple[int, int]]:
    """Return the first and the last group, from 1, of each entrant in `order`, best first.

    A group reaches from one entrant down to the last without a significant difference from it. A group that lies within
    another is left out. Entrants without a common group differ, with 95 % confidence for all these pairs together.
    """
    alike = p_values_of_all(ratings)[np.ix_(order, order)] >= LEVEL
    ends: list[tuple[int, int]] = []
    for top in range(len(order)):
        bottom = int(np.flatnonzero(alike[top]).max(initial=top))
        if not ends or bottom > ends[-1][1]:
            ends.append((top, bottom))
    found = []
    for at in range(len(order)):
        numbers = [number for number, (top, bottom) in enumerate(ends, 1) if top <= at <= bottom]
        found.append((numbers[0], numbers[-1]))
    return found


def next_look(blocks: int) -> int:
    """Return the number of played blocks at the next look at the order: 8, then each time half as many more."""
    look = _FIRST_LOOK
    while look <= blocks:
        look += look // 2
    return look


def separation(results: SideResults, confidence: float = 0.95) -> Separation:
    """Return whether the order of all entrants is clear, with the least clear pair.

    Call it once for each `next_look`. Frequent looks would find false differences, so the k-th look has the share
    1 / (k (k + 1)) of the error that `confidence` allows; the sum over all k is 1. A reported order is wrong with a
    probability of at most 1 - confidence, for any number of looks.
    """
    higher, lower, p = least_separated(rate(results.outcomes))
    level = level_of_look(results.outcomes.blocks, confidence)
    return Separation(p < level, (results.entrants[higher].name, results.entrants[lower].name), p, level)


def least_separated(ratings: Ratings) -> tuple[int, int, float]:
    """Return the pair with the least significant difference, the higher first, and its p-value among all pairs."""
    table = p_values_of_all(ratings)
    np.fill_diagonal(table, -1.0)
    one, other = map(int, np.unravel_index(int(table.argmax()), table.shape))
    if ratings.points[one] < ratings.points[other]:
        one, other = other, one
    return one, other, float(table[one, other])


def level_of_look(blocks: int, confidence: float) -> float:
    """Return the level that a p-value must be below after this number of blocks; 0 before the first look."""
    looks, at = 0, _FIRST_LOOK
    while at <= blocks:
        looks, at = looks + 1, next_look(at)
    return (1.0 - confidence) / (looks * (looks + 1)) if looks else 0.0
