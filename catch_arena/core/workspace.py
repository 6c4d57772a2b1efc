"""What the core needs besides the arenas: scratch memory. Nothing here outlives a step."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.arbiter import DOCKET_COLUMNS, Docket
from catch_arena.core.jit import Block, passage
from catch_arena.core.memory import Sections
from catch_arena.core.state import ABSENT, LANES, RANKS_A_WORD
from catch_arena.core.vectors import WIDE

_MOST: Final = 64
"""Of hunters and of targets, in one arena."""
_ROWS: Final = 8
"""As many as `rewards.reward` needs."""
PICTURE: Final = 8
"""How many numbers there are at most, and room for, of one thing that is seen."""
_PICTURES: Final = (ABSENT + 1) * PICTURE * len(WIDE)
"""Of all slots or seats, and of what is absent: zeros."""
_ORDER_ROWS: Final = _MOST // RANKS_A_WORD
_AIM_ROWS: Final = 3


class Scratch(NamedTuple):
    """For one block; `rows`, `orders` and `aims` are rows of LANES."""

    keys: NDArray[np.int32]
    """Sorting keys, by slot or seat: rows of LANES."""
    ages: NDArray[np.float32]
    """Of the targets, by slot [s]: rows of LANES."""
    target_pictures: NDArray[np.float32]
    """What one seat sees of each target in one group of lanes: see `PICTURE`."""
    rival_pictures: NDArray[np.float32]
    """And of each rival."""
    views: NDArray[np.float32]
    """The observations of one group of lanes, as they lie in memory."""
    docket: Docket
    """The requests of one lane: see `arbiter`."""
    rows: Block
    """A few rows for whatever a phase counts."""
    orders: Block
    """Of the rivals, by seat: see `order_of`."""
    aims: Block
    """R6.2's progress, by seat: see `aim_of`."""
    kept: Block
    """The block as it was, where some of its arenas have ended."""


def scratch_shapes(hunters: int, rows: int, columns: int) -> dict[str, tuple[int, ...]]:
    """The shapes of one thread's scratch memory, for blocks of so many rows and observations of so many columns."""
    views = len(WIDE) * hunters * columns + PICTURE  # with room for what is written too much
    return {
        "keys": (_MOST * LANES,),
        "ages": (_MOST * LANES,),
        "target_pictures": (_PICTURES,),
        "rival_pictures": (_PICTURES,),
        "views": (-(-views // LANES) * LANES,),  # whole cache lines: no two threads write to the same one
        "docket": (hunters, DOCKET_COLUMNS),
        "rows": (_ROWS * LANES,),
        "orders": (hunters * _ORDER_ROWS * LANES,),
        "aims": (hunters * _AIM_ROWS * LANES,),
        "kept": (rows * LANES,),
    }


@passage
def scratch_of(sections: Sections, thread: int) -> Scratch:
    """The scratch memory of one thread."""
    return Scratch(
        sections.keys[thread],
        sections.ages[thread],
        sections.target_pictures[thread],
        sections.rival_pictures[thread],
        sections.views[thread],
        sections.docket[thread],
        sections.rows[thread],
        sections.orders[thread],
        sections.aims[thread],
        sections.kept[thread],
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
