"""What the core needs besides the arenas: a config's tables, and scratch memory. Nothing here outlives a step."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.jit import Block, passage, rule
from catch_arena.core.state import ABSENT, LANES, RANKS_A_WORD, Settings
from catch_arena.core.vectors import WIDE

_MOST: Final = 64
"""Of hunters and of targets, in one arena."""
_ROWS: Final = 8
PICTURE: Final = 8
"""How many numbers there are at most, and room for, of one thing that is seen."""
_PICTURES: Final = (ABSENT + 1) * PICTURE * len(WIDE)
"""Of all slots or seats, and of what is absent: zeros."""
_ORDER_ROWS: Final = _MOST // RANKS_A_WORD
_AIM_ROWS: Final = 3


class Tables(NamedTuple):
    """What differs from seat to seat, and the sorting networks."""

    controls: NDArray[np.int64]
    """(H,)."""
    target_network: NDArray[np.int64]
    """(comparators, 2): see `ranking.selection_network`."""
    rival_network: NDArray[np.int64]


class Scratch(NamedTuple):
    """For one block; `rows`, `orders` and `aims` are rows of LANES."""

    keys: NDArray[np.int32]
    """Sorting keys, by slot or seat: rows of LANES."""
    ages: NDArray[np.float32]
    """Of the targets, by slot [s]: rows of LANES."""
    targets: NDArray[np.float32]
    """What one seat sees of each target in one group of lanes: see `PICTURE`."""
    rivals: NDArray[np.float32]
    """And of each rival."""
    views: NDArray[np.float32]
    """The observations of one group of lanes, as they lie in memory."""
    rows: Block
    """A few rows for whatever a phase counts."""
    orders: Block
    """Of the rivals, by seat: see `order_of`."""
    aims: Block
    """R6.2's progress, by seat: see `aim_of`."""
    kept: Block
    """The block as it was, where some of its arenas have ended."""


@passage
def tables_of(numbers: NDArray[np.int64], s: Settings) -> Tables:
    """The tables in their array: how many comparators the networks have, the controls, and the networks."""
    first = 2 + s.hunters
    middle = first + 2 * numbers[0]
    return Tables(
        numbers[2:first],
        numbers[first:middle].reshape((-1, 2)),
        numbers[middle : middle + 2 * numbers[1]].reshape((-1, 2)),
    )


@rule
def workspace_rows(hunters: int) -> int:
    """How many rows a workspace has before those of `Scratch.kept`."""
    return _ROWS + (_ORDER_ROWS + _AIM_ROWS) * hunters


KEYS: Final = _MOST * LANES
"""How many there are."""


def narrow_size(hunters: int, columns: int) -> int:
    """How many numbers of float32 a workspace has: ages, two sets of pictures, and a group's observations, with room
    for what is written too much.
    """
    return KEYS + 2 * _PICTURES + len(WIDE) * hunters * columns + PICTURE


@passage
def scratch_of(workspace: Block, narrow: NDArray[np.float32], keys: NDArray[np.int32], s: Settings) -> Scratch:
    """The parts of a workspace."""
    aims = _ROWS + _ORDER_ROWS * s.hunters
    return Scratch(
        keys,
        narrow[:KEYS],
        narrow[KEYS : KEYS + _PICTURES],
        narrow[KEYS + _PICTURES : KEYS + 2 * _PICTURES],
        narrow[KEYS + 2 * _PICTURES :],
        workspace[: _ROWS * LANES],
        workspace[_ROWS * LANES : aims * LANES],
        workspace[aims * LANES : workspace_rows(s.hunters) * LANES],
        workspace[workspace_rows(s.hunters) * LANES :],
    )


@passage
def order_of(scratch: Scratch, seat: int) -> Block:
    """R7.1: the rivals of one seat, nearest first, as `state.item_at` reads them."""
    return scratch.orders[_ORDER_ROWS * LANES * seat : _ORDER_ROWS * LANES * (seat + 1)]


@passage
def aim_of(scratch: Scratch, seat: int) -> Block:
    """R6.2's progress of one seat, three rows: where the target is that was nearest after the commit, x and y [m], and
    how far it was [m], -1 for none.
    """
    return scratch.aims[_AIM_ROWS * LANES * seat : _AIM_ROWS * LANES * (seat + 1)]
