"""Placement of bodies at given poses, for tests, lessons, and positions to learn from."""

import numpy as np
from numpy.typing import NDArray

from catch_arena.core import rows
from catch_arena.core.jit import Rows, entry, phase
from catch_arena.core.math import wrap
from catch_arena.core.memory import Bytes, sections_of, settings_in
from catch_arena.core.spawner import add_target, is_played, remove_target
from catch_arena.core.state import ALL_OPTIONS, Settings, body_of, prey_of, seat_of, targets_of
from catch_arena.core.vectors import LANES

Table = NDArray[np.float64]


@phase
def put_body(body: Rows, lane: int, pose: Table) -> None:
    """Put a body at rest at a pose: x, y [m] and heading [rad]."""
    body[rows.X + lane] = pose[0]
    body[rows.Y + lane] = pose[1]
    body[rows.THETA + lane] = wrap(pose[2])
    for offset in (rows.SPEED, rows.TURN_RATE, rows.AT_WALL):
        body[offset + lane] = 0.0


@phase
def put_target(chunk: Rows, s: Settings, lane: int, targets: Rows, target: Table) -> None:
    """Add a target with the next number: x, y [m], heading [rad], linear velocity [m/s], age [ms]."""
    add_target(chunk, s, lane, targets, target[0], target[1], target[2], chunk[rows.TIME + lane] - target[4])
    if s.targets_move:
        body_of(targets, s, int(chunk[rows.ALIVE + lane]) - 1)[rows.SPEED + lane] = target[3]


@entry
def place(memory: Bytes, arena: int, hunters: Table, prey: Table, targets: Table) -> None:
    """Put bodies at rest at these poses. Targets replace those that no prey plays, as far as there is room.

    Args:
        hunters: (n, 3), poses of the first hunters.
        prey: (P, 3), poses of all prey, used for prey in play; or (0, 3), and prey stays as it is.
    """
    sections = sections_of(memory, 0)
    s = settings_in(sections.settings, ALL_OPTIONS)
    chunk, lane = sections.chunks[arena // LANES], arena % LANES
    for seat in range(len(hunters)):
        me = seat_of(chunk, seat)
        put_body(me, lane, hunters[seat])
        for offset in rows.AT_REST:
            me[offset + lane] = 0.0
    every = targets_of(chunk, s)
    for slot in range(int(chunk[rows.ALIVE + lane]) - 1, -1, -1):  # backwards: targets after a removed slot move up
        if not is_played(chunk, s, lane, slot):
            remove_target(chunk, s, lane, every, slot)
    for index in range(len(prey)):
        slot = int(prey_of(chunk, s, index)[rows.PREY_SLOT + lane])
        if slot != rows.NO_TARGET:
            put_body(body_of(every, s, slot), lane, prey[index])
    for i in range(len(targets)):
        if chunk[rows.ALIVE + lane] < s.max_targets:
            put_target(chunk, s, lane, every, targets[i])


@entry
def place_all(
    memory: Bytes, arenas: NDArray[np.int64], hunters: Table, targets: Table, steps: NDArray[np.int64]
) -> None:
    """Begin episodes with these bodies; the seeds stay. Do not call it for arenas with prey.

    Args:
        arenas: (n,), numbers of the arenas.
        hunters: (n, H, 4): x, y, heading, linear velocity; NaN for a withdrawn hunter.
        targets: (n, T, 5): see `put_target`; the oldest first, then rows of NaN.
        steps: (n,), number of steps already played.
    """
    sections = sections_of(memory, 0)
    s = settings_in(sections.settings, ALL_OPTIONS)
    for i in range(len(arenas)):
        chunk, lane = sections.chunks[arenas[i] // LANES], arenas[i] % LANES
        high, low = chunk[rows.SEED_HIGH + lane], chunk[rows.SEED_LOW + lane]
        for row in range(len(chunk) // LANES):
            chunk[row * LANES + lane] = 0.0
        chunk[rows.SEED_HIGH + lane], chunk[rows.SEED_LOW + lane] = high, low
        chunk[rows.STEP + lane] = steps[i]
        chunk[rows.TIME + lane] = steps[i] * s.period_ms
        chunk[rows.FIRINGS + lane] = np.floor(chunk[rows.TIME + lane] / s.spawn_period_ms)
        for seat in range(s.hunters):
            me = seat_of(chunk, seat)
            if np.isnan(hunters[i, seat, 0]):
                me[rows.WITHDRAWN + lane] = 1.0
            else:
                put_body(me, lane, hunters[i, seat])
                me[rows.SPEED + lane] = hunters[i, seat, 3]
        every = targets_of(chunk, s)
        for slot in range(targets.shape[1]):
            if not np.isnan(targets[i, slot, 0]):
                put_target(chunk, s, lane, every, targets[i, slot])
