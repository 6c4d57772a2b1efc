"""Rulebook chapter 2: how turtles move. Blocks of LANES arenas; metres, radians, seconds."""

from typing import Final

from catch_arena.core.jit import Block, entry, phase, rule
from catch_arena.core.math import clamp, floor, sincos, wrap
from catch_arena.core.state import AT_WALL, LANES, SPEED, THETA, TIME, TURN_RATE, Settings, X, Y, seat_of

DT: Final = 0.016
"""R1.2: what one tick integrates [s]."""
TICK_MS: Final = 16.0
WATCHDOG_MS: Final = 1000.0
"""R2.4: a velocity command older than this is dropped."""


@entry
def next_pose(
    x: float, y: float, theta: float, speed: float, turn_rate: float, side: float
) -> tuple[float, float, float]:
    """R2.2, R2.3: the pose after one tick; the heading turns before the position moves."""
    theta = wrap(theta + turn_rate * DT)
    sine, cosine = sincos(theta)
    return clamp(x + cosine * speed * DT, 0.0, side), clamp(y + sine * speed * DT, 0.0, side), theta


@rule
def ticks_until(time_ms: float) -> float:
    """R1.2, R1.3: how many ticks fall in (0, time]."""
    return floor(time_ms / TICK_MS)


@phase
def move_seat(me: Block, lanes: int, tick: int, ticks: Block, side: float) -> None:
    """R2.2, R2.3: one tick of one seat, in the lanes that have so many ticks in this step."""
    for lane in range(lanes):
        theta = wrap(me[THETA + lane] + me[TURN_RATE + lane] * DT)
        sine, cosine = sincos(theta)
        free_x = me[X + lane] + cosine * me[SPEED + lane] * DT
        free_y = me[Y + lane] + sine * me[SPEED + lane] * DT
        x = clamp(free_x, 0.0, side)
        y = clamp(free_y, 0.0, side)
        moves = tick < ticks[lane]
        me[AT_WALL + lane] = 1.0 if moves & ((x != free_x) | (y != free_y)) else me[AT_WALL + lane]
        me[THETA + lane] = theta if moves else me[THETA + lane]
        me[X + lane] = x if moves else me[X + lane]
        me[Y + lane] = y if moves else me[Y + lane]


@phase
def drop_stale_commands(me: Block, lanes: int, tick: int, fresh: Block, ticks: Block) -> None:
    """R2.4: the watchdog stops a seat at the first tick more than a second after its command."""
    for lane in range(lanes):
        stale = (tick >= fresh[lane]) & (tick < ticks[lane])
        me[SPEED + lane] = 0.0 if stale else me[SPEED + lane]
        me[TURN_RATE + lane] = 0.0 if stale else me[TURN_RATE + lane]


@phase
def move(block: Block, s: Settings, lanes: int, counts: Block) -> None:
    """R1.3: all ticks in (t, t + period], one after the other; `counts` is scratch of two rows."""
    ticks = counts[:LANES]
    fresh = counts[LANES : 2 * LANES]
    most = 0.0
    soonest_stale = 1e18
    for lane in range(lanes):
        before = ticks_until(block[TIME + lane])
        ticks[lane] = ticks_until(block[TIME + lane] + s.period) - before
        fresh[lane] = ticks_until(block[TIME + lane] + WATCHDOG_MS) - before
        most = max(most, ticks[lane])
        soonest_stale = min(soonest_stale, fresh[lane])
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        for lane in range(lanes):
            me[AT_WALL + lane] = 0.0
        for tick in range(int(most)):
            if tick >= soonest_stale:
                drop_stale_commands(me, lanes, tick, fresh, ticks)
            move_seat(me, lanes, tick, ticks, s.side)
