"""Which entrants the matches can tell apart, and whether that is all of them yet."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import PlayedMatch
from catch_arena.tournament.statistics.outcomes import Floats, Outcomes
from catch_arena.tournament.statistics.ratings import Ratings, rate
from catch_arena.tournament.statistics.tail_probabilities import fair_coin_tail, student_tail

LEVEL: Final = 0.05
"""How often two equal entrants may be told apart."""
_FIRST_LOOK: Final = 8


@dataclass(frozen=True, slots=True)
class Separation:
    """What one look at a tournament under way says."""

    clear: bool
    """Whether the whole order is."""
    pair: tuple[str, str]
    """The two that are hardest to tell apart, the higher first."""
    p: float
    """Of their difference, corrected for how many pairs there are."""
    level: float
    """What `p` must be below at this look."""

    def __str__(self) -> str:
        """For people."""
        if self.clear:
            return "the order is clear"
        return f"{' and '.join(self.pair)} cannot be told apart yet (p = {self.p:.3g}, to be below {self.level:.2g})"


def p_values(ratings: Ratings) -> Floats:
    """(entrants, entrants): how often two equal entrants would differ by as much; 1 where one of them did not play.

    Two tests are asked, and Bonferroni's bound allows for that. A difference over its standard error is taken for
    Student's t, with one degree of freedom less than there are blocks that the one of them that played less was in.
    And where the two met, there is the sign test over those blocks: one that never wins has a rating of hardly any
    certainty, and is certainly worse.
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
    """The same, corrected for the number of pairs (Holm 1979)."""
    table = p_values(ratings)
    one, other = np.triu_indices(len(table), 1)
    table[one, other] = table[other, one] = holm(table[one, other])
    return table


def holm(p: Floats) -> Floats:
    """P-values corrected for their number: those below a level are wrong about any of them no more often than that."""
    order = np.argsort(p, kind="stable")
    corrected = np.empty_like(p)
    corrected[order] = np.minimum(np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1)), 1.0)
    return corrected


def groups(ratings: Ratings, order: Sequence[int]) -> list[tuple[int, int]]:
    """For each place of `order`, best first: the first and the last of the groups that it belongs to, from 1.

    A group reaches from one entrant down to the last that cannot be told from it; one that lies within another is left
    out. Entrants that have no group in common can be told apart, all such statements together with 95 % confidence.
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
    """How many blocks must have been played for the next look at whether the order is clear: 8, then half as many again
    each time.
    """
    look = _FIRST_LOOK
    while look <= blocks:
        look += look // 2
    return look


def separation(entrants: Sequence[Entrant], played: Sequence[PlayedMatch], confidence: float = 0.95) -> Separation:
    """Whether the order of all entrants is clear.

    To be asked once for each `next_look`. Looking often would find differences where there are none, so the k-th look
    has 1 / (k (k + 1)) of what `confidence` leaves (the sum over all k is 1): however long it goes on, an order that is
    called clear is wrong no more often than 1 - confidence.
    """
    outcomes = Outcomes.of(len(entrants), played)
    higher, lower, p = least_separated(rate(outcomes))
    level = level_of_look(outcomes.blocks, confidence)
    return Separation(p < level, (entrants[higher].name, entrants[lower].name), p, level)


def least_separated(ratings: Ratings) -> tuple[int, int, float]:
    """The two that are hardest to tell apart, the higher first, and the p-value of their difference among all pairs."""
    table = p_values_of_all(ratings)
    np.fill_diagonal(table, -1.0)
    one, other = map(int, np.unravel_index(int(table.argmax()), table.shape))
    if ratings.points[one] < ratings.points[other]:
        one, other = other, one
    return one, other, float(table[one, other])


def level_of_look(blocks: int, confidence: float) -> float:
    """What a p-value must be below after so many blocks; 0 before the first look."""
    looks, at = 0, _FIRST_LOOK
    while at <= blocks:
        looks, at = looks + 1, next_look(at)
    return (1.0 - confidence) / (looks * (looks + 1)) if looks else 0.0
