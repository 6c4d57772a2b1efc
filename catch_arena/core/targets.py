"""Rulebook R3.8 to R3.10: what a target that moves decides in phase 2. All of it reads S_t only.

Blocks of LANES arenas; metres, radians, seconds.
"""

from typing import Final

from catch_arena.core.arbiter import measure_um
from catch_arena.core.jit import Block, outlined, phase, rule
from catch_arena.core.math import atan2, below_pi, clamp
from catch_arena.core.random import seed_of, threat_lot, wander_draw
from catch_arena.core.state import (
    ALIVE,
    APPEARED,
    AT_WALL,
    BODY,
    COSINE,
    FLEEING,
    LANES,
    NUMBER,
    SEED_HIGH,
    SEED_LOW,
    SINE,
    SPEED,
    STEP,
    TARGET_X,
    TARGET_Y,
    TIME,
    TURN_RATE,
    WANDER,
    WANDER_ENDS,
    WITHDRAWN,
    Settings,
    X,
    Y,
    most_alive,
    seat_of,
    span,
)
from catch_arena.core.vectors import Width, any_of, floor, group, select, sqrt

STEERING_GAIN: Final = 6.0
"""R3.9, R3.10: turn rate for each radian of bearing error [1/s]."""
_NO_THREAT: Final = 1e300
"""How far a threat is that is none, in micrometres or squared."""
_TIED_M: Final = 4e-6
"""For each metre of the side: the squares of two distances in the arena that round to the same micrometre differ by
less, as one of them is less than a micrometre longer, and neither is longer than 1.5 sides.
"""


@rule
def push(position: float, side: float) -> float:
    """R3.10: how strongly a wall nearer than a metre pushes back [m]: up or right where that is positive.

    Args:
        position: along one axis [m].
        side: of the arena [m].
    """
    return select(position < 1.0, 1.0 - position, select(position > side - 1.0, (side - 1.0) - position, 0.0))


@rule
def steered(east: float, north: float, sine: float, cosine: float, most: float) -> float:
    """R3.9, R3.10: the turn rate towards a direction, within [-most, most] [rad/s]; the error is R4.2's.

    Args:
        east: of the direction, in any unit.
        north: of the same.
        sine: of the target's heading.
        cosine: of the same.
        most: the greatest turn rate [rad/s].
    """
    error = below_pi(atan2(cosine * north - sine * east, cosine * east + sine * north))
    return clamp(STEERING_GAIN * error, -most, most)


@outlined
def renew_wander(block: Block, targets: Block, lane: int, at: int, s: Settings) -> None:
    """R3.9: the draw of the period that a target is in, where its last one has ended; it is kept until it ends.

    Args:
        at: where in `targets` the slot begins, its lane included.
    """
    period = floor((block[TIME + lane] - targets[APPEARED + at]) / s.wander_period_ms)
    seed = seed_of(block[SEED_HIGH + lane], block[SEED_LOW + lane])
    targets[WANDER + at] = wander_draw(seed, targets[NUMBER + at], period)
    targets[WANDER_ENDS + at] = targets[APPEARED + at] + (period + 1.0) * s.wander_period_ms


@phase
def keep_wandering(block: Block, targets: Block, width: Width, slot: int, s: Settings) -> None:
    """R3.9: the targets in one slot have the draws of the periods that they are in.

    Args:
        slot: which target.
    """
    for first in range(0, span(width), len(width)):
        lane = group(first, width)
        ended = targets[slot * s.slot_size + WANDER_ENDS + lane] <= block[TIME + lane]
        if any_of(ended & (block[ALIVE + lane] > slot)):
            for each in range(first, first + len(width)):
                at = slot * s.slot_size + each
                if targets[WANDER_ENDS + at] <= block[TIME + each] and block[ALIVE + each] > slot:
                    renew_wander(block, targets, each, at, s)


@outlined
def nearest_hunter(block: Block, targets: Block, lane: int, at: int, s: Settings) -> int:
    """R3.10, R12.5: the seat nearest to one target, by lot where several are equally near; -1 where all are withdrawn.

    Args:
        at: where in `targets` the target is, its lane included.
    """
    seed = seed_of(block[SEED_HIGH + lane], block[SEED_LOW + lane])
    step, number = block[STEP + lane], targets[NUMBER + at]
    chosen = -1
    nearest = _NO_THREAT
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        if me[WITHDRAWN + lane] > 0.0:
            continue
        um = measure_um(targets[TARGET_X + at] - me[X + lane], targets[TARGET_Y + at] - me[Y + lane])
        tied = um == nearest
        if um < nearest or (tied and threat_lot(seed, step, number, seat) < threat_lot(seed, step, number, chosen)):
            chosen, nearest = seat, um
    return chosen


