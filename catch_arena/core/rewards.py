"""Rulebook chapter 6: the named parts of the reward, and their weighted sum."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.jit import Block, phase, rare
from catch_arena.core.ranking import FAR, key_of
from catch_arena.core.state import (
    ALIVE,
    COSINE,
    LANES,
    RETURN,
    SEEN,
    SINE,
    TARGET_X,
    TARGET_Y,
    VERDICT,
    WITHDRAWN,
    SeatLimits,
    Settings,
    X,
    Y,
    seat_of,
    slot_at_rank,
    span,
)
from catch_arena.core.vectors import Width, group, select, sqrt
from catch_arena.core.visibility import is_seen
from catch_arena.core.workspace import Scratch, progress_reference_of
from catch_arena.verdicts import Verdict

PART_NAMES: Final = ("catch", "rival_catch", "lost_contest", "rejected_request", "progress", "time")
"""R6.2's parts of the reward, in the order in which they are written."""

_LOST_CONTEST: Final = float(Verdict.LOST_CONTEST)
_GRANTED: Final = float(Verdict.GRANTED)

Rewards = NDArray[np.float32]
"""(lanes, H): the sum."""
Parts = NDArray[np.float64]
"""(lanes, H, 7): the sum, and R6.2's parts in the order of `PART_NAMES`."""


@phase
def set_progress_reference(me: Block, order: Block, targets: Block, lanes: int, s: Settings, reference: Block) -> None:
    """R6.2's progress: the nearest target that is seen on S_t, from where the hunter stands."""
    for lane in range(lanes):
        there = me[SEEN + lane] > 0.0
        at = select(there, slot_at_rank(order, 0, lane), 0) * s.slot_size + lane
        dx = targets[TARGET_X + at] - me[X + lane]
        dy = targets[TARGET_Y + at] - me[Y + lane]
        reference[lane] = targets[TARGET_X + at]
        reference[LANES + lane] = targets[TARGET_Y + at]
        reference[2 * LANES + lane] = select(there, sqrt(dx * dx + dy * dy), -1.0)


@rare
def renew_progress_reference(
    block: Block, me: Block, targets: Block, lane: int, s: Settings, limits: SeatLimits, reference: Block
) -> None:
    """The same in one lane where targets have just left: among those that are alive after the commit."""
    reference[2 * LANES + lane] = -1.0
    nearest = FAR
    for slot in range(int(block[ALIVE + lane])):
        at = slot * s.slot_size + lane
        dx = targets[TARGET_X + at] - me[X + lane]
        dy = targets[TARGET_Y + at] - me[Y + lane]
        key = key_of(dx, dy, slot)
        if key < nearest and is_seen(dx, dy, me[SINE + lane], me[COSINE + lane], limits.reach_um, s):
            nearest = key
            reference[lane] = targets[TARGET_X + at]
            reference[LANES + lane] = targets[TARGET_Y + at]
            reference[2 * LANES + lane] = sqrt(dx * dx + dy * dy)


@phase
def reward(
    block: Block, s: Settings, width: Width, lanes: int, scratch: Scratch, rewards: Rewards, parts: Parts
) -> None:
    """R6.2: the sum of the parts, and the parts where there is room for them, and `rewards` where there is not."""
    catches = scratch.rows[:LANES]
    amounts = scratch.rows[LANES : (2 + len(PART_NAMES)) * LANES]  # the sum, and the parts in their order
    parts_wanted = len(parts) > 0
    for first in range(0, span(width), len(width)):
        lane = group(first, width)
        granted = 0.0
        for seat in range(s.hunters):
            granted = granted + select(seat_of(block, seat)[VERDICT + lane] == _GRANTED, 1.0, 0.0)
        catches[lane] = granted
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        reference = progress_reference_of(scratch, seat)
        for first in range(0, span(width), len(width)):
            lane = group(first, width)
            counts = select(me[WITHDRAWN + lane] == 0.0, 1.0, 0.0)
            verdict = me[VERDICT + lane]
            granted = select(verdict == _GRANTED, 1.0, 0.0)
            rival = counts * (catches[lane] - granted)
            lost = select(verdict == _LOST_CONTEST, 1.0, 0.0)
            refused = (verdict > 0.0) & (verdict < _GRANTED) & (verdict != _LOST_CONTEST)
            rejected = select(refused, counts, 0.0)
            progress = 0.0
            if s.progress_wanted:
                dx = reference[lane] - me[X + lane]
                dy = reference[LANES + lane] - me[Y + lane]
                gained = reference[2 * LANES + lane] - sqrt(dx * dx + dy * dy)
                progress = select((reference[2 * LANES + lane] >= 0.0) & (counts > 0.0), gained, 0.0)
            elapsed = counts * s.period_s
            total = (
                s.catch_weight * granted
                + s.rival_catch_weight * rival
                + s.lost_contest_weight * lost
                + s.rejected_request_weight * rejected
                + s.progress_weight * progress
                + s.time_weight * elapsed
            )
            me[RETURN + lane] = me[RETURN + lane] + total
            amounts[lane] = total
            if not parts_wanted:
                continue
            amounts[LANES + lane] = granted
            amounts[2 * LANES + lane] = rival
            amounts[3 * LANES + lane] = lost
            amounts[4 * LANES + lane] = rejected
            amounts[5 * LANES + lane] = progress
            amounts[6 * LANES + lane] = elapsed
        for lane in range(lanes):
            if not parts_wanted:
                rewards[lane, seat] = np.float32(amounts[lane])
                continue
            for column in range(1 + len(PART_NAMES)):
                parts[lane, seat, column] = amounts[column * LANES + lane]
