"""Quantised states: the numbers of A.8 in whole millionths, and their short form in files.

Digests show that two states differ; quantised states show the numbers that differ. A file holds the numbers of moving
bodies as differences from R2.2's motion, which are almost 0, and the numbers of a still target once.
"""

from collections.abc import Sequence
from functools import lru_cache
from io import BytesIO
from typing import Any, Final, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.core.math import sincos
from catch_arena.core.physics import DT, TICK_MS, WATCHDOG_MS
from catch_arena.errors import ReplayError
from catch_arena.replay.codec import pack_columns, read_columns

QuantisedState = NDArray[np.int64]
"""One state: the numbers of `Engine.state()`; lengths, angles and velocities are in whole millionths."""
Matrix = NDArray[np.int64]
"""Table with a column for each number, and a row for each state, body or span."""

ARENA: Final = {
    "time": "ms",
    "step": "",
    "spawned": "",
    "numbers used up": "",
    "firings": "",
    "skipped_full": "",
    "skipped_down": "",
    "refused": "",
}
"""Names and units of the arena's numbers. Units here and below: "" for a count, "target" for a number or 0."""
HUNTER: Final = {
    "x": "m",
    "y": "m",
    "theta": "rad",
    "linear velocity": "m/s",
    "angular velocity": "rad/s",
    "distance integral": "m s",
    "bearing integral": "rad s",
    "active target": "target",
    "score": "",
    "at wall": "flag",
    "withdrawn": "flag",
}
PREY: Final = {"target": "target", "times caught": "", "caught at": "ms"}
"""Names and units of a prey's numbers; it is caught at -1 ms while it is in play."""
_STILL_TARGET: Final = {"number": "", "x": "m", "y": "m", "theta": "rad", "appeared": "ms"}
_MOVING_TARGET: Final = {**_STILL_TARGET, "linear velocity": "m/s", "angular velocity": "rad/s", "at wall": "flag"}
MICRO: Final = frozenset({"m", "rad", "m/s", "rad/s", "m s", "rad s"})
"""Units whose numbers are in whole millionths in a quantised state."""

_THETA, LINEAR_VELOCITY, _TURN_RATE, ACTIVE_TARGET, _SCORE = 2, 3, 4, 7, 8
_PLACE, _VELOCITIES = slice(0, 2), slice(3, 5)
"""Columns of a hunter, and of a moving target's motion."""
_IDENTITY: Final = (0, 4)
"""Columns of a target that never change: its number, and the time at which it appeared."""
_MOTION: Final = (1, 2, 3, 5, 6, 7)
"""Columns of a moving target that change: in the order of a hunter's first five, and then the wall flag."""
USED_UP: Final = 3
"""Column of the arena with the number of target numbers that have been used up."""
_LARGEST: Final = 2**53
_MOST_TICKS: Final = WATCHDOG_MS // TICK_MS  # R2.4: after it the velocities are zero


class StateParts(NamedTuple):
    """Parts of a state."""

    arena: Matrix
    """Numbers of the arena, in one row."""
    hunters: Matrix
    targets: Matrix
    """Numbers of the alive targets, a row each."""
    prey: Matrix


def target_numbers(config: ArenaConfig) -> dict[str, str]:
    """Return the names and units of a target's numbers."""
    return _MOVING_TARGET if config.targets_move else _STILL_TARGET


def tables_of(config: ArenaConfig) -> tuple[dict[str, str], ...]:
    """Return the names and units of the numbers of each part of a state, in the order of `StateParts`."""
    return ARENA, HUNTER, target_numbers(config), PREY


def parts_of(state: NDArray[Any], config: ArenaConfig) -> StateParts:
    """Return the parts of a state, as views of its memory."""
    hunters, targets = len(ARENA), _before_targets(config)
    prey = len(state) - config.prey * len(PREY)
    return StateParts(
        state[:hunters].reshape(1, -1),
        state[hunters:targets].reshape(-1, len(HUNTER)),
        state[targets:prey].reshape(-1, len(target_numbers(config))),
        state[prey:].reshape(-1, len(PREY)),
    )


