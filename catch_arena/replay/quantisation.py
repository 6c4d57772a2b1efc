"""Quantised states: the numbers of A.8 in whole millionths, and their short form in files.

A digest tells that two states differ; the quantised states tell in what. In a file the numbers of what moves stand as
what is left after R2.2's motion has been taken off, which is almost nothing, and those of a target that stands still
stand once.
"""

from bisect import bisect_left
from collections.abc import Sequence
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.core.jit import entry
from catch_arena.core.math import sincos
from catch_arena.core.physics import DT, TICK_MS, WATCHDOG_MS
from catch_arena.errors import ReplayError
from catch_arena.replay.codec import Reader, pack_columns

QuantisedState = NDArray[np.int64]
"""One state: the numbers of `Engine.state()`, those that have a unit other than ms in whole millionths of it: of the
arena, the hunters, the alive targets, and prey.
"""
Matrix = NDArray[np.int64]
"""A column for each number, a row for each state."""

ARENA: Final = ("time", "step", "spawned", "numbers used up", "firings", "skipped_full", "skipped_down", "refused")
HUNTER: Final = {
    "x": "m",
    "y": "m",
    "theta": "rad",
    "linear velocity": "m/s",
    "angular velocity": "rad/s",
    "distance integral": "m s",
    "bearing integral": "rad s",
    "active target": "",
    "score": "",
    "at wall": "",
    "withdrawn": "",
}
"""A hunter's numbers and their units; "" is a count."""
PREY: Final = ("target", "times caught", "caught at")
"""A prey's numbers, which are counts: its target is 0 while it is out, and it was caught at -1 while it is not."""
_STILL_TARGET: Final = {"number": "", "x": "m", "y": "m", "theta": "rad", "appeared": ""}
_MOVING_TARGET: Final = {**_STILL_TARGET, "linear velocity": "m/s", "angular velocity": "rad/s", "at wall": ""}
X, Y, THETA, SPEED, TURN_RATE, ACTIVE, SCORE = 0, 1, 2, 3, 4, 7, 8
"""Of a hunter; a target's motion is packed in the order of the first five, with its wall flag behind them."""
_USED_UP: Final = ARENA.index("numbers used up")
_NUMBER: Final = 0
_PLAYS, _TIMES_CAUGHT = 0, 1
"""Of prey: the number of its target, and its score."""
_IDENTITY: Final = (_NUMBER, 4)
"""A target's number, and when it appeared."""
_MOTION: Final = (1, 2, 3, 5, 6, 7)
"""A moving target's numbers that change."""

_LARGEST: Final = 2**53
_MOST_TICKS: Final = WATCHDOG_MS // TICK_MS  # R2.4: after it the velocities are zero


def target_numbers(config: ArenaConfig) -> dict[str, str]:
    """A target's numbers and their units, as `HUNTER` has a hunter's."""
    return _MOVING_TARGET if config.targets_move else _STILL_TARGET


@cache
def _scale(hunters: int, targets: int, prey: int, *, moving: bool) -> NDArray[np.float64]:
    """What each number of a state is multiplied by."""
    target = _MOVING_TARGET if moving else _STILL_TARGET
    units = [
        *[""] * len(ARENA),
        *[*HUNTER.values()] * hunters,
        *[*target.values()] * targets,
        *[""] * len(PREY) * prey,
    ]
    return np.array([1e6 if unit else 1.0 for unit in units])


def rounded(numbers: NDArray[np.float64], scale: float | NDArray[np.float64]) -> NDArray[np.int64]:
    """floor(scale * number + 0.5), at most 2^53 in size."""
    return np.clip(np.floor(scale * numbers + 0.5), -_LARGEST, _LARGEST).astype(np.int64)


def quantise(state: NDArray[np.float64], config: ArenaConfig) -> QuantisedState:
    """A state as `Engine.state()` gives it, in whole millionths."""
    targets = (len(state) - _before_targets(config) - _behind_targets(config)) // len(target_numbers(config))
    return rounded(state, _scale(config.hunters, targets, config.prey, moving=config.targets_move))


