"""The matches that were played, as arrays: what every figure is made from."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from catch_arena.tournament.match import MatchResult, PlayedMatch

Floats: TypeAlias = NDArray[np.floating[Any]]
Ints: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Outcomes:
    """N matches of H parties (parties.py), which are seats where there are no teams; their order means nothing."""

    entrants: int
    block: Ints
    """(N,): the block of each match, from 0 and without gaps."""
    seating: Ints
    """(N, H): who played which, by index among the entrants; one may play several."""
    scores: Ints
    """(N, H)."""
    ranks: Ints
    """(N, H): 1 is best, equal ones tie; from 2 on where all forfeited, as nobody wins such a match."""

    @classmethod
    def of(cls, entrants: int, played: Sequence[PlayedMatch]) -> "Outcomes":
        """Those of a tournament, in the order of its plan, so that sums do not depend on who finished first."""
        in_order = sorted(played, key=lambda one: one.match)
        shape = (len(in_order), len(in_order[0].match.seating) if in_order else 0)
        return cls(
            entrants,
            np.unique([one.match.block for one in in_order], return_inverse=True)[1].astype(np.int64),
            np.array([one.match.seating for one in in_order], dtype=np.int64).reshape(shape),
            np.array([one.result.scores for one in in_order], dtype=np.int64).reshape(shape),
            np.array([_ranks(one.result) for one in in_order], dtype=np.int64).reshape(shape),
        )

    @property
    def blocks(self) -> int:
        """How many there are."""
        return int(self.block.max(initial=-1)) + 1

    def by_block(self, values: Floats | Ints | float = 1.0) -> Floats:
        """(blocks, entrants): the sums of `values`: one for each party of each match, or 1 for all."""
        return sums_by(self.blocks, self.entrants, self.block[:, None], self.seating, values)

    @property
    def win_shares(self) -> Floats:
        """(N, H): 1 for a win; those who share the first rank share it."""
        won: Floats = (self.ranks == 1).astype(np.float64)
        won /= np.maximum(won.sum(axis=1, keepdims=True), 1.0)
        return won


def _ranks(result: MatchResult) -> list[int]:
    return [rank + (None not in result.forfeits) for rank in result.ranks]


@dataclass(frozen=True, slots=True)
class Pairs:
    """Every two different entrants that met in a match, and which of them came out above the other."""

    entrants: int
    blocks: int
    block: Ints
    first: Ints
    second: Ints
    result: Ints
    """1 where the first is above the second, 0 where they tie, -1 where it is below."""

    @classmethod
    def of(cls, outcomes: Outcomes) -> "Pairs":
        """H (H - 1) / 2 for each match, less those where an entrant met itself."""
        one, other = np.triu_indices(outcomes.seating.shape[1], 1)
        block = np.repeat(outcomes.block, len(one))
        first, second = outcomes.seating[:, one].ravel(), outcomes.seating[:, other].ravel()
        result = np.sign(outcomes.ranks[:, other] - outcomes.ranks[:, one]).ravel()
        apart = first != second
        return cls(outcomes.entrants, outcomes.blocks, block[apart], first[apart], second[apart], result[apart])

    def table(self, result: int) -> Floats:
        """(entrants, entrants): how often the first of a pair met this result against the second, either way round."""
        forth, back = self.result == result, self.result == -result
        size = self.entrants
        return sums_by(size, size, self.first[forth], self.second[forth]) + sums_by(
            size, size, self.second[back], self.first[back]
        )

    def blocks_above(self) -> Floats:
        """(entrants, entrants): in how many blocks the first came out above the second more often than below."""
        size = self.entrants
        pair = np.minimum(self.first, self.second) * size + np.maximum(self.first, self.second)
        met, number = np.unique(self.block * size**2 + pair, return_inverse=True)
        net = np.bincount(number, np.where(self.first < self.second, self.result, -self.result), len(met))
        low, high = np.divmod(met % size**2, size)
        above, below = net > 0, net < 0
        return sums_by(size, size, low[above], high[above]) + sums_by(size, size, high[below], low[below])


def sums_by(rows: int, columns: int, row: Ints, column: Ints, values: Floats | Ints | float = 1.0) -> Floats:
    """(rows, columns): the sums of the values that belong in each cell; the arrays are broadcast together."""
    cell = row * columns + column
    weights = np.broadcast_to(np.asarray(values, dtype=np.float64), cell.shape)
    return np.bincount(cell.ravel(), weights.ravel(), rows * columns).astype(np.float64).reshape(rows, columns)