def quantise(state: NDArray[np.float64], config: ArenaConfig) -> QuantisedState:
    """Return a state of `Engine.state()` in quantised form."""
    return _rounded(_scale(config, len(state)) * state)


@lru_cache
def _scale(config: ArenaConfig, length: int) -> NDArray[np.float64]:
    """Return the factor of each number of a state of this length."""
    factors = np.ones(length)
    for quantities, part in zip(tables_of(config), parts_of(factors, config), strict=True):
        part[:, [unit in MICRO for unit in quantities.values()]] = 1_000_000.0
    return factors


def state_length(config: ArenaConfig) -> int:
    """Return the largest number of numbers in a state."""
    return _before_targets(config) + config.max_targets * len(target_numbers(config)) + config.prey * len(PREY)


def scores(state: QuantisedState, config: ArenaConfig) -> tuple[list[int], list[int]]:
    """Return every hunter's score in a state, and the number of times that each prey was caught."""
    parts = parts_of(state, config)
    return parts.hunters[:, _SCORE].tolist(), parts.prey[:, 1].tolist()


def driven_seats(config: ArenaConfig) -> list[int]:
    """Return the seats under velocity or full control, whose velocity commands have a meaning."""
    return [seat for seat, control in enumerate(config.controls) if control != "target"]


def pack_states(
    config: ArenaConfig,
    commands: NDArray[np.float32],
    prey_commands: NDArray[np.float32],
    states: Sequence[QuantisedState],
) -> tuple[bytes, int]:
    """Return the states of a match (the initial one and one for each step) as bytes, and the number of their spans.

    Args:
        config: the arena's settings.
        commands: (steps, H, 2).
        prey_commands: (steps, P, 2).
        states: the states to be packed.
    """
    arena, hunters, targets, prey = zip(*(parts_of(state, config) for state in states), strict=True)
    clock, by_seat, by_index = np.concatenate(arena), np.array(hunters), np.array(prey)
    packed = [pack_columns(_differences(clock).T)]
    ticks, commanded = _ticks(clock[:, 0]), _hunter_velocities(config, commands)
    for seat in range(config.hunters):
        rest = _without_motion(by_seat[:, seat], ticks)
        rest[:, ACTIVE_TARGET] = by_seat[:, seat, ACTIVE_TARGET]
        if seat in driven_seats(config):
            rest[:, _VELOCITIES] = by_seat[:, seat, _VELOCITIES] - commanded[:, seat]
        packed.append(pack_columns(rest.T))
    packed.append(pack_columns(_differences(by_index.reshape(len(states), -1)).T))
    rows = np.concatenate(targets)
    spans, order = _spans_of(rows, np.repeat(np.arange(len(states)), [len(part) for part in targets]), config)
    packed.append(pack_columns(np.hstack((_differences(spans[:, :1]), spans[:, 1:])).T))
    if config.targets_move:
        tracks = rows[order][:, _MOTION]
        rest = _without_motion(tracks, _ticks_of_targets(ticks, spans))
        rest[:, _VELOCITIES] -= _differences(_target_velocities(config, prey_commands, by_index[:, :, 0], spans))
        packed.append(pack_columns(rest.T))
    return b"".join(packed), len(spans)


