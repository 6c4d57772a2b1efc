"""Rulebook chapter 2: how turtles move. Blocks of LANES arenas; metres, radians, seconds."""

from typing import Final

from catch_arena.core.jit import Block, inlined, phase, rare, rule
from catch_arena.core.math import clamp, sincos, wrap
from catch_arena.core.state import (
    AT_WALL,
    COSINE,
    LANES,
    SINE,
    SPEED,
    THETA,
    TIME,
    TURN_RATE,
    Settings,
    X,
    Y,
    seat_of,
    span,
)
from catch_arena.core.vectors import Width, any_of, floor, group, select

DT: Final = 0.016
"""R1.2: what one tick integrates [s]."""
TICK_MS: Final = 16.0
WATCHDOG_MS: Final = 1000.0
"""R2.4: a velocity command older than this is dropped."""


@rule
def next_pose(
    x: float,
    y: float,
    sine: float,
    cosine: float,
    stride: float,
    turn_sine: float,
    turn_cosine: float,
    side: float,
) -> tuple[float, float, float, float, bool]:
    """R2.2, R2.3: position and heading after one tick, and whether a wall held it; the heading turns first.

    Args:
        x: the position [m].
        y: the position [m].
        sine: of the heading.
        cosine: of the heading.
        stride: what a tick moves [m].
        turn_sine: of the angle by which a tick turns.
        turn_cosine: of the same.
        side: of the arena [m].
    """
    next_sine = sine * turn_cosine + cosine * turn_sine
    next_cosine = cosine * turn_cosine - sine * turn_sine
    free_x = x + next_cosine * stride
    free_y = y + next_sine * stride
    next_x = clamp(free_x, 0.0, side)
    next_y = clamp(free_y, 0.0, side)
    return next_x, next_y, next_sine, next_cosine, (next_x != free_x) | (next_y != free_y)


@rule
def turned(theta: float, turn: float, ticks: float) -> float:
    """R2.2: the heading after so many ticks, each of which turns it by `turn`."""
    return wrap(theta + turn * ticks)


@rule
def ticks_until(time_ms: float) -> float:
    """R1.2, R1.3: how many ticks fall in (0, time]."""
    return floor(time_ms / TICK_MS)


@phase
def move_body(me: Block, width: Width, side: float, fewest: int, most: int, ticks: Block) -> None:
    """R2.2, R2.3: all ticks of one seat in a step: from `fewest` on not every lane has them, from `most` on none."""
    for first in range(0, span(width), len(width)):
        lane = group(first, width)
        x, y, sine, cosine = me[X + lane], me[Y + lane], me[SINE + lane], me[COSINE + lane]
        stride = me[SPEED + lane] * DT
        turn = me[TURN_RATE + lane] * DT
        turn_sine, turn_cosine = sincos(turn)
        at_wall = False
        for _ in range(fewest):
            x, y, sine, cosine, held = next_pose(x, y, sine, cosine, stride, turn_sine, turn_cosine, side)
            at_wall = at_wall | held
        for tick in range(fewest, most):
            moves = ticks[lane] > tick
            next_x, next_y, next_sine, next_cosine, held = next_pose(
                x, y, sine, cosine, stride, turn_sine, turn_cosine, side
            )
            x = select(moves, next_x, x)
            y = select(moves, next_y, y)
            sine = select(moves, next_sine, sine)
            cosine = select(moves, next_cosine, cosine)
            at_wall = at_wall | (moves & held)
        me[X + lane] = x
        me[Y + lane] = y
        me[THETA + lane] = turned(me[THETA + lane], turn, ticks[lane])
        me[AT_WALL + lane] = select(at_wall, 1.0, 0.0)


@rare
def drop_stale_commands(block: Block, s: Settings, width: Width, stale: Block) -> None:
    """R2.4: what the watchdog leaves, where it fired in this step; it stops whatever moved."""
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        for first in range(0, span(width), len(width)):
            lane = group(first, width)
            me[SPEED + lane] = select(stale[lane] > 0.0, 0.0, me[SPEED + lane])
            me[TURN_RATE + lane] = select(stale[lane] > 0.0, 0.0, me[TURN_RATE + lane])


@inlined
def move(block: Block, s: Settings, width: Width, lanes: int, scratch: Block) -> None:
    """R1.3: all ticks in (t, t + period], one after the other; `scratch` has two rows.

    R2.4's watchdog stops a hunter at the first tick more than a second after its command: from there on it has no ticks
    that move it.
    """
    ticks, stale = scratch[:LANES], scratch[LANES : 2 * LANES]
    any_stale = False
    for first in range(0, span(width), len(width)):
        lane = group(first, width)
        before = ticks_until(block[TIME + lane])
        due = ticks_until(block[TIME + lane] + s.period) - before
        fresh = ticks_until(block[TIME + lane] + WATCHDOG_MS) - before
        ticks[lane] = select(fresh < due, fresh, due)
        stale[lane] = select(fresh < due, 1.0, 0.0)
        any_stale = any_stale | any_of(fresh < due)
    most, fewest = 0.0, 1e18
    for each in range(lanes):
        most = max(most, ticks[each])
        fewest = min(fewest, ticks[each])
    for seat in range(s.hunters):
        move_body(seat_of(block, seat), width, s.side, int(fewest), int(most), ticks)
    if any_stale:
        drop_stale_commands(block, s, width, stale)
