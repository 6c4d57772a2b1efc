"""Rulebook R1.6, R1.7: withdrawal of hunters, by a call or by chance."""

import numpy as np
from numpy.typing import NDArray

from catch_arena.core import rows
from catch_arena.core.jit import Rows, entry, outlined
from catch_arena.core.memory import Bytes, sections_of
from catch_arena.core.random import drops_out, seed_of
from catch_arena.core.state import Settings, prey_of, seat_of
from catch_arena.core.vectors import LANES


@outlined
def withdraw(me: Rows, lane: int) -> None:
    """R1.6: withdraw a hunter: it stands still, and the others do not see it; `me` has the rows of its seat."""
    me[rows.WITHDRAWN + lane] = 1.0
    for offset in rows.AT_REST:
        me[offset + lane] = 0.0


@outlined
def drop_out(chunk: Rows, s: Settings, lanes: int) -> None:
    """R1.7: withdraw the hunters that drop out in this step, before everything else."""
    for lane in range(lanes):
        seed = seed_of(chunk, lane)
        for seat in range(s.hunters):
            me = seat_of(chunk, seat)
            if me[rows.WITHDRAWN + lane] == 0.0 and drops_out(seed, chunk[rows.STEP + lane], seat, s.dropout_rate):
                withdraw(me, lane)


@outlined
def write_active(chunk: Rows, s: Settings, lanes: int, active: NDArray[np.int8]) -> None:
    """R1.6, R1.7, R12.3: write 1 for hunters that take part and for prey that is in play, else 0; `active`, (lanes, N),
    is the result.
    """
    for seat in range(s.hunters):
        me = seat_of(chunk, seat)
        for lane in range(lanes):
            active[lane, seat] = 1 if me[rows.WITHDRAWN + lane] == 0.0 else 0
    for index in range(s.prey):
        me = prey_of(chunk, s, index)
        for lane in range(lanes):
            active[lane, s.hunters + index] = 0 if me[rows.PREY_SLOT + lane] == rows.NO_TARGET else 1


@entry
def withdraw_at(memory: Bytes, arena: int, seat: int) -> None:
    """R1.6: withdraw the hunter in one seat."""
    withdraw(seat_of(sections_of(memory, 0).chunks[arena // LANES], seat), arena % LANES)
