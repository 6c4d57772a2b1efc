"""Rulebook chapter 2: motion of turtles. Chunks of LANES arenas; metres, radians, seconds."""

from typing import Final

from catch_arena.core import rows
from catch_arena.core.jit import Rows, outlined, phase, rule
from catch_arena.core.math import clamp, sincos, wrap
from catch_arena.core.state import Settings, body_of, most_alive, most_in, seat_of
from catch_arena.core.vectors import LANES, Width, floor, group, played_lanes, select

TICK_MS: Final = 16
"""R1.2: time from one tick to the next [ms]."""
DT: Final = TICK_MS / 1000
"""Time step of one tick [s]."""
WATCHDOG_MS: Final = 1000
"""R2.4: age [ms] after which a velocity command is dropped."""


@rule
def next_pose(
    x: float, y: float, sine: float, cosine: float, stride: float, turn_sine: float, turn_cosine: float, side: float
) -> tuple[float, float, float, float, bool]:
    """R2.2, R2.3: return position and heading after one tick, and whether a wall held it; the heading turns first.
    In a tick the body moves by `stride` [m], and turns by the angle of `turn_sine` and `turn_cosine`.
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
    """R2.2: return the heading after a number of ticks, each of which turns it by `turn`."""
    return wrap(theta + turn * ticks)


@rule
def ticks_until(time_ms: float) -> float:
    """R1.2, R1.3: return the number of ticks in (0, time]."""
    return floor(time_ms / TICK_MS)


@phase
def move_body(me: Rows, width: Width, side: float, most: int, ticks: Rows) -> None:
    """R2.2, R2.3: move one body by all ticks of a step: `ticks` has their number in each lane, `most` the greatest."""
    for first in range(0, played_lanes(width), len(width)):
        lane = group(first, width)
        x, y, sine, cosine = me[rows.X + lane], me[rows.Y + lane], me[rows.SINE + lane], me[rows.COSINE + lane]
        stride = me[rows.SPEED + lane] * DT
        turn = me[rows.TURN_RATE + lane] * DT
        turn_sine, turn_cosine = sincos(turn)
        at_wall = False
        for tick in range(most):
            moves = ticks[lane] > tick
            next_x, next_y, sine, cosine, held = next_pose(x, y, sine, cosine, stride, turn_sine, turn_cosine, side)
            x = select(moves, next_x, x)
            y = select(moves, next_y, y)
            at_wall = at_wall | (moves & held)
        me[rows.X + lane] = x
        me[rows.Y + lane] = y
        me[rows.THETA + lane] = turned(me[rows.THETA + lane], turn, ticks[lane])
        me[rows.AT_WALL + lane] = select(at_wall, 1.0, 0.0)


@outlined
def drop_stale_commands(chunk: Rows, s: Settings, lanes: int, due: Rows, fresh: Rows) -> None:
    """R2.4: stop the hunters whose commands the watchdog dropped in this step; `due` and `fresh` as in `move`."""
    for seat in range(s.hunters):
        me = seat_of(chunk, seat)
        for lane in range(lanes):
            if fresh[lane] < due[lane]:
                me[rows.SPEED + lane] = 0.0
                me[rows.TURN_RATE + lane] = 0.0


@phase
def move(chunk: Rows, s: Settings, width: Width, lanes: int, targets: Rows, counts: Rows) -> None:
    """R1.3: play all ticks in (t, t + period], one after the other.

    R2.4's watchdog stops a hunter at the first tick more than a second after its command: later ticks do not move it.
    Targets have no watchdog (R3.8). `counts` is room for two rows: the number of ticks of each lane, and the number
    before its commands are stale.
    """
    due, fresh = counts[:LANES], counts[LANES : 2 * LANES]
    for first in range(0, played_lanes(width), len(width)):
        lane = group(first, width)
        before = ticks_until(chunk[rows.TIME + lane])
        ticks = ticks_until(chunk[rows.TIME + lane] + s.period_ms) - before
        until_stale = ticks_until(chunk[rows.TIME + lane] + WATCHDOG_MS) - before
        due[lane] = ticks
        fresh[lane] = select(until_stale < ticks, until_stale, ticks)
    most = int(most_in(fresh, lanes))
    for seat in range(s.hunters):
        move_body(seat_of(chunk, seat), width, s.side_m, most, fresh)
    if s.period_ms > WATCHDOG_MS:
        drop_stale_commands(chunk, s, lanes, due, fresh)
    if s.targets_move:
        most = int(most_in(due, lanes))
        for slot in range(most_alive(chunk, lanes)):
            move_body(body_of(targets, s, slot), width, s.side_m, most, due)
