"""Quantised states: the numbers of A.8 in whole millionths, and their short form in files.

A digest tells that two states differ; the quantised states tell in what. Messages for users call one the *witness* of
its digest. In a file a hunter's numbers stand as what is left after R2.2's motion has been taken off, which is almost
nothing, and a target's numbers stand once.
"""

from collections.abc import Sequence
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.config import ArenaConfig
from catch_arena.core.jit import entry
from catch_arena.core.math import sincos
from catch_arena.errors import ReplayError
from catch_arena.replay.columns import Reader, pack_columns

QuantisedState = NDArray[np.int64]
"""One state: the numbers of `Engine.state()`, those that have a unit other than ms in whole millionths of it."""
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
TARGET: Final = {"number": "", "x": "m", "y": "m", "theta": "rad", "appeared": ""}
X, Y, THETA, SPEED, TURN_RATE, ACTIVE, SCORE = 0, 1, 2, 3, 4, 7, 8

_LARGEST: Final = 2**53
_MOST_TICKS: Final = 62  # R2.4: after a second the velocities are zero


@cache
def _scale(hunters: int, targets: int) -> NDArray[np.float64]:
    """What each number of a state is multiplied by."""
    units = [*[""] * len(ARENA), *[*HUNTER.values()] * hunters, *[*TARGET.values()] * targets]
    return np.array([1e6 if unit else 1.0 for unit in units])


def rounded(numbers: NDArray[np.float64], scale: float | NDArray[np.float64]) -> NDArray[np.int64]:
    """floor(scale * number + 0.5), at most 2^53 in size."""
    return np.clip(np.floor(scale * numbers + 0.5), -_LARGEST, _LARGEST).astype(np.int64)


