"""Groups of players that meet each other about equally often, where there are too many subsets to play them all.

A *sweep* is the fewest groups in which everybody plays equally often. It starts from a drawn circle of the players,
cut into groups of neighbours; then players of different groups are swapped for as long as that makes the meetings of
pairs, those of earlier sweeps counted, more equal.
"""

from collections.abc import Callable, Iterator, Sequence
from math import ceil, gcd
from typing import Final

import numpy as np
from numpy.typing import NDArray

_STARTS: Final = 16
"""How many drawn circles a sweep is tried from; the most equal outcome is taken."""
_MANY_SLOTS: Final = 64
"""From here on one circle must do: the time grows with the square of the slots."""
_NEVER: Final = float(1 << 40)
"""What it costs to be twice in a group. Doubles are exact up to 2^53, and faster to multiply than whole numbers."""


def groups_in_sweep(players: int, seats: int) -> int:
    """The fewest groups in which everybody plays equally often."""
    return players // gcd(players, seats)


def sweeps_to_meet(players: int, seats: int) -> int:
    """How many sweeps have at least as many meetings as there are pairs."""
    meetings = groups_in_sweep(players, seats) * seats * (seats - 1)
    return ceil(players * (players - 1) / meetings) if meetings else 1


def sweeps(players: int, seats: int, draw: Callable[[int, int, int], int]) -> Iterator[list[tuple[int, ...]]]:
    """The groups of one sweep after the other, without end; each group in ascending order.

    Args:
        players: how many there are.
        seats: at most `players`.
        draw: the lot of (sweep, circle, player).
    """
    met = np.zeros((players, players))
    slots = groups_in_sweep(players, seats) * seats
    circles = _STARTS if slots <= _MANY_SLOTS else 1
    sweep = 0
    while True:
        tried = []
        for circle in range(circles):
            lots = [draw(sweep, circle, player) for player in range(players)]
            order = sorted(range(players), key=lots.__getitem__)
            tried.append(_equalised(_neighbours(order, seats, slots), met))
        groups = min(tried, key=lambda groups: float(((met + _meetings(groups, players)) ** 2).sum()))
        met += _meetings(groups, players)
        yield [tuple(sorted(map(int, group))) for group in groups]
        sweep += 1


def _neighbours(circle: Sequence[int], seats: int, slots: int) -> NDArray[np.int64]:
    """The circle, walked round until `slots` are filled, in groups of neighbours: (groups, seats)."""
    return np.resize(np.array(circle, dtype=np.int64), slots).reshape(-1, seats)


def _meetings(groups: NDArray[np.int64], players: int) -> NDArray[np.float64]:
    """How often each pair meets in these groups: (players, players), 0 with oneself."""
    member = np.zeros((len(groups), players))
    member[np.arange(len(groups))[:, None], groups] = 1.0
    met: NDArray[np.float64] = member.T @ member
    np.fill_diagonal(met, 0.0)
    return met


def _equalised(groups: NDArray[np.int64], before: NDArray[np.float64]) -> NDArray[np.int64]:
    """The groups after the best swap of two players, and the best after that, until none is left that helps.

    The best makes the sum of the squares of the meetings least: their number is fixed, so that is most equal.
    """
    count, seats = groups.shape
    who = groups.ravel().copy()
    every, group = np.arange(who.size), np.arange(who.size) // seats
    same = group[:, None] == group[None, :]
    while True:
        met = before + _meetings(who.reshape(count, seats), len(before))
        np.fill_diagonal(met, _NEVER)
        between = met[np.ix_(who, who)]
        in_group = between.reshape(who.size, count, seats).sum(axis=2)  # a slot's player with all of a group
        staying = in_group[every, group] - _NEVER  # not with oneself
        moving = in_group[:, group] - between  # to the other's slot, when the other is gone
        gain = moving - staying[:, None]
        change = 2 * (gain + gain.T) + 4 * (seats - 1)  # one meeting more costs 2 met + 1, one less saves 2 met - 1
        change[same] = 0.0
        best = int(change.argmin())
        if change.flat[best] >= 0:
            return who.reshape(count, seats)
        swap = list(divmod(best, who.size))
        who[swap] = who[swap[::-1]]
