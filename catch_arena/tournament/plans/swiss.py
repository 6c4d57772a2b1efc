"""Who sits at a table with whom in a Swiss round: neighbours in the standing so far, and new faces first."""

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction

import numpy as np


def tables(
    entrants: int,
    seats: int,
    matches: Iterable[tuple[Sequence[int], Sequence[int]]],
    lot: Callable[[int], int],
) -> list[tuple[int, ...]]:
    """The tables of the next round.

    The first free entrant of the standing sits down, and is joined by those who have met its table least, the nearest
    in the standing first. Where the tables do not take everybody, those sit out who have played most, the last of the
    standing first.

    Args: `matches`, the (seating, ranks) of those played; `lot`, which orders equals in the standing.
    """
    points, played = [0] * entrants, [0] * entrants
    met = np.zeros((entrants, entrants), dtype=np.int64)
    for seating, ranks in matches:
        for one, rank in zip(seating, ranks, strict=True):
            played[one] += 1
            points[one] += sum((other > rank) - (other < rank) for other in ranks)
        met[np.ix_(seating, seating)] += 1

    def worth(one: int) -> Fraction:
        return Fraction(points[one], played[one]) if played[one] else Fraction(0)

    standing = sorted(range(entrants), key=lambda one: (-worth(one), lot(one)))
    place = {one: at for at, one in enumerate(standing)}
    idle = sorted(standing, key=lambda one: (played[one], place[one]), reverse=True)[: entrants % seats]
    free = [one for one in standing if one not in idle]
    drawn = []
    while free:
        table = [free.pop(0)]
        while len(table) < seats:
            table.append(free.pop(int(met[np.ix_(table, free)].sum(axis=0).argmin())))
        drawn.append(tuple(sorted(table)))
    return drawn