def quantise(state: NDArray[np.float64], hunters: int) -> QuantisedState:
    """A state as `Engine.state()` gives it, in whole millionths."""
    fixed = len(ARENA) + hunters * len(HUNTER)
    return rounded(state, _scale(hunters, (len(state) - fixed) // len(TARGET)))


def scores(state: QuantisedState, hunters: int) -> list[int]:
    """Every hunter's score in that state."""
    first, size = len(ARENA), len(HUNTER)
    return [int(score) for score in state[first + SCORE : first + hunters * size : size]]


def state_length(config: ArenaConfig) -> int:
    """How many numbers a quantised state has at most."""
    return len(ARENA) + config.hunters * len(HUNTER) + config.max_targets * len(TARGET)


def driven_seats(config: ArenaConfig) -> list[int]:
    """The seats whose velocity commands mean something."""
    return [seat for seat, control in enumerate(config.controls) if control != "target"]


def pack_states(
    config: ArenaConfig, commands: NDArray[np.float32], states: Sequence[QuantisedState]
) -> tuple[bytes, int]:
    """The states of a match, the initial one and that of each step, as bytes; and how many spans are in them.

    Args:
        config: the arena's settings.
        commands: (steps, H, 2).
        states: the states to be packed.
    """
    fixed = np.array([row[: len(ARENA) + config.hunters * len(HUNTER)] for row in states])
    arena = fixed[:, : len(ARENA)]
    parts = [pack_columns(np.diff(arena, axis=0, prepend=0).T)]
    ticks = _ticks(arena[:, 0])
    for seat, given in enumerate(_commanded(config, commands)):
        first = len(ARENA) + seat * len(HUNTER)
        numbers = fixed[:, first : first + len(HUNTER)]
        rest = np.diff(numbers, axis=0, prepend=0)
        rest[:, ACTIVE] = numbers[:, ACTIVE]
        if given is not None:
            rest[:, SPEED : TURN_RATE + 1] = numbers[:, SPEED : TURN_RATE + 1] - given
        rest[1:, THETA] -= _turned(numbers, ticks)
        rest[1:, X : Y + 1] -= _travelled(numbers, ticks)
        parts.append(pack_columns(rest.T))
    spans = _spans(states, fixed.shape[1])
    spans[:, 0] = np.diff(spans[:, 0], prepend=0)
    return b"".join(parts) + pack_columns(spans.T), len(spans)


def unpack_states(
    config: ArenaConfig, commands: NDArray[np.float32], reader: Reader, spans: int
) -> list[QuantisedState]:
    """The states that `pack_states` wrote.

    Raises:
        ReplayError: where it is no replay, or a damaged one.
    """
    size, hunter = len(commands) + 1, len(HUNTER)
    fixed = np.zeros((size, len(ARENA) + config.hunters * hunter), dtype=np.int64)
    fixed[:, : len(ARENA)] = _bounded(np.cumsum(reader.columns(len(ARENA), size), axis=0))
    ticks = _ticks(fixed[:, 0])
    for seat, given in enumerate(_commanded(config, commands)):
        rest = reader.columns(hunter, size)
        numbers = np.cumsum(rest, axis=0)
        numbers[:, ACTIVE] = rest[:, ACTIVE]
        if given is not None:
            numbers[:, SPEED : TURN_RATE + 1] = rest[:, SPEED : TURN_RATE + 1] + given
        _bounded(numbers[:, SPEED : TURN_RATE + 1])
        numbers[1:, THETA] += np.cumsum(_turned(numbers, ticks))
        _bounded(numbers[:, THETA])
        numbers[1:, X : Y + 1] += np.cumsum(_travelled(numbers, ticks), axis=0)
        fixed[:, len(ARENA) + seat * hunter :][:, :hunter] = _bounded(numbers)
    table = reader.columns(2 + len(TARGET), spans)
    table[:, 0] = np.cumsum(table[:, 0])
    return _with_targets(fixed, _bounded(table), config.max_targets)


def _bounded(numbers: Matrix) -> Matrix:
    if numbers.size and not -_LARGEST <= numbers.min() <= numbers.max() <= _LARGEST:
        raise ReplayError("is damaged: its witness holds a number beyond 2^53")
    return numbers


def _ticks(times_ms: NDArray[np.int64]) -> NDArray[np.int64]:
    """R1.2: the ticks of each step, no more than move anything."""
    return np.clip(np.diff(times_ms // 16), 0, _MOST_TICKS)


def _commanded(config: ArenaConfig, commands: NDArray[np.float32]) -> list[Matrix | None]:
    """R2.5: the velocities that each seat's commands ask for, with a row of zeros before the first: (steps + 1, 2);
    None under target control.
    """
    found: list[Matrix | None] = [None] * config.hunters
    for seat in driven_seats(config):
        high = np.array([config.max_speeds[seat], config.max_turn_rates[seat]], dtype=np.float64)
        low = -high if config.reverse else high * [0.0, -1.0]
        asked = np.clip(commands[:, seat].astype(np.float64) * high, low, high)
        found[seat] = np.vstack((np.zeros((1, 2), dtype=np.int64), rounded(asked, 1e6)))
    return found


def _turned(numbers: Matrix, ticks: NDArray[np.int64]) -> NDArray[np.int64]:
    """R2.2: how far a hunter's turn rate turns it in each step."""
    return (16 * numbers[1:, TURN_RATE] * ticks + 500) // 1000


def _travelled(numbers: Matrix, ticks: NDArray[np.int64]) -> Matrix:
    """R2.2: how far its velocities carry it in each step: (steps, 2)."""
    displacement = np.zeros((len(ticks), 2))
    theta, speed, turn_rate = (
        numbers[rows, column].astype(np.float64)
        for rows, column in ((slice(-1), THETA), (slice(1, None), SPEED), (slice(1, None), TURN_RATE))
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
        turn = turn_rate[step] / 1000000.0 * 0.016
        stride = speed[step] * 0.016
        for _ in range(ticks[step]):
            angle = angle + turn
            sine, cosine = sincos(angle)
            displacement[step, 0] = displacement[step, 0] + cosine * stride
            displacement[step, 1] = displacement[step, 1] + sine * stride


def _spans(states: Sequence[QuantisedState], first: int) -> Matrix:
    """For each stretch of states in which a target's numbers stay as they are: where it begins, how long it is, and
    the numbers; in their order: (spans, 7).
    """
    begun: dict[tuple[int, ...], int] = {}
    spans: list[tuple[int, ...]] = []
    for at, row in enumerate(states):
        alive = set(map(tuple, row[first:].reshape(-1, len(TARGET)).tolist()))
        for gone in begun.keys() - alive:
            since = begun.pop(gone)
            spans.append((since, at - since, *gone))
        for target in alive:
            begun.setdefault(target, at)
    spans += [(since, len(states) - since, *target) for target, since in begun.items()]
    return np.array(sorted(spans), dtype=np.int64).reshape(-1, 2 + len(TARGET))


def _with_targets(fixed: Matrix, spans: Matrix, most: int) -> list[QuantisedState]:
    """Every row with the targets that are alive in it, by number.

    Raises:
        ReplayError: for spans that cannot be.
    """
    beginnings: dict[int, list[list[int]]] = {}
    for begin, *rest in spans.tolist():
        beginnings.setdefault(begin, []).append(rest)
    if not all(0 <= begin < len(fixed) for begin in beginnings):
        raise ReplayError("is damaged: its witness has a target outside the match")
    alive: dict[int, tuple[int, list[int]]] = {}
    tail = np.zeros(0, dtype=np.int64)
    rows = []
    for at, row in enumerate(fixed):
        ended = [number for number, (end, _) in alive.items() if end == at]
        for number in ended:
            del alive[number]
        for length, *target in beginnings.get(at, ()):
            if length < 1 or target[0] in alive or len(alive) == most or at + length > len(fixed):
                raise ReplayError("is damaged: its witness has targets that cannot be alive together")
            alive[target[0]] = (at + length, target)
        if ended or at in beginnings:
            tail = np.array([alive[number][1] for number in sorted(alive)], dtype=np.int64).reshape(-1)
        rows.append(np.concatenate((row, tail)))
    return rows
