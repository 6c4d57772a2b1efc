"""Rulebook R3.8 to R3.10: decisions of moving targets in phase 2. They all read S_t only.

Chunks of LANES arenas; metres, radians, seconds.
"""

from typing import Final

import numpy as np

from catch_arena.core import rows
from catch_arena.core.arbiter import measure_um
from catch_arena.core.jit import Rows, outlined, phase, rule
from catch_arena.core.math import atan2, below_pi, clamp
from catch_arena.core.random import seed_of, threat_lot, wander_draw
from catch_arena.core.state import FLEEING, Settings, most_alive, seat_of
from catch_arena.core.vectors import LANES, Width, any_of, floor, group, played_lanes, select, sqrt

STEERING_GAIN: Final = 6.0
"""R3.9, R3.10: turn rate for each radian of bearing error [1/s]."""


@rule
def push(position: float, side: float) -> float:
    """R3.10: return the push of a wall nearer than a metre [m]: positive to the right or up."""
    return select(position < 1.0, 1.0 - position, select(position > side - 1.0, (side - 1.0) - position, 0.0))


@rule
def steered(east: float, north: float, sine: float, cosine: float, most: float) -> float:
    """R3.9, R3.10: return the turn rate towards a direction, in [-most, most] [rad/s]; the error is R4.2's."""
    error = below_pi(atan2(cosine * north - sine * east, cosine * east + sine * north))
    return clamp(STEERING_GAIN * error, -most, most)


@outlined
def renew_wander(chunk: Rows, s: Settings, lane: int, targets: Rows, at: int) -> None:
    """R3.9: draw the turn of a target's current period after the last period has ended."""
    period = floor((chunk[rows.TIME + lane] - targets[rows.APPEARED + at]) / s.wander_period_ms)
    seed = seed_of(chunk, lane)
    targets[rows.WANDER + at] = wander_draw(seed, targets[rows.NUMBER + at], period)
    targets[rows.WANDER_ENDS + at] = targets[rows.APPEARED + at] + (period + 1.0) * s.wander_period_ms


@phase
def keep_wandering(chunk: Rows, s: Settings, lanes: int, targets: Rows, slot: int) -> None:
    """R3.9: draw the turns of the targets in one slot whose periods have ended."""
    for lane in range(lanes):
        at = slot * s.slot_size + lane
        if targets[rows.WANDER_ENDS + at] <= chunk[rows.TIME + lane] and chunk[rows.ALIVE + lane] > slot:
            renew_wander(chunk, s, lane, targets, at)


@outlined
def nearest_hunter(chunk: Rows, s: Settings, lane: int, targets: Rows, at: int) -> int:
    """R3.10, R12.5: return the seat nearest to a target, by lot if several are equally near; NO_SEAT for none."""
    seed = seed_of(chunk, lane)
    step, number = chunk[rows.STEP + lane], targets[rows.NUMBER + at]
    chosen = rows.NO_SEAT
    nearest = np.inf
    for seat in range(s.hunters):
        me = seat_of(chunk, seat)
        if me[rows.WITHDRAWN + lane] > 0.0:
            continue
        um = measure_um(
            targets[rows.TARGET_X + at] - me[rows.X + lane], targets[rows.TARGET_Y + at] - me[rows.Y + lane]
        )
        tied = um == nearest
        if um < nearest or (tied and threat_lot(seed, step, number, seat) < threat_lot(seed, step, number, chosen)):
            chosen, nearest = seat, um
    return chosen


@phase
def find_threats(chunk: Rows, s: Settings, width: Width, targets: Rows, slot: int, threats: Rows) -> None:
    """R3.10: find the hunter nearest to each target in one slot. The result is three rows: the hunter's distance
    [micrometres], infinite if there is none, and the target's position relative to it, east and north [m].
    """
    for first in range(0, played_lanes(width), len(width)):
        lane = group(first, width)
        x, y = targets[slot * s.slot_size + rows.TARGET_X + lane], targets[slot * s.slot_size + rows.TARGET_Y + lane]
        threats[lane] = np.inf
        some_tied = False
        for seat in range(s.hunters):
            me = seat_of(chunk, seat)
            dx, dy = x - me[rows.X + lane], y - me[rows.Y + lane]
            um = select(me[rows.WITHDRAWN + lane] > 0.0, np.inf, measure_um(dx, dy))
            nearer = um < threats[lane]
            some_tied = some_tied | any_of(um == threats[lane])
            threats[LANES + lane] = select(nearer, dx, threats[LANES + lane])
            threats[2 * LANES + lane] = select(nearer, dy, threats[2 * LANES + lane])
            threats[lane] = select(nearer, um, threats[lane])
        for one_lane in range(first, first + len(width) if some_tied else first):
            at = slot * s.slot_size + one_lane
            seat = nearest_hunter(chunk, s, one_lane, targets, at)
            if seat != rows.NO_SEAT:
                threats[LANES + one_lane] = targets[rows.TARGET_X + at] - seat_of(chunk, seat)[rows.X + one_lane]
                threats[2 * LANES + one_lane] = targets[rows.TARGET_Y + at] - seat_of(chunk, seat)[rows.Y + one_lane]


@phase
def steer(chunk: Rows, s: Settings, width: Width, targets: Rows, slot: int, threats: Rows) -> None:
    """R3.9, R3.10: command the targets in one slot: away from a threat, else to the centre if a wall held them, else on
    in an arc. If targets flee, `find_threats` comes first.
    """
    for first in range(0, played_lanes(width), len(width)):
        lane = group(first, width)
        at = slot * s.slot_size + lane
        x, y = targets[rows.TARGET_X + at], targets[rows.TARGET_Y + at]
        sine, cosine = targets[rows.BODY + rows.SINE + at], targets[rows.BODY + rows.COSINE + at]
        held = targets[rows.BODY + rows.AT_WALL + at] > 0.0
        east, north = s.side_m / 2.0 - x, s.side_m / 2.0 - y
        speed = s.target_speed_mps
        steers = held
        if s.target_motion == FLEEING:
            threatened = threats[lane] < s.alarm_um
            dx, dy = threats[LANES + lane], threats[2 * LANES + lane]
            distance = sqrt(dx * dx + dy * dy)
            apart = distance > 0.0
            away = select(apart, distance, 1.0)
            east = select(threatened, select(apart, dx / away, cosine) + 2.0 * push(x, s.side_m), east)
            north = select(threatened, select(apart, dy / away, sine) + 2.0 * push(y, s.side_m), north)
            speed = select(threatened, s.target_speed_mps, s.target_speed_mps / 2.0)
            steers = steers | threatened
        alive = chunk[rows.ALIVE + lane] > slot
        turn_rate = targets[rows.WANDER + at] * s.target_turn_rate_radps
        if any_of(steers & alive):
            turn_rate = select(steers, steered(east, north, sine, cosine, s.target_turn_rate_radps), turn_rate)
        targets[rows.BODY + rows.SPEED + at] = select(alive, speed, 0.0)
        targets[rows.BODY + rows.TURN_RATE + at] = select(alive, turn_rate, 0.0)


@phase
def command_targets(chunk: Rows, s: Settings, width: Width, lanes: int, targets: Rows, threats: Rows) -> None:
    """R3.8: command every moving target for this step; `threats` is room for the rows of `find_threats`."""
    for slot in range(most_alive(chunk, lanes)):
        keep_wandering(chunk, s, lanes, targets, slot)
        if s.target_motion == FLEEING:
            find_threats(chunk, s, width, targets, slot, threats)
        steer(chunk, s, width, targets, slot, threats)