@phase
def find_threats(block: Block, targets: Block, width: Width, slot: int, s: Settings, threats: Block) -> None:
    """R3.10: the nearest hunter of one target.

    Args:
        slot: which target.
        threats: the result, three rows: the square of its distance [m2], and where the target is from it, east and
            north [m].
    """
    margin = _TIED_M * s.side_m
    for first in range(0, span(width), len(width)):
        lane = group(first, width)
        x, y = targets[slot * s.slot_size + TARGET_X + lane], targets[slot * s.slot_size + TARGET_Y + lane]
        # times 0: a number for each lane, as the loop below has them
        nearest, second, east, north = 0.0 * x + _NO_THREAT, 0.0 * x + _NO_THREAT, 0.0 * x, 0.0 * x
        for seat in range(s.hunters):
            me = seat_of(block, seat)
            dx, dy = x - me[X + lane], y - me[Y + lane]
            square = select(me[WITHDRAWN + lane] > 0.0, _NO_THREAT, dx * dx + dy * dy)
            nearer = square < nearest
            second = select(nearer, nearest, select(square < second, square, second))
            east = select(nearer, dx, east)
            north = select(nearer, dy, north)
            nearest = select(nearer, square, nearest)
        threats[lane] = nearest
        threats[LANES + lane] = east
        threats[2 * LANES + lane] = north
        may_tie = second - nearest < margin
        if any_of(may_tie & (nearest < s.alarm_limit_m2) & (block[ALIVE + lane] > slot)):
            for each in range(first, first + len(width)):
                at = slot * s.slot_size + each
                seat = nearest_hunter(block, targets, each, at, s)
                if seat >= 0:
                    threats[LANES + each] = targets[TARGET_X + at] - seat_of(block, seat)[X + each]
                    threats[2 * LANES + each] = targets[TARGET_Y + at] - seat_of(block, seat)[Y + each]


@phase
def steer(block: Block, targets: Block, width: Width, slot: int, s: Settings, threats: Block) -> None:
    """R3.9, R3.10: the command of the targets in one slot: away from a threat, else to the centre where a wall held
    them, else on in an arc.

    Args:
        slot: which target; its speed and turn rate are written.
        threats: as `find_threats` writes them; read where targets flee.
    """
    for first in range(0, span(width), len(width)):
        lane = group(first, width)
        at = slot * s.slot_size + lane
        x, y = targets[TARGET_X + at], targets[TARGET_Y + at]
        sine, cosine = targets[BODY + SINE + at], targets[BODY + COSINE + at]
        held = targets[BODY + AT_WALL + at] > 0.0
        east, north = s.side_m / 2.0 - x, s.side_m / 2.0 - y
        speed = s.target_speed_mps
        steers = held
        if s.target_motion == FLEEING:
            threatened = threats[lane] < s.alarm_limit_m2
            dx, dy = threats[LANES + lane], threats[2 * LANES + lane]
            distance = sqrt(dx * dx + dy * dy)
            apart = distance > 0.0
            away = select(apart, distance, 1.0)
            east = select(threatened, select(apart, dx / away, cosine) + 2.0 * push(x, s.side_m), east)
            north = select(threatened, select(apart, dy / away, sine) + 2.0 * push(y, s.side_m), north)
            speed = select(threatened, s.target_speed_mps, s.target_speed_mps / 2.0)
            steers = steers | threatened
        alive = block[ALIVE + lane] > slot
        turn_rate = targets[WANDER + at] * s.target_turn_rate_radps
        if any_of(steers & alive):
            turn_rate = select(steers, steered(east, north, sine, cosine, s.target_turn_rate_radps), turn_rate)
        targets[BODY + SPEED + at] = select(alive, speed, 0.0)
        targets[BODY + TURN_RATE + at] = select(alive, turn_rate, 0.0)


@phase
def command_targets(block: Block, s: Settings, width: Width, lanes: int, targets: Block, threats: Block) -> None:
    """R3.8: what every target that moves does in this step.

    Args:
        threats: room for three rows: see `find_threats`.
    """
    for slot in range(most_alive(block, lanes)):
        keep_wandering(block, targets, width, slot, s)
        if s.target_motion == FLEEING:
            find_threats(block, targets, width, slot, s, threats)
        steer(block, targets, width, slot, s, threats)