def parts_of(state: QuantisedState, config: ArenaConfig) -> tuple[Matrix, Matrix, Matrix, Matrix]:
    """A state taken apart: the arena's numbers, in one row, and a row for each hunter, alive target and prey."""
    hunters, targets = len(ARENA), _before_targets(config)
    prey = len(state) - _behind_targets(config)
    return (
        state[:hunters].reshape(1, -1),
        state[hunters:targets].reshape(-1, len(HUNTER)),
        state[targets:prey].reshape(-1, len(target_numbers(config))),
        state[prey:].reshape(-1, len(PREY)),
    )


def _before_targets(config: ArenaConfig) -> int:
    """How many numbers a state has before its targets'."""
    return len(ARENA) + config.hunters * len(HUNTER)


def _behind_targets(config: ArenaConfig) -> int:
    """How many numbers a state has after its targets'."""
    return config.prey * len(PREY)


def scores(state: QuantisedState, config: ArenaConfig) -> tuple[list[int], list[int]]:
    """Every hunter's score in that state, and every prey's."""
    _, hunters, _, prey = parts_of(state, config)
    return hunters[:, SCORE].tolist(), prey[:, _TIMES_CAUGHT].tolist()


def first_state_with(number: int, states: Sequence[QuantisedState], config: ArenaConfig) -> int | None:
    """In which state a target appeared; None where it never did, as where its number's spawn was refused."""
    first = bisect_left(states, number, key=lambda state: int(state[_USED_UP]))
    if first == len(states):
        return None
    _, _, targets, _ = parts_of(states[first], config)
    return first if number in targets[:, _NUMBER] else None


def state_length(config: ArenaConfig) -> int:
    """How many numbers a quantised state has at most."""
    return _before_targets(config) + config.max_targets * len(target_numbers(config)) + _behind_targets(config)


def driven_seats(config: ArenaConfig) -> list[int]:
    """The seats whose velocity commands mean something."""
    return [seat for seat, control in enumerate(config.controls) if control != "target"]


def pack_states(
    config: ArenaConfig,
    commands: NDArray[np.float32],
    prey_commands: NDArray[np.float32],
    states: Sequence[QuantisedState],
) -> tuple[bytes, int]:
    """The states of a match, the initial one and that of each step, as bytes; and how many spans are in them.

    Args:
        config: the arena's settings.
        commands: (steps, H, 2).
        prey_commands: (steps, P, 2).
        states: the states to be packed.
    """
    arena, hunters, targets, prey = zip(*(parts_of(state, config) for state in states), strict=True)
    clock = np.concatenate(arena)
    parts = [pack_columns(np.diff(clock, axis=0, prepend=0).T)]
    ticks = _ticks(clock[:, 0])
    by_seat = np.array(hunters)
    for seat, given in enumerate(_commanded(config, commands)):
        numbers = by_seat[:, seat]
        rest = _without_motion(numbers, ticks)
        rest[:, ACTIVE] = numbers[:, ACTIVE]
        if given is not None:
            rest[:, SPEED : TURN_RATE + 1] = numbers[:, SPEED : TURN_RATE + 1] - given
        parts.append(pack_columns(rest.T))
    by_index = np.array(prey)
    parts.append(pack_columns(np.diff(by_index, axis=0, prepend=0).reshape(len(states), -1).T))
    spans, tracks = _lives(targets) if config.targets_move else (_spans(targets), None)
    beginnings = np.diff(spans[:, :1], axis=0, prepend=0)
    parts.append(pack_columns(np.hstack((beginnings, spans[:, 1:])).T))
    if tracks is not None:
        rest = _without_motion(tracks, _ticks_of_targets(ticks, spans))
        given = _commanded_targets(config, prey_commands, by_index[:, :, _PLAYS], spans)
        rest[:, SPEED : TURN_RATE + 1] -= np.diff(given, axis=0, prepend=0)
        parts.append(pack_columns(rest.T))
    return b"".join(parts), len(spans)


