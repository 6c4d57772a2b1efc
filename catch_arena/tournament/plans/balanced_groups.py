"""Groups of players that meet each other about equally often, for plans with too many subsets to play them all.

A *sweep* is the fewest groups in which every player plays equally often. It starts from a drawn circle of the players,
cut into groups of neighbours. Then players of different groups are swapped as long as a swap makes the numbers of
meetings of the pairs more equal; meetings in earlier sweeps count.
"""

from collections.abc import Callable, Iterator
from math import ceil, gcd
from typing import Final

import numpy as np
from numpy.typing import NDArray

_STARTS: Final = 16
"""Number of drawn circles that a sweep is tried from; the most equal outcome is taken."""
_MANY_SLOTS: Final = 64
"""Number of slots above which only one circle is tried: the time grows with the square of the slots."""
_NEVER: Final = float(1 << 40)
"""Cost of a player who is twice in a group. Doubles are exact up to 2^53, and faster to multiply than integers."""


def groups_in_sweep(players: int, seats: int) -> int:
    """Return the smallest number of groups in which every player plays equally often."""
    return players // gcd(players, seats)


def sweeps_to_meet(players: int, seats: int) -> int:
    """Return the smallest number of sweeps that have at least as many meetings as there are pairs."""
    meetings = groups_in_sweep(players, seats) * seats * (seats - 1)
    return ceil(players * (players - 1) / meetings) if meetings else 1


def sweeps(players: int, seats: int, draw: Callable[[int, int, int], int]) -> Iterator[list[tuple[int, ...]]]:
    """Yield the groups of one sweep after the other, without end; each group is in ascending order.

    There are at most as many seats as players. `draw` returns the lot of (sweep, circle, player).
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
            # groups of neighbours; the circle is repeated until all slots are filled
            tried.append(_equalised(np.resize(order, slots).reshape(-1, seats), met))
        groups = min(tried, key=lambda groups: float(((met + _meetings(groups, players)) ** 2).sum()))
        met += _meetings(groups, players)
        yield [tuple(sorted(map(int, group))) for group in groups]
        sweep += 1


def _meetings(groups: NDArray[np.int64], players: int) -> NDArray[np.float64]:
    """Return the number of meetings of each pair in these groups: (players, players), with 0 on the diagonal."""
    member = np.zeros((len(groups), players))
    member[np.arange(len(groups))[:, None], groups] = 1.0
    met: NDArray[np.float64] = member.T @ member
    np.fill_diagonal(met, 0.0)
    return met


def _equalised(groups: NDArray[np.int64], before: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the groups after swaps of two players, the best first, repeated until no swap helps.

    The best swap gives the smallest sum of squared meetings. As the number of meetings is fixed, that is most equal.
    """
    count, seats = groups.shape
    members = groups.ravel().copy()
    every, group = np.arange(members.size), np.arange(members.size) // seats
    same = group[:, None] == group[None, :]
    while True:
        met = before + _meetings(members.reshape(count, seats), len(before))
        np.fill_diagonal(met, _NEVER)
        between = met[np.ix_(members, members)]
        in_group = between.reshape(members.size, count, seats).sum(axis=2)  # a slot's player with all of a group
        staying = in_group[every, group] - _NEVER  # not with oneself
        moving = in_group[:, group] - between  # to the other's slot, when the other is gone
        gain = moving - staying[:, None]
        change = 2 * (gain + gain.T) + 4 * (seats - 1)  # one meeting more costs 2 met + 1, one less saves 2 met - 1
        change[same] = 0.0
        best = int(change.argmin())
        if change.flat[best] >= 0:
            return members.reshape(count, seats)
        swap = list(divmod(best, members.size))
        members[swap] = members[swap[::-1]]
