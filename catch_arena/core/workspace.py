"""What the core needs besides the arenas: a config's tables, and scratch memory. Nothing here outlives a step."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.jit import Block, passage, rule
from catch_arena.core.state import LANES, RANKS_A_WORD, Settings

_MOST: Final = 64
"""Of hunters and of targets, in one arena."""
_ROWS: Final = 8
_ORDER_ROWS: Final = _MOST // RANKS_A_WORD
_AIM_ROWS: Final = 3


class Tables(NamedTuple):
    """What differs from seat to seat, and the sorting networks."""

    controls: NDArray[np.int64]
    """(H,)."""
    target_network: NDArray[np.int64]
    """(comparators, 2): see `observations.selection_network`."""
    rival_network: NDArray[np.int64]


class Scratch(NamedTuple):
    """Rows of LANES for one block."""

    keys: Block
    """Sorting keys, by slot or seat."""
    ages: Block
    """Of the targets, by slot [s]."""
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
    return 2 * _MOST + _ROWS + (_ORDER_ROWS + _AIM_ROWS) * hunters


@passage
def scratch_of(workspace: Block, s: Settings) -> Scratch:
    """The parts of a workspace."""
    return Scratch(
        workspace[: _MOST * LANES],
        workspace[_MOST * LANES : 2 * _MOST * LANES],
        workspace[2 * _MOST * LANES : (2 * _MOST + _ROWS) * LANES],
        workspace[(2 * _MOST + _ROWS) * LANES : (2 * _MOST + _ROWS + _ORDER_ROWS * s.hunters) * LANES],
        workspace[(2 * _MOST + _ROWS + _ORDER_ROWS * s.hunters) * LANES : workspace_rows(s.hunters) * LANES],
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
