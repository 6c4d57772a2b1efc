"""Rulebook chapter 6: the named parts of the reward, and their weighted sum."""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.arbiter import distance_um
from catch_arena.core.jit import Block, phase
from catch_arena.core.state import (
    ALIVE,
    LANES,
    RETURN,
    VERDICT,
    WITHDRAWN,
    Settings,
    Targets,
    X,
    Y,
    item_at,
    seat_of,
)
from catch_arena.core.workspace import Scratch, aim_of
from catch_arena.verdicts import Verdict

_LOST_CONTEST = float(Verdict.LOST_CONTEST)
_GRANTED = float(Verdict.GRANTED)

Rewards = NDArray[np.float64]
"""(lanes, H, 1): the sum; or (lanes, H, 7), with R6.2's parts behind it in the order of `state.PART_NAMES`."""


@phase
def aim_at_nearest(arena: Block, me: Block, view: Block, targets: Targets, lanes: int, aim: Block) -> None:
    """R6.2's progress: the nearest target of S_t, from where the hunter stands."""
    for lane in range(lanes):
        at = item_at(view, 0, lane) * LANES + lane
        dx = targets.x[at] - me[X + lane]
        dy = targets.y[at] - me[Y + lane]
        aim[lane] = targets.x[at]
        aim[LANES + lane] = targets.y[at]
        aim[2 * LANES + lane] = sqrt(dx * dx + dy * dy) if arena[ALIVE + lane] > 0.0 else -1.0


@phase
def aim_again(arena: Block, me: Block, targets: Targets, lane: int, aim: Block) -> None:
    """The same in one lane where targets have just left: among those that are alive after the commit."""
    aim[2 * LANES + lane] = -1.0
    nearest = np.inf
    for slot in range(int(arena[ALIVE + lane])):
        dx = targets.x[slot * LANES + lane] - me[X + lane]
        dy = targets.y[slot * LANES + lane] - me[Y + lane]
        micrometres = distance_um(dx, dy)
        if micrometres < nearest:  # slots are in spawning order: the lower number stays
            nearest = micrometres
            aim[lane] = targets.x[slot * LANES + lane]
            aim[LANES + lane] = targets.y[slot * LANES + lane]
            aim[2 * LANES + lane] = sqrt(dx * dx + dy * dy)


@phase
def reward(
    block: Block,
    s: Settings,
    lanes: int,
    scratch: Scratch,
    rewards: Rewards,
) -> None:
    """R6.2: the sum of the parts, and the parts where there is room for them."""
    catches = scratch.rows[:LANES]
    parts_wanted = rewards.shape[2] > 1
    for lane in range(lanes):
        catches[lane] = 0.0
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        for lane in range(lanes):
            catches[lane] += 1.0 if me[VERDICT + lane] == _GRANTED else 0.0
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        aim = aim_of(scratch, seat)
        for lane in range(lanes):
            counts = 1.0 if me[WITHDRAWN + lane] == 0.0 else 0.0
            verdict = me[VERDICT + lane]
            granted = 1.0 if verdict == _GRANTED else 0.0
            rival = counts * (catches[lane] - granted)
            lost = 1.0 if verdict == _LOST_CONTEST else 0.0
            refused = (verdict > 0.0) & (verdict < _GRANTED) & (verdict != _LOST_CONTEST)
            rejected = counts if refused else 0.0
            progress = 0.0
            if s.progress_wanted:
                dx = aim[lane] - me[X + lane]
                dy = aim[LANES + lane] - me[Y + lane]
                gained = aim[2 * LANES + lane] - sqrt(dx * dx + dy * dy)
                progress = gained if (aim[2 * LANES + lane] >= 0.0) & (counts > 0.0) else 0.0
            elapsed = counts * s.period_s
            total = (
                s.catch_weight * granted
                + s.rival_catch_weight * rival
                + s.lost_contest_weight * lost
                + s.rejected_request_weight * rejected
                + s.progress_weight * progress
                + s.time_weight * elapsed
            )
            rewards[lane, seat, 0] = total
            me[RETURN + lane] += total
            if parts_wanted:
                rewards[lane, seat, 1] = granted
                rewards[lane, seat, 2] = rival
                rewards[lane, seat, 3] = lost
                rewards[lane, seat, 4] = rejected
                rewards[lane, seat, 5] = progress
                rewards[lane, seat, 6] = elapsed