def unpack_states(
    config: ArenaConfig,
    commands: NDArray[np.float32],
    prey_commands: NDArray[np.float32],
    reader: Reader,
    spans: int,
) -> list[QuantisedState]:
    """The states that `pack_states` wrote.

    Raises:
        ReplayError: where it is no replay, or a damaged one.
    """
    size, hunter = len(commands) + 1, len(HUNTER)
    fixed = np.zeros((size, _before_targets(config)), dtype=np.int64)
    fixed[:, : len(ARENA)] = _bounded(np.cumsum(reader.columns(len(ARENA), size), axis=0))
    ticks = _ticks(fixed[:, 0])
    for seat, given in enumerate(_commanded(config, commands)):
        rest = reader.columns(hunter, size)
        numbers = np.cumsum(rest, axis=0)
        numbers[:, ACTIVE] = rest[:, ACTIVE]
        if given is not None:
            numbers[:, SPEED : TURN_RATE + 1] = rest[:, SPEED : TURN_RATE + 1] + given
        fixed[:, len(ARENA) + seat * hunter :][:, :hunter] = _with_motion(numbers, ticks)
    prey = _bounded(np.cumsum(reader.columns(config.prey * len(PREY), size), axis=0))
    numbers_of_target = len(target_numbers(config))
    table = reader.columns(2 + (len(_IDENTITY) if config.targets_move else numbers_of_target), spans)
    table[:, 0] = np.cumsum(table[:, 0])
    _require_alive_together(_bounded(table), size, config.max_targets)
    targets = np.repeat(table[:, 2:], table[:, 1], axis=0)
    if config.targets_move:
        tracks = np.cumsum(reader.columns(len(_MOTION), len(targets)), axis=0)
        plays = prey[:, _PLAYS :: len(PREY)]
        tracks[:, SPEED : TURN_RATE + 1] += _commanded_targets(config, prey_commands, plays, table)
        moving = np.zeros((len(targets), numbers_of_target), dtype=np.int64)
        moving[:, _IDENTITY] = targets
        moving[:, _MOTION] = _with_motion(tracks, _ticks_of_targets(ticks, table))
        targets = moving
    return _with_targets(fixed, targets, _states_of(table), prey)


def _bounded(numbers: Matrix) -> Matrix:
    if numbers.size and not -_LARGEST <= numbers.min() <= numbers.max() <= _LARGEST:
        raise ReplayError("is damaged: a quantised state holds a number beyond 2^53")
    return numbers


