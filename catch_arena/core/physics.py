"""Rulebook chapter 2: how turtles move. Blocks of LANES arenas; metres, radians, seconds."""

from typing import Final

from catch_arena.core.jit import Block, passage, phase, rule
from catch_arena.core.math import clamp, floor, sincos, wrap
from catch_arena.core.state import AT_WALL, LANES, SPEED, THETA, TIME, TURN_RATE, Settings, X, Y, seat_of

DT: Final = 0.016
"""R1.2: what one tick integrates [s]."""
TICK_MS: Final = 16.0
WATCHDOG_MS: Final = 1000.0
"""R2.4: a velocity command older than this is dropped."""


@rule
def next_pose(
    x: float, y: float, theta: float, speed: float, turn_rate: float, side: float
) -> tuple[float, float, float, bool]:
    """R2.2, R2.3: the pose after one tick, and whether a wall held it; the heading turns before the position moves."""
    theta = wrap(theta + turn_rate * DT)
    sine, cosine = sincos(theta)
    free_x = x + cosine * speed * DT
    free_y = y + sine * speed * DT
    x = clamp(free_x, 0.0, side)
    y = clamp(free_y, 0.0, side)
    return x, y, theta, (x != free_x) | (y != free_y)


@rule
def ticks_until(time_ms: float) -> float:
    """R1.2, R1.3: how many ticks fall in (0, time]."""
    return floor(time_ms / TICK_MS)


@phase
def move_seat(me: Block, lanes: int, side: float) -> None:
    """R2.2, R2.3: one tick of one seat, in every lane."""
    for lane in range(lanes):
        x, y, theta, held = next_pose(
            me[X + lane], me[Y + lane], me[THETA + lane], me[SPEED + lane], me[TURN_RATE + lane], side
        )
        me[X + lane] = x
        me[Y + lane] = y
        me[THETA + lane] = theta
        me[AT_WALL + lane] = 1.0 if held else me[AT_WALL + lane]


@phase
def keep_place(me: Block, lanes: int, kept: Block) -> None:
    """Where a seat is before a tick that not every lane has; `kept` has four rows."""
    for lane in range(lanes):
        kept[lane] = me[X + lane]
        kept[LANES + lane] = me[Y + lane]
        kept[2 * LANES + lane] = me[THETA + lane]
        kept[3 * LANES + lane] = me[AT_WALL + lane]


@phase
def put_back(me: Block, lanes: int, tick: int, ticks: Block, kept: Block) -> None:
    """R1.3: lanes that do not have this tick in this step are where they were."""
    for lane in range(lanes):
        moves = tick < ticks[lane]
        me[X + lane] = me[X + lane] if moves else kept[lane]
        me[Y + lane] = me[Y + lane] if moves else kept[LANES + lane]
        me[THETA + lane] = me[THETA + lane] if moves else kept[2 * LANES + lane]
        me[AT_WALL + lane] = me[AT_WALL + lane] if moves else kept[3 * LANES + lane]


@phase
def drop_stale_commands(me: Block, lanes: int, tick: int, fresh: Block, ticks: Block) -> None:
    """R2.4: the watchdog stops a seat at the first tick more than a second after its command."""
    for lane in range(lanes):
        stale = (tick >= fresh[lane]) & (tick < ticks[lane])
        me[SPEED + lane] = 0.0 if stale else me[SPEED + lane]
        me[TURN_RATE + lane] = 0.0 if stale else me[TURN_RATE + lane]


@passage
def move(block: Block, s: Settings, lanes: int, scratch: Block) -> None:
    """R1.3: all ticks in (t, t + period], one after the other; `scratch` has six rows."""
    ticks = scratch[:LANES]
    fresh = scratch[LANES : 2 * LANES]
    kept = scratch[2 * LANES : 6 * LANES]
    most = 0.0
    fewest = 1e18
    soonest_stale = 1e18
    for lane in range(lanes):
        before = ticks_until(block[TIME + lane])
        ticks[lane] = ticks_until(block[TIME + lane] + s.period) - before
        fresh[lane] = ticks_until(block[TIME + lane] + WATCHDOG_MS) - before
        most = max(most, ticks[lane])
        fewest = min(fewest, ticks[lane])
        soonest_stale = min(soonest_stale, fresh[lane])
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        for lane in range(lanes):
            me[AT_WALL + lane] = 0.0
        for tick in range(int(most)):
            if tick >= soonest_stale:
                drop_stale_commands(me, lanes, tick, fresh, ticks)
            if tick >= fewest:
                keep_place(me, lanes, kept)
            move_seat(me, lanes, s.side)
            if tick >= fewest:
                put_back(me, lanes, tick, ticks, kept)
