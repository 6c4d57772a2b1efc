"""Rulebook chapter 3: times and places at which targets appear. One lane at a time: spawns are rare."""

import numpy as np

from catch_arena.core import rows
from catch_arena.core.jit import Rows, entry, outlined, phase, rule
from catch_arena.core.math import TAU, wrap
from catch_arena.core.memory import Bytes, sections_of, settings_in
from catch_arena.core.random import PLACE, draw, fraction, seed_of, spawn_refused, spawn_service_down, stream
from catch_arena.core.state import ALL_OPTIONS, Settings, prey_of, targets_of
from catch_arena.core.vectors import LANES


@rule
def spawn_pose(seed: np.uint64, number: float, low: float, high: float, last: float) -> tuple[float, float, float]:
    """R3.2, R3.3: return the pose at which the target of a number appears: x, y [m], theta [rad] in [0, 2 pi).
    Coordinates lie in [low, high) [m]; `last` is the greatest number below `high`.
    """
    key = stream(seed, PLACE)
    first = np.uint64(3) * (np.uint64(number) - np.uint64(1))
    x = low + fraction(draw(key, first)) * (high - low)
    y = low + fraction(draw(key, first + np.uint64(1))) * (high - low)
    theta = TAU * fraction(draw(key, first + np.uint64(2)))
    return last if x > last else x, last if y > last else y, theta


@phase
def add_target(
    chunk: Rows, s: Settings, lane: int, targets: Rows, x: float, y: float, theta: float, time_ms: float
) -> None:
    """R3.3, R3.4, R3.8, R8.2: add a target with the next number at the end of the alive list, at rest."""
    chunk[rows.LAST_NUMBER + lane] += 1.0
    slot = int(chunk[rows.ALIVE + lane]) * s.slot_size + lane
    targets[slot + rows.NUMBER] = chunk[rows.LAST_NUMBER + lane]
    targets[slot + rows.APPEARED] = time_ms
    targets[slot + rows.BODY + rows.X] = x
    targets[slot + rows.BODY + rows.Y] = y
    targets[slot + rows.BODY + rows.THETA] = wrap(theta) if s.targets_move else theta
    chunk[rows.ALIVE + lane] += 1.0
    chunk[rows.SPAWNED + lane] += 1.0


@phase
def is_played(chunk: Rows, s: Settings, lane: int, slot: int) -> bool:
    """Return whether prey plays the target in a slot."""
    played = False
    for index in range(s.prey):
        played = played or prey_of(chunk, s, index)[rows.PREY_SLOT + lane] == slot
    return bool(played)


@outlined
def remove_target(chunk: Rows, s: Settings, lane: int, targets: Rows, slot: int) -> None:
    """R8.2: remove one target from the alive list; later ones move up, so that the order stays."""
    for index in range(s.prey):
        me = prey_of(chunk, s, index)
        if me[rows.PREY_SLOT + lane] > slot:
            me[rows.PREY_SLOT + lane] -= 1.0
    last = int(chunk[rows.ALIVE + lane]) - 1
    for at in range(slot * s.slot_size + lane, last * s.slot_size, LANES):
        targets[at] = targets[at + s.slot_size]
    for at in range(last * s.slot_size + lane, (last + 1) * s.slot_size, LANES):
        targets[at] = 0.0
    chunk[rows.ALIVE + lane] = last


@phase
def spawn_next(chunk: Rows, s: Settings, lane: int, targets: Rows, seed: np.uint64, time_ms: float) -> None:
    """R3.3: add a target with the next number, at that number's pose."""
    number = chunk[rows.LAST_NUMBER + lane] + 1.0
    x, y, theta = spawn_pose(seed, number, s.spawn_low_m, s.spawn_high_m, s.spawn_last_m)
    add_target(chunk, s, lane, targets, x, y, theta, time_ms)


@phase
def fire(chunk: Rows, s: Settings, lane: int, targets: Rows, seed: np.uint64) -> None:
    """R3.1, R3.5, R3.6, R8.3: play one firing of the spawn timer."""
    chunk[rows.FIRINGS + lane] += 1.0
    if chunk[rows.SPAWNED + lane] >= s.target_budget:
        return
    if chunk[rows.ALIVE + lane] >= s.max_targets:
        chunk[rows.SKIPPED_FULL + lane] += 1.0
    elif spawn_service_down(seed, chunk[rows.FIRINGS + lane], s.spawn_down_rate):
        chunk[rows.SKIPPED_DOWN + lane] += 1.0
    elif spawn_refused(seed, chunk[rows.LAST_NUMBER + lane] + 1.0, s.spawn_refused_rate):
        chunk[rows.LAST_NUMBER + lane] += 1.0
        chunk[rows.SPAWNS_REFUSED + lane] += 1.0
    else:
        spawn_next(chunk, s, lane, targets, seed, chunk[rows.FIRINGS + lane] * s.spawn_period_ms)


@phase
def spawn_through(chunk: Rows, s: Settings, lanes: int, targets: Rows) -> None:
    """R1.4's phase 5, its spawning half: play all firings in (t, t + period].

    Targets and hunters do not touch each other, and a target that appears stands still until the next step (R3.8).
    Therefore these firings may follow the step's ticks.
    """
    for lane in range(lanes):
        while (chunk[rows.FIRINGS + lane] + 1.0) * s.spawn_period_ms <= chunk[rows.TIME + lane] + s.period_ms:
            fire(chunk, s, lane, targets, seed_of(chunk, lane))


@entry
def spawn_at(memory: Bytes, arena: int, x: float, y: float, theta: float) -> int:
    """R8.1: add a target outside the timer, and return its number; 0 if the arena is full (R3.5)."""
    sections = sections_of(memory, 0)
    s = settings_in(sections.settings, ALL_OPTIONS)
    chunk, lane = sections.chunks[arena // LANES], arena % LANES
    if chunk[rows.ALIVE + lane] >= s.max_targets:
        return 0
    add_target(chunk, s, lane, targets_of(chunk, s), x, y, theta, chunk[rows.TIME + lane])
    return int(chunk[rows.LAST_NUMBER + lane])


@entry
def kill(memory: Bytes, arena: int, number: int) -> bool:
    """R8.1, R5.8: remove an alive target uncaught, which then no longer counts as spawned. Return False if it is not
    alive, or if prey plays it.
    """
    sections = sections_of(memory, 0)
    s = settings_in(sections.settings, ALL_OPTIONS)
    chunk, lane = sections.chunks[arena // LANES], arena % LANES
    targets = targets_of(chunk, s)
    for slot in range(int(chunk[rows.ALIVE + lane])):
        if targets[slot * s.slot_size + rows.NUMBER + lane] == number:
            if is_played(chunk, s, lane, slot):
                return False
            remove_target(chunk, s, lane, targets, slot)
            chunk[rows.SPAWNED + lane] -= 1.0
            return True
    return False
