"""The pairing of a Swiss round: neighbours in the ranking so far, who have met least."""

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction

import numpy as np


def pair_round(
    entrants: int,
    seats: int,
    matches: Iterable[tuple[Sequence[int], Sequence[int]]],
    lot: Callable[[int], int],
) -> list[tuple[int, ...]]:
    """The groups of the next round, of as many entrants as there are seats.

    The first free entrant of the ranking begins a group, and is joined by those who have met its members least, the
    nearest in the ranking first. Where the groups do not take everybody, those sit out who have played most, the last
    of the ranking first.

    Args:
        entrants: who plays.
        seats: how many play in a match.
        matches: the (seating, ranks) of those played.
        lot: which orders equals in the ranking.
    """
    points, played = [0] * entrants, [0] * entrants
    met = np.zeros((entrants, entrants), dtype=np.int64)
    for seating, ranks in matches:
        for one, rank in zip(seating, ranks, strict=True):
            played[one] += 1
            points[one] += sum((other > rank) - (other < rank) for other in ranks)
        met[np.ix_(seating, seating)] += 1

    def mean_points(one: int) -> Fraction:
        return Fraction(points[one], played[one]) if played[one] else Fraction(0)

    ranking = sorted(range(entrants), key=lambda one: (-mean_points(one), lot(one)))
    position = {one: at for at, one in enumerate(ranking)}
    idle = sorted(ranking, key=lambda one: (played[one], position[one]), reverse=True)[: entrants % seats]
    free = [one for one in ranking if one not in idle]
    groups = []
    while free:
        group = [free.pop(0)]
        while len(group) < seats:
            group.append(free.pop(int(met[np.ix_(group, free)].sum(axis=0).argmin())))
        groups.append(tuple(sorted(group)))
    return groups