def unpack_states(
    config: ArenaConfig,
    commands: NDArray[np.float32],
    prey_commands: NDArray[np.float32],
    body: BytesIO,
    spans: int,
) -> list[QuantisedState]:
    """Return the states that `pack_states` wrote.

    Raises:
        ReplayError: for targets outside the match, or too many of them.
        ValueError: for other bytes.
    """
    size = len(commands) + 1
    fixed = [np.cumsum(read_columns(body, len(ARENA), size), axis=0)]
    ticks, commanded = _ticks(fixed[0][:, 0]), _hunter_velocities(config, commands)
    for seat in range(config.hunters):
        rest = read_columns(body, len(HUNTER), size)
        numbers = np.cumsum(rest, axis=0)
        numbers[:, ACTIVE_TARGET] = rest[:, ACTIVE_TARGET]
        if seat in driven_seats(config):
            numbers[:, _VELOCITIES] = rest[:, _VELOCITIES] + commanded[:, seat]
        fixed.append(_with_motion(numbers, ticks))
    prey = np.cumsum(read_columns(body, config.prey * len(PREY), size), axis=0)
    numbers_of_target = len(target_numbers(config))
    table = read_columns(body, 2 + (len(_IDENTITY) if config.targets_move else numbers_of_target), spans)
    table[:, 0] = np.cumsum(table[:, 0])
    begin, length = table[:, 0], table[:, 1]
    inside = (begin >= 0) & (length > 0) & (length <= size) & (begin <= size - length)
    if not inside.all() or length.sum() > size * config.max_targets:
        raise ReplayError("is damaged: its states have targets that cannot be in the match")
    targets = np.repeat(table[:, 2:], length, axis=0)
    if config.targets_move:
        tracks = np.cumsum(read_columns(body, len(_MOTION), len(targets)), axis=0)
        tracks[:, _VELOCITIES] += _target_velocities(config, prey_commands, prey[:, :: len(PREY)], table)
        moving = np.zeros((len(targets), numbers_of_target), dtype=np.int64)
        moving[:, _IDENTITY] = targets
        moving[:, _MOTION] = _with_motion(tracks, _ticks_of_targets(ticks, table))
        targets = moving
    state_of_row = _ranges(begin, length)
    order = np.lexsort((targets[:, 0], state_of_row))
    alive = np.split(targets[order], np.searchsorted(state_of_row[order], np.arange(1, size)))
    before = np.hstack(fixed)
    return [np.concatenate((row, tail.reshape(-1), last)) for row, tail, last in zip(before, alive, prey, strict=True)]


def _before_targets(config: ArenaConfig) -> int:
    """Return the number of numbers in a state before those of its targets."""
    return len(ARENA) + config.hunters * len(HUNTER)


def _rounded(numbers: NDArray[np.float64]) -> Matrix:
    """Return floor(number + 0.5), at most 2^53 in size."""
    return np.clip(np.floor(numbers + 0.5), -_LARGEST, _LARGEST).astype(np.int64)


def _differences(numbers: Matrix) -> Matrix:
    """Return the difference of each row from the row before; that of the first row from zeros."""
    return np.diff(numbers, axis=0, prepend=0)


# motion


