"""Played matches of one side as arrays, from which every figure is computed.

R12.7: The figures of a side use its own results only. If a side has several parties in a match, they are compared in
that match. If it has one party, matches of a block with the same other side are joined to one match
(`Parties.seatings`). In it, entrants that played the party in turn meet: they had the same opponents, in the same
places.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from catch_arena.policy import Side
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import Forfeit, PlayedMatch, ranks_of_sides
from catch_arena.tournament.parties import Parties

if TYPE_CHECKING:
    from typing_extensions import Self

Floats: TypeAlias = NDArray[np.floating[Any]]
Ints: TypeAlias = NDArray[np.int64]


class SideMatch(NamedTuple):
    """Match of the parties of one side, or several matches that are joined to one."""

    block: int
    seating: tuple[int, ...]
    """Player of each party, as an index among the entrants."""
    scores: tuple[int, ...]
    ranks: tuple[int, ...]
    forfeits: tuple[Forfeit | None, ...]


def on_side(played: Sequence[PlayedMatch], parties: Parties, side: Side = "hunter") -> list[SideMatch]:
    """Return the matches of one side, of whole blocks, in the order of the plan."""
    in_order = [(one.match, one.result) for one in sorted(played, key=lambda one: one.match)]
    cut = parties.on(side)
    matches = [
        SideMatch(match.block, match.seating[cut], result.scores[cut], result.ranks[cut], result.forfeits[cut])
        for match, result in in_order
    ]
    if len(parties.sides) == 1 or len(parties.seats[cut]) > 1:
        return matches
    other = parties.on("prey" if side == "hunter" else "hunter")
    alike: dict[tuple[int, tuple[int, ...]], list[SideMatch]] = {}
    for (match, _), one in zip(in_order, matches, strict=True):
        alike.setdefault((match.block, match.seating[other]), []).append(one)
    return [_join(found, side) for found in alike.values()]


def _join(matches: Sequence[SideMatch], side: Side) -> SideMatch:
    """Return one match that joins matches with one party each."""
    scores = tuple(one.scores[0] for one in matches)
    forfeits = tuple(one.forfeits[0] for one in matches)
    lasted = [None if one is None else one.step for one in forfeits]
    ranks = ranks_of_sides(scores, lasted, len(scores) if side == "hunter" else 0)
    return SideMatch(matches[0].block, tuple(one.seating[0] for one in matches), scores, ranks, forfeits)


@dataclass(frozen=True, slots=True)
class Outcomes:
    """Outcomes of N matches of H parties (parties.py) on one side; a party is a seat if there are no teams."""

    entrants: int
    block: Ints
    """Block of each match, from 0 and without gaps: (N,)."""
    seating: Ints
    """Player of each party, as an index among the entrants, (N, H); an entrant may play several parties."""
    scores: Ints
    """Score of each party: (N, H)."""
    ranks: Ints
    """Rank of each party, (N, H): 1 is best, equal ones tie; from 2 on if all forfeited, as no party wins then."""

    @classmethod
    def of(cls, entrants: int, matches: Sequence[SideMatch]) -> "Outcomes":
        """Return the outcomes of matches in the order of the plan, so that sums do not depend on the order of play."""
        shape = (len(matches), len(matches[0].seating))
        ranks = [[rank + (None not in one.forfeits) for rank in one.ranks] for one in matches]
        return cls(
            entrants,
            np.unique([one.block for one in matches], return_inverse=True)[1].astype(np.int64),
            np.array([one.seating for one in matches], dtype=np.int64).reshape(shape),
            np.array([one.scores for one in matches], dtype=np.int64).reshape(shape),
            np.array(ranks, dtype=np.int64).reshape(shape),
        )

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return int(self.block.max()) + 1

    def by_block(self, values: Floats | Ints | float = 1.0) -> Floats:
        """Return the sums of `values`, (blocks, entrants); `values` is one per party and match, or one for all."""
        return sums_by(self.blocks, self.entrants, self.block[:, None], self.seating, values)

    @property
    def win_shares(self) -> Floats:
        """Share of the win of each party, (N, H): 1 for a win; parties that share the first rank share it."""
        won: Floats = (self.ranks == 1).astype(np.float64)
        won /= np.maximum(won.sum(axis=1, keepdims=True), 1.0)
        return won


@dataclass(frozen=True)
class SideResults:
    """Results of one side; without prey there is only the side of the hunters."""

    side: Side
    entrants: Sequence[Entrant]
    """Entrants, as they play on this side."""
    played: Sequence[PlayedMatch]
    """Matches, with all their parties."""
    parties: slice
    """Parties of this side in a match."""
    outcomes: Outcomes

    @classmethod
    def of(
        cls, entrants: Sequence[Entrant], played: Sequence[PlayedMatch], parties: Parties, side: Side = "hunter"
    ) -> "Self":
        """Return the results of a side in whole blocks."""
        outcomes = Outcomes.of(len(entrants), on_side(played, parties, side))
        return cls(side, [entrant.on(side) for entrant in entrants], played, parties.on(side), outcomes)


@dataclass(frozen=True, slots=True)
class Pairs:
    """Pairs of different entrants that met in a match, and their results."""

    entrants: int
    blocks: int
    block: Ints
    first: Ints
    second: Ints
    result: Ints
    """Result of each pair: 1 if the first ranks above the second, 0 for a tie, -1 if it ranks below."""

    @classmethod
    def of(cls, outcomes: Outcomes) -> "Pairs":
        """Return the H (H - 1) / 2 pairs of each match, without those of an entrant with itself."""
        one, other = np.triu_indices(outcomes.seating.shape[1], 1)
        block = np.repeat(outcomes.block, len(one))
        first, second = outcomes.seating[:, one].ravel(), outcomes.seating[:, other].ravel()
        result = np.sign(outcomes.ranks[:, other] - outcomes.ranks[:, one]).ravel()
        differ = first != second
        return cls(outcomes.entrants, outcomes.blocks, block[differ], first[differ], second[differ], result[differ])

    def table(self, result: int) -> Floats:
        """Return the number of times that each entrant had this result against each other: (entrants, entrants)."""
        forth, back = self.result == result, self.result == -result
        size = self.entrants
        return sums_by(size, size, self.first[forth], self.second[forth]) + sums_by(
            size, size, self.second[back], self.first[back]
        )

    def blocks_above(self) -> Floats:
        """Return the number of blocks in which the row's entrant ranked above the column's more often than below."""
        size = self.entrants
        pair = np.minimum(self.first, self.second) * size + np.maximum(self.first, self.second)
        met, number = np.unique(self.block * size**2 + pair, return_inverse=True)
        net = np.bincount(number, np.where(self.first < self.second, self.result, -self.result), len(met))
        low, high = np.divmod(met % size**2, size)
        above, below = net > 0, net < 0
        return sums_by(size, size, low[above], high[above]) + sums_by(size, size, high[below], low[below])


def middle_half(values: Floats) -> Floats:
    """Return the middle half along the last axis, sorted: a quarter is cut off at either end."""
    cut = values.shape[-1] // 4
    return np.sort(values)[..., cut : values.shape[-1] - cut]


def sums_by(rows: int, columns: int, row: Ints, column: Ints, values: Floats | Ints | float = 1.0) -> Floats:
    """Return the sum of the values of each cell, (rows, columns); the arrays are broadcast together."""
    cell = row * columns + column
    weights = np.broadcast_to(np.asarray(values, dtype=np.float64), cell.shape)
    return np.bincount(cell.ravel(), weights.ravel(), rows * columns).astype(np.float64).reshape(rows, columns)