def _ticks(times_ms: NDArray[np.int64]) -> NDArray[np.int64]:
    """R1.2: the ticks that led to each state, no more than move a hunter; none to the first."""
    return np.clip(np.diff(times_ms // TICK_MS, prepend=times_ms[:1] // TICK_MS), 0, _MOST_TICKS)


def _states_of(spans: Matrix) -> NDArray[np.int64]:
    """The states of all spans, span after span."""
    begin, length = spans[:, 0], spans[:, 1]
    return np.arange(length.sum()) + np.repeat(begin - np.cumsum(length) + length, length)


def _ticks_of_targets(ticks: NDArray[np.int64], spans: Matrix) -> NDArray[np.int64]:
    """R3.8: the ticks that led to each of these states; none to the first that a target is in."""
    found = ticks[_states_of(spans)]
    found[np.cumsum(spans[:, 1]) - spans[:, 1]] = 0
    return found


def _commanded(config: ArenaConfig, commands: NDArray[np.float32]) -> list[Matrix | None]:
    """R2.5: the velocities that each seat's commands ask for, with a row of zeros before the first: (steps + 1, 2);
    None under target control.
    """
    found: list[Matrix | None] = [None] * config.hunters
    for seat in driven_seats(config):
        limits = config.max_speeds[seat], config.max_turn_rates[seat]
        asked = _asked(commands[:, seat], limits, reverse=config.reverse)
        found[seat] = np.vstack((np.zeros((1, 2), dtype=np.int64), asked))
    return found


def _asked(commands: NDArray[np.float32], limits: tuple[float, float], *, reverse: bool) -> Matrix:
    """R2.5: the velocities that a body's commands ask for, as fractions of its limits: (..., 2) to the same."""
    high = np.array(limits, dtype=np.float64)
    low = -high if reverse else high * [0.0, -1.0]
    return rounded(np.clip(commands.astype(np.float64) * high, low, high), 1e6)


def _commanded_targets(config: ArenaConfig, prey_commands: NDArray[np.float32], plays: Matrix, spans: Matrix) -> Matrix:
    """R12.2: the velocities that prey's commands ask for, in all states of the spans, span after span: (states, 2).

    Zeros for targets that nobody plays, and where one has just appeared: it stands still (R3.8).

    Args:
        config: the arena's settings.
        prey_commands: (steps, P, 2).
        plays: the number of each prey's target in each state, 0 for none: (steps + 1, P).
        spans: when each target is alive, and its number.
    """
    at, numbers = _states_of(spans), np.repeat(spans[:, 2], spans[:, 1])
    appeared = np.cumsum(spans[:, 1]) - spans[:, 1]
    limits = config.target_speed_mps, config.target_turn_rate_radps
    asked = np.zeros((len(at), 2), dtype=np.int64)
    for index in range(config.prey):
        led = plays[at, index] == numbers
        led[appeared] = False
        asked[led] = _asked(prey_commands[at[led] - 1, index], limits, reverse=config.reverse)
    return asked


def _without_motion(numbers: Matrix, ticks: NDArray[np.int64]) -> Matrix:
    """How each row differs from the one before, but for what R2.2 moves: a body's numbers, x first, and others."""
    rest = np.diff(numbers, axis=0, prepend=0)
    rest[:, THETA] -= _turned(numbers, ticks)
    rest[:, X : Y + 1] -= _travelled(numbers, ticks)
    return rest


def _with_motion(numbers: Matrix, ticks: NDArray[np.int64]) -> Matrix:
    """`_without_motion` undone, in the same memory: `numbers` are the sums of its rows, velocities as they were."""
    _bounded(numbers[:, SPEED : TURN_RATE + 1])
    numbers[:, THETA] += np.cumsum(_turned(numbers, ticks))
    _bounded(numbers[:, THETA])
    numbers[:, X : Y + 1] += np.cumsum(_travelled(numbers, ticks), axis=0)
    return _bounded(numbers)


def _turned(numbers: Matrix, ticks: NDArray[np.int64]) -> NDArray[np.int64]:
    """R2.2: how far a body's turn rate has turned it on its way to each state."""
    return (TICK_MS * numbers[:, TURN_RATE] * ticks + 500) // 1000


def _travelled(numbers: Matrix, ticks: NDArray[np.int64]) -> Matrix:
    """R2.2: how far its velocities have carried it: (states, 2)."""
    displacement = np.zeros((len(ticks), 2))
    before = np.concatenate(([0], numbers[:-1, THETA]))[: len(ticks)]
    theta, speed, turn_rate = (
        column.astype(np.float64) for column in (before, numbers[:, SPEED], numbers[:, TURN_RATE])
    )
    _travel(theta, speed, turn_rate, ticks, displacement)
    return rounded(displacement, 1.0)


@entry
def _travel(
    theta: NDArray[np.float64],
    speed: NDArray[np.float64],
    turn_rate: NDArray[np.float64],
    ticks: NDArray[np.int64],
    displacement: NDArray[np.float64],
) -> None:
    """R2.2 in millionths, on the core's own sine and cosine: every machine must take off what another one put on."""
    for step in range(len(ticks)):
        angle = theta[step] / 1000000.0
        turn = turn_rate[step] / 1000000.0 * DT
        stride = speed[step] * DT
        for _ in range(ticks[step]):
            angle = angle + turn
            sine, cosine = sincos(angle)
            displacement[step, 0] = displacement[step, 0] + cosine * stride
            displacement[step, 1] = displacement[step, 1] + sine * stride


def _spans(targets: Sequence[Matrix]) -> Matrix:
    """For each stretch of states in which a target's numbers stay as they are: where it begins, how long it is, and
    the numbers; in their order: (spans, 7).
    """
    begun: dict[tuple[int, ...], int] = {}
    spans: list[tuple[int, ...]] = []
    for at, rows in enumerate(targets):
        alive = set(map(tuple, rows.tolist()))
        for gone in begun.keys() - alive:
            since = begun.pop(gone)
            spans.append((since, at - since, *gone))
        for target in alive:
            begun.setdefault(target, at)
    spans += [(since, len(targets) - since, *target) for target, since in begun.items()]
    return np.array(sorted(spans), dtype=np.int64).reshape(-1, 2 + len(_STILL_TARGET))


def _lives(targets: Sequence[Matrix]) -> tuple[Matrix, Matrix]:
    """For each stretch of states in which a moving target is alive: where it begins, how long it is, and who it is, in
    their order; and its numbers that change, state after state and stretch after stretch: (spans, 4), (states, 6).
    """
    alive: dict[tuple[int, ...], tuple[int, list[list[int]]]] = {}
    ended: list[tuple[int, int, tuple[int, ...], list[list[int]]]] = []
    for at, rows in enumerate([*targets, np.zeros((0, len(_MOVING_TARGET)), dtype=np.int64)]):
        here = dict(zip(map(tuple, rows[:, _IDENTITY].tolist()), rows[:, _MOTION].tolist(), strict=True))
        for who in alive.keys() - here:
            since, track = alive.pop(who)
            ended.append((since, len(track), who, track))
        for who, numbers in here.items():
            alive.setdefault(who, (at, []))[1].append(numbers)
    ended.sort()
    spans = [(since, length, *who) for since, length, who, _ in ended]
    tracks = [numbers for *_, track in ended for numbers in track]
    return (
        np.array(spans, dtype=np.int64).reshape(-1, 2 + len(_IDENTITY)),
        np.array(tracks, dtype=np.int64).reshape(-1, len(_MOTION)),
    )


def _require_alive_together(spans: Matrix, size: int, most: int) -> None:
    """Before there is a row for each of their states.

    Raises:
        ReplayError: for spans that cannot be.
    """
    begin, length = spans[:, 0], spans[:, 1]
    if np.any((begin < 0) | (begin >= size)):
        raise ReplayError("is damaged: its quantised states have a target outside the match")
    changes = np.zeros(size + 1, dtype=np.int64)
    if not np.any((length < 1) | (begin + length > size)):
        np.add.at(changes, begin, 1)
        np.add.at(changes, begin + length, -1)
        if np.cumsum(changes).max() <= most:
            return
    raise ReplayError("is damaged: its quantised states have targets that cannot be alive together")


def _with_targets(fixed: Matrix, targets: Matrix, at: NDArray[np.int64], prey: Matrix) -> list[QuantisedState]:
    """Every state with the targets that are alive in it, by number; `at` says which state each row of targets is in.

    Raises:
        ReplayError: where a target is twice in a state.
    """
    order = np.lexsort((targets[:, _NUMBER], at))
    targets, at = targets[order], at[order]
    if np.any((np.diff(at) == 0) & (np.diff(targets[:, _NUMBER]) == 0)):
        raise ReplayError("is damaged: its quantised states have targets that cannot be alive together")
    ends = np.searchsorted(at, np.arange(1, len(fixed)))
    alive = np.split(targets, ends)
    return [np.concatenate((row, tail.reshape(-1), last)) for row, tail, last in zip(fixed, alive, prey, strict=True)]