def _ticks(times_ms: NDArray[np.int64]) -> NDArray[np.int64]:
    """R1.2: return the ticks that led to each state, no more than move a hunter; none to the first."""
    return np.clip(np.diff(times_ms // TICK_MS, prepend=times_ms[:1] // TICK_MS), 0, _MOST_TICKS)


def _without_motion(numbers: Matrix, ticks: NDArray[np.int64]) -> Matrix:
    """Return the difference of each row from the row before, minus the motion of R2.2."""
    rest = _differences(numbers)
    rest[:, _THETA] -= _turned(numbers, ticks)
    rest[:, _PLACE] -= _travelled(numbers, ticks)
    return rest


def _with_motion(numbers: Matrix, ticks: NDArray[np.int64]) -> Matrix:
    """Undo `_without_motion` in the same memory: `numbers` are the sums of its rows, velocities as they were."""
    numbers[:, _THETA] += np.cumsum(_turned(numbers, ticks))
    numbers[:, _PLACE] += np.cumsum(_travelled(numbers, ticks), axis=0)
    return numbers


def _turned(numbers: Matrix, ticks: NDArray[np.int64]) -> NDArray[np.int64]:
    """R2.2: return the angle by which a body's turn rate has turned it before each state."""
    return (TICK_MS * numbers[:, _TURN_RATE] * ticks + 500) // 1000


def _travelled(numbers: Matrix, ticks: NDArray[np.int64]) -> Matrix:
    """R2.2: return a body's displacement by its velocities before each state: (states, 2). The sine and cosine are the
    core's, so that all machines agree.
    """
    displacement = np.zeros((len(ticks), 2))
    angle = np.concatenate(([0], numbers[:-1, _THETA]))[: len(ticks)] / 1000000.0
    turn, stride = numbers[:, _TURN_RATE] / 1000000.0 * DT, numbers[:, LINEAR_VELOCITY] * DT
    for tick in range(ticks.max(initial=0)):
        angle = angle + turn
        sine, cosine = cast("Any", sincos)(angle)  # a rule takes arrays, too
        way = np.column_stack((cosine * stride, sine * stride))
        displacement += np.where(ticks[:, None] > tick, way, 0.0)
    return _rounded(displacement)


# velocities that commands ask for


def _commanded_velocities(commands: NDArray[np.float32], high: NDArray[np.float64], *, reverse: bool) -> Matrix:
    """R2.5: return the velocities that commands ask for, (steps, n, 2), with a row of zeros before the first."""
    low = -high if reverse else high * [0.0, -1.0]
    commanded = _rounded(1e6 * np.clip(commands.astype(np.float64) * high, low, high))
    return np.concatenate((np.zeros((1, *commanded.shape[1:]), dtype=np.int64), commanded))


def _hunter_velocities(config: ArenaConfig, commands: NDArray[np.float32]) -> Matrix:
    """Return the velocities that every seat's commands ask for: (steps + 1, H, 2)."""
    return _commanded_velocities(
        commands, np.array([config.max_speeds, config.max_turn_rates]).T, reverse=config.reverse
    )


def _target_velocities(config: ArenaConfig, prey_commands: NDArray[np.float32], plays: Matrix, spans: Matrix) -> Matrix:
    """R12.2: return the velocities that prey's commands ask for, state after state and span after span: (states, 2).

    They are 0 for targets without prey, and for the first state of a target, which stands still then (R3.8).

    Args:
        config: the arena's settings.
        prey_commands: (steps, P, 2).
        plays: the number of each prey's target in each state, 0 for none: (steps + 1, P).
        spans: when each target is alive, and its number.
    """
    limits = np.array([config.target_speed_mps, config.target_turn_rate_radps])
    commanded = _commanded_velocities(prey_commands, limits, reverse=config.reverse)
    state_of_row, numbers = _ranges(spans[:, 0], spans[:, 1]), np.repeat(spans[:, 2], spans[:, 1])
    found = np.zeros((len(state_of_row), 2), dtype=np.int64)
    for index in range(config.prey):
        led = plays[state_of_row, index] == numbers
        led[_beginnings(spans)] = False
        found[led] = commanded[state_of_row[led], index]
    return found


# spans in which targets are alive


def _ranges(begin: NDArray[np.int64], length: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the numbers of all ranges, one range after the other."""
    return np.arange(length.sum()) + np.repeat(begin - np.cumsum(length) + length, length)


def _beginnings(spans: Matrix) -> NDArray[np.int64]:
    """Return the index of each span's first state among the states of all spans."""
    return np.cumsum(spans[:, 1]) - spans[:, 1]


def _ticks_of_targets(ticks: NDArray[np.int64], spans: Matrix) -> NDArray[np.int64]:
    """R3.8: return the ticks that led to each state of the spans; none to the first of each."""
    found = ticks[_ranges(spans[:, 0], spans[:, 1])]
    found[_beginnings(spans)] = 0
    return found


def _spans_of(rows: Matrix, state_of_row: NDArray[np.int64], config: ArenaConfig) -> tuple[Matrix, NDArray[np.int64]]:
    """Return the spans of states in which a target's identity is constant (all its numbers, if targets stand still).

    A span is (first state, number of states, constant numbers). The order of the rows by spans is returned, too.
    """
    stays = rows[:, _IDENTITY] if config.targets_move else rows
    order = np.lexsort((state_of_row, *stays.T[::-1]))
    state_of_row, stays = state_of_row[order], stays[order]
    fresh = np.concatenate(([True], (np.diff(state_of_row) != 1) | np.any(np.diff(stays, axis=0) != 0, axis=1)))[
        : len(state_of_row)
    ]
    first = np.flatnonzero(fresh)
    length = np.diff(first, append=len(state_of_row))
    spans = np.column_stack((state_of_row[first], length, stays[first]))
    by_beginning = np.lexsort(spans.T[::-1])
    return spans[by_beginning], order[_ranges(first[by_beginning], length[by_beginning])]
