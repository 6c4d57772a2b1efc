"""Rulebook chapter 6: the named parts of the reward, and their weighted sum."""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.arbiter import distance_um
from catch_arena.core.jit import Block, phase
from catch_arena.core.state import (
    ALIVE,
    CATCH,
    ELAPSED,
    LANES,
    LOST,
    NEAREST_DISTANCE,
    NEAREST_X,
    NEAREST_Y,
    PROGRESS,
    REJECTED,
    RIVAL_CATCH,
    SEEN,
    VERDICT,
    WITHDRAWN,
    Settings,
    Targets,
    X,
    Y,
    seat_of,
)
from catch_arena.verdicts import Verdict

_LOST_CONTEST = float(Verdict.LOST_CONTEST)
_GRANTED = float(Verdict.GRANTED)


@phase
def aim_at_nearest(me: Block, view: Block, targets: Targets, lanes: int) -> None:
    """R6.2's progress: the nearest target of S_t, from where the hunter stands."""
    for lane in range(lanes):
        seen = me[SEEN + lane] > 0.0
        slot = np.uint64(max(view[lane], 0.0)) * np.uint64(LANES) + np.uint64(lane)
        dx = targets.x[slot] - me[X + lane]
        dy = targets.y[slot] - me[Y + lane]
        me[NEAREST_X + lane] = targets.x[slot]
        me[NEAREST_Y + lane] = targets.y[slot]
        me[NEAREST_DISTANCE + lane] = sqrt(dx * dx + dy * dy) if seen else -1.0


@phase
def aim_again(arena: Block, me: Block, targets: Targets, lane: int) -> None:
    """The same in one lane where targets have just left: among those that are alive after the commit."""
    me[NEAREST_DISTANCE + lane] = -1.0
    nearest = np.inf
    for slot in range(int(arena[ALIVE + lane])):
        dx = targets.x[slot * LANES + lane] - me[X + lane]
        dy = targets.y[slot * LANES + lane] - me[Y + lane]
        micrometres = distance_um(dx, dy)
        if micrometres < nearest:  # slots are in spawning order: the lower number stays
            nearest = micrometres
            me[NEAREST_X + lane] = targets.x[slot * LANES + lane]
            me[NEAREST_Y + lane] = targets.y[slot * LANES + lane]
            me[NEAREST_DISTANCE + lane] = sqrt(dx * dx + dy * dy)


@phase
def reward(block: Block, s: Settings, lanes: int, catches: Block, rewards: NDArray[np.float64]) -> None:
    """R6.2: the parts, and their sum; `catches` is scratch of one row."""
    for lane in range(lanes):
        catches[lane] = 0.0
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        for lane in range(lanes):
            catches[lane] += 1.0 if me[VERDICT + lane] == _GRANTED else 0.0
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        for lane in range(lanes):
            counts = 1.0 if me[WITHDRAWN + lane] == 0.0 else 0.0
            verdict = me[VERDICT + lane]
            granted = 1.0 if verdict == _GRANTED else 0.0
            refused = (verdict > 0.0) & (verdict < _GRANTED) & (verdict != _LOST_CONTEST)
            dx = me[NEAREST_X + lane] - me[X + lane]
            dy = me[NEAREST_Y + lane] - me[Y + lane]
            gained = me[NEAREST_DISTANCE + lane] - sqrt(dx * dx + dy * dy)
            me[CATCH + lane] = granted
            me[RIVAL_CATCH + lane] = counts * (catches[lane] - granted)
            me[LOST + lane] = 1.0 if verdict == _LOST_CONTEST else 0.0
            me[REJECTED + lane] = counts if refused else 0.0
            me[PROGRESS + lane] = gained if (me[NEAREST_DISTANCE + lane] >= 0.0) & (counts > 0.0) else 0.0
            me[ELAPSED + lane] = counts * s.period_s
        for lane in range(lanes):
            rewards[lane, seat] = (
                s.catch_weight * me[CATCH + lane]
                + s.rival_catch_weight * me[RIVAL_CATCH + lane]
                + s.lost_contest_weight * me[LOST + lane]
                + s.rejected_request_weight * me[REJECTED + lane]
                + s.progress_weight * me[PROGRESS + lane]
                + s.time_weight * me[ELAPSED + lane]
            )
