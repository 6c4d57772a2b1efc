"""What the core needs besides the arenas: scratch memory. Nothing here outlives a step."""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import types
from numba.extending import models, register_model
from numpy.typing import NDArray

from catch_arena.core.arbiter import REQUEST_COLUMNS, RequestTable
from catch_arena.core.extending import compiled_as, fields_as, packed, unpacked
from catch_arena.core.jit import Block, phase
from catch_arena.core.memory import SECTIONS, Sections, section_at, type_of_section
from catch_arena.core.state import LANES, MOST, PART_NAMES, RANKS_PER_WORD, WITHDRAWN
from catch_arena.core.transfers import STREAMED, TILE
from catch_arena.core.vectors import WIDE

_ROWS: Final = 2 + len(PART_NAMES)
"""As many as `rewards.reward_hunters` needs, which needs the most."""
_ORDER_ROWS: Final = MOST // RANKS_PER_WORD
_REFERENCE_ROWS: Final = 3
_PREY_REFERENCE_ROWS: Final = 4
GATHERED_SIZE: Final = WITHDRAWN + LANES
"""Of the rows of one prey: a body's, and all up to that which hides a hunter."""


class Scratch(NamedTuple):
    """For one block; `rows`, `requested_slots`, `rival_orders` and `progress_references` are rows of LANES."""

    keys: NDArray[np.int32]
    """Sorting keys, by slot or seat: rows of LANES."""
    positions: Block
    """Where the hunters are, in one group of lanes: see `ranking.note_positions`."""
    target_tiles: Block
    """What is known of the targets in one group of lanes, by slot and lane: see `tiles.tile_index`."""
    body_tiles: Block
    """And of the hunters, or of all prey."""
    staging: NDArray[np.float32]
    """The observations of one group of lanes, as they lie in memory."""
    requests: RequestTable
    """The open requests of one lane: see `arbiter`."""
    rows: Block
    """A few rows for whatever a phase counts."""
    requested_slots: Block
    """What each seat asks for in this step: see `requested_slots_of`."""
    rival_orders: Block
    """Of the rivals, by seat: see `rival_order_of`."""
    progress_references: Block
    """R6.2's progress, by seat: see `progress_reference_of`."""
    team_rows: Block
    """R11.2, of as many as there are hunters, or none: the catches of each team, by the seat that stands for it; and
    then what each seat has earned by itself.
    """
    prey_references: Block
    """R12.5's gain, by index: see `prey_reference_of`."""
    gathered_prey: Block
    """The bodies of prey, by index: see `gathered_of`."""
    snapshot: Block
    """The block as it was, where some of its arenas have ended."""


def scratch_shapes(hunters: int, prey: int, rows: int, columns: int, *, team_play: bool) -> dict[str, tuple[int, ...]]:
    """The shapes of one thread's scratch memory, for blocks of so many rows and, in an arena, observations of so many
    columns.
    """
    staging = len(WIDE) * columns + STREAMED  # with room for what is written too much
    return {
        "keys": (MOST * LANES,),
        "positions": (MOST * 2 * len(WIDE),),
        "target_tiles": ((MOST + 1) * len(WIDE) * TILE,),
        "body_tiles": ((MOST + 1) * len(WIDE) * TILE,),
        "staging": (-(-staging // LANES) * LANES,),  # whole cache lines: no two threads write to the same one
        "requests": (hunters, REQUEST_COLUMNS),
        "rows": (_ROWS * LANES,),
        "requested_slots": (hunters * LANES,),
        "rival_orders": (hunters * _ORDER_ROWS * LANES,),
        "progress_references": (hunters * _REFERENCE_ROWS * LANES,),
        "team_rows": (2 * hunters * LANES if team_play else 0,),
        "prey_references": (prey * _PREY_REFERENCE_ROWS * LANES,),
        "gathered_prey": (prey * GATHERED_SIZE,),
        "snapshot": (rows * LANES,),
    }


def scratch_of(sections: Sections, thread: int) -> Scratch:
    """The scratch memory of one thread."""
    return Scratch(*(getattr(sections, name)[thread] for name in Scratch._fields))


@phase
def requested_slots_of(scratch: Scratch, seat: int) -> Block:
    """What one seat asks for in this step, one row: a slot, NO_TARGET or MALFORMED_REQUEST."""
    return scratch.requested_slots[LANES * seat : LANES * (seat + 1)]


@phase
def rival_order_of(scratch: Scratch, seat: int) -> Block:
    """R7.1: the rivals of one seat, nearest first, as `state.slot_at_rank` reads them."""
    return scratch.rival_orders[_ORDER_ROWS * LANES * seat : _ORDER_ROWS * LANES * (seat + 1)]


@phase
def progress_reference_of(scratch: Scratch, seat: int) -> Block:
    """R6.2's progress of one seat, three rows: where the target is that was nearest after the commit, x and y [m], and
    how far it was [m], -1 for none.
    """
    return scratch.progress_references[_REFERENCE_ROWS * LANES * seat : _REFERENCE_ROWS * LANES * (seat + 1)]


@phase
def prey_reference_of(scratch: Scratch, index: int) -> Block:
    """R12.5's gain of one prey, four rows: see `prey.IN_PLAY` and those that follow."""
    return scratch.prey_references[_PREY_REFERENCE_ROWS * LANES * index : _PREY_REFERENCE_ROWS * LANES * (index + 1)]


@phase
def gathered_of(scratch: Scratch, index: int) -> Block:
    """R12.4: the body of one prey, with the rows of a seat up to WITHDRAWN, which is 1 while it is out."""
    return scratch.gathered_prey[GATHERED_SIZE * index : GATHERED_SIZE * (index + 1)]


# ---- for the compiler: see `memory` ----


class _ScratchAt(types.Type):
    """`Scratch`."""


_SCRATCH: Final = _ScratchAt("Scratch")


@register_model(_ScratchAt)
class _ScratchModel(models.StructModel):
    def __init__(self, manager: Any, of: _ScratchAt) -> None:
        super().__init__(manager, of, (("memory", SECTIONS), ("thread", types.int64)))


@compiled_as(scratch_of, lambda sections, _thread: _SCRATCH(sections, types.int64), 2)
def _(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
    return packed(context, builder, _SCRATCH, arguments)


def _type_of_scratch(_scratch: Any, name: str) -> Any:
    of = type_of_section(name) if name in Scratch._fields else None
    return None if of is None else of.row


@fields_as(_ScratchAt, _type_of_scratch)
def _(context: Any, builder: Any, _of: Any, scratch: Any, name: str) -> Any:
    memory, thread = unpacked(builder, scratch)
    return section_at(context, builder, memory, name, thread)
