"""Rulebook chapter 2: motion of turtles. Chunks of LANES arenas; metres, radians, seconds."""

from typing import Final

from catch_arena.core.jit import Rows, outlined, phase, rule
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
    body_of,
    most_alive,
    played_lanes,
    seat_of,
)
from catch_arena.core.vectors import Width, any_of, floor, group, select

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

    Args:
        stride: distance moved in a tick [m].
        turn_sine: sine of the angle turned in a tick.
        turn_cosine: cosine of the angle turned in a tick.
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
def move_body(me: Rows, width: Width, side: float, fewest: int, most: int, ticks: Rows) -> None:
    """R2.2, R2.3: move one body by all ticks of a step.

    Args:
        me: the rows of the body; its pose and AT_WALL are written.
        fewest: least number of ticks in any lane.
        most: greatest number of ticks in any lane: `fewest`, or one more.
        ticks: number of ticks of each lane, one row.
    """
    for first in range(0, played_lanes(width), len(width)):
        lane = group(first, width)
        x, y, sine, cosine = me[X + lane], me[Y + lane], me[SINE + lane], me[COSINE + lane]
        stride = me[SPEED + lane] * DT
        turn = me[TURN_RATE + lane] * DT
        turn_sine, turn_cosine = sincos(turn)
        at_wall = False
        for _ in range(fewest):
            x, y, sine, cosine, held = next_pose(x, y, sine, cosine, stride, turn_sine, turn_cosine, side)
            at_wall = at_wall | held
        if fewest < most:  # steps have one length, so that the numbers of ticks differ by one at most
            moves = ticks[lane] > fewest
            next_x, next_y, _, _, held = next_pose(x, y, sine, cosine, stride, turn_sine, turn_cosine, side)
            x = select(moves, next_x, x)
            y = select(moves, next_y, y)
            at_wall = at_wall | (moves & held)
        me[X + lane] = x
        me[Y + lane] = y
        me[THETA + lane] = turned(me[THETA + lane], turn, ticks[lane])
        me[AT_WALL + lane] = select(at_wall, 1.0, 0.0)


@outlined
def drop_stale_commands(chunk: Rows, s: Settings, width: Width, stale: Rows) -> None:
    """R2.4: stop the hunters whose commands the watchdog dropped in this step.

    Args:
        stale: one row: 1 if the watchdog has fired, else 0.
    """
    for seat in range(s.hunters):
        me = seat_of(chunk, seat)
        for first in range(0, played_lanes(width), len(width)):
            lane = group(first, width)
            me[SPEED + lane] = select(stale[lane] > 0.0, 0.0, me[SPEED + lane])
            me[TURN_RATE + lane] = select(stale[lane] > 0.0, 0.0, me[TURN_RATE + lane])


@phase
def fewest_and_most(ticks: Rows, lanes: int) -> tuple[int, int]:
    """Return the least and the greatest number of ticks of a lane."""
    fewest, most = 1e18, 0.0
    for lane in range(lanes):
        fewest = min(fewest, ticks[lane])
        most = max(most, ticks[lane])
    return int(fewest), int(most)


@phase
def move(chunk: Rows, s: Settings, width: Width, lanes: int, targets: Rows, counts: Rows) -> None:
    """R1.3: play all ticks in (t, t + period], one after the other.

    R2.4's watchdog stops a hunter at the first tick more than a second after its command: later ticks do not move it.
    Targets have no watchdog (R3.8).

    Args:
        counts: room for three rows: the number of ticks of each lane, the number before its commands are stale, and
            whether they become stale in this step.
    """
    due, fresh, stale = counts[:LANES], counts[LANES : 2 * LANES], counts[2 * LANES : 3 * LANES]
    any_stale = False
    for first in range(0, played_lanes(width), len(width)):
        lane = group(first, width)
        before = ticks_until(chunk[TIME + lane])
        ticks = ticks_until(chunk[TIME + lane] + s.period_ms) - before
        until_stale = ticks_until(chunk[TIME + lane] + WATCHDOG_MS) - before
        due[lane] = ticks
        fresh[lane] = select(until_stale < ticks, until_stale, ticks)
        stale[lane] = select(until_stale < ticks, 1.0, 0.0)
        any_stale = any_stale | any_of(until_stale < ticks)
    fewest, most = fewest_and_most(fresh, lanes)
    for seat in range(s.hunters):
        move_body(seat_of(chunk, seat), width, s.side_m, fewest, most, fresh)
    if any_stale:
        drop_stale_commands(chunk, s, width, stale)
    if s.targets_move:
        fewest, most = fewest_and_most(due, lanes)
        for slot in range(most_alive(chunk, lanes)):
            move_body(body_of(targets, s, slot), width, s.side_m, fewest, most, due)
