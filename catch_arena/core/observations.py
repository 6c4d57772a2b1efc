"""Rulebook chapter 7: what each hunter sees, written in the order of layout.py's table."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.arbiter import distance_um
from catch_arena.core.jit import Block, phase, rule
from catch_arena.core.math import floor, sincos
from catch_arena.core.state import (
    ACTIVE,
    ALIVE,
    ARENA_ROWS,
    BEARING_INTEGRAL,
    COSINE,
    DISTANCE_INTEGRAL,
    LANES,
    NO_TARGET,
    SCORE,
    SEAT_SIZE,
    SEEN,
    SINE,
    SPEED,
    THETA,
    TIME,
    TURN_RATE,
    WITHDRAWN,
    Settings,
    Targets,
    X,
    Y,
    seat_of,
    targets_of,
    view_of,
)
from catch_arena.layout import RIVAL_COLUMNS, SELF_COLUMNS, TARGET_COLUMNS

Columns = NDArray[np.float32]
"""Observations of one seat in every lane: column c of lane l lies at c * LANES + l."""

SELF_WIDTH: Final = len(SELF_COLUMNS)
TARGET_WIDTH: Final = len(TARGET_COLUMNS)
RIVAL_WIDTH: Final = len(RIVAL_COLUMNS)

_PER_UM: Final = 64.0
_UM: Final = 1.0 / _PER_UM  # a power of two: exact
"""A sorting key is micrometres * 64 + slot or seat: one exact float64 that sorts by distance and then by spawning
order.
"""
_ABSENT: Final = 9007199254740992.0
"""The key of what is not there: above any other."""


def selection_network(wires: int, outputs: int) -> NDArray[np.int64]:
    """The comparators, as an array (n, 2) of wires, that bring the smallest `outputs` of `wires` keys to the front,
    in order.

    Batcher's odd-even merge sort for any number of wires (Knuth, The Art of Computer Programming 3, algorithm
    5.2.2M), without the comparators that no output depends on.
    """
    comparators: list[tuple[int, int]] = []
    top = 1 << max(0, (wires - 1).bit_length() - 1)
    p = top
    while p > 0:
        q, r, d = top, 0, p
        while True:
            comparators += [(i, i + d) for i in range(wires - d) if i & p == r]
            if q == p:
                break
            d, q, r = q - p, q >> 1, p
        p >>= 1
    needed = set(range(outputs))
    kept: list[tuple[int, int]] = []
    for low, high in reversed(comparators):
        if low in needed or high in needed:
            needed |= {low, high}
            kept.append((low, high))
    return np.array(kept[::-1], dtype=np.int64).reshape(-1, 2)


@phase
def order(keys: Block, network: NDArray[np.int64], lanes: int, wires: int) -> None:
    """Sort the keys of every lane, as far as the network goes; from wire `wires` on all keys are _ABSENT, and stay."""
    for comparator in range(len(network)):
        if network[comparator, 1] >= wires:
            continue
        first = keys[network[comparator, 0] * LANES : (network[comparator, 0] + 1) * LANES]
        second = keys[network[comparator, 1] * LANES : (network[comparator, 1] + 1) * LANES]
        for lane in range(lanes):
            a = first[lane]
            b = second[lane]
            first[lane] = a if a < b else b
            second[lane] = b if a < b else a


@rule
def item_of(key: float) -> float:
    """The slot or seat in a key."""
    return key - _PER_UM * floor(key * _UM)


@phase
def face(me: Block, lanes: int) -> None:
    """The heading's sine and cosine, which the observation and the next step's controller read."""
    for lane in range(lanes):
        sine, cosine = sincos(me[THETA + lane])
        me[SINE + lane] = sine
        me[COSINE + lane] = cosine


@phase
def see_self(arena: Block, me: Block, lanes: int, s: Settings, seen: Columns) -> None:
    """R7.1: what a hunter knows of itself."""
    for lane in range(lanes):
        left = s.time_limit - arena[TIME + lane]
        seen[0 * LANES + lane] = me[X + lane]
        seen[1 * LANES + lane] = me[Y + lane]
        seen[2 * LANES + lane] = me[COSINE + lane]
        seen[3 * LANES + lane] = me[SINE + lane]
        seen[4 * LANES + lane] = me[SPEED + lane]
        seen[5 * LANES + lane] = me[TURN_RATE + lane]
        seen[6 * LANES + lane] = left / 1000.0 if left > 0.0 else 0.0
        seen[7 * LANES + lane] = me[SCORE + lane]
        seen[8 * LANES + lane] = me[DISTANCE_INTEGRAL + lane]
        seen[9 * LANES + lane] = me[BEARING_INTEGRAL + lane]


@phase
def rank_targets(
    arena: Block, me: Block, targets: Targets, lanes: int, network: NDArray[np.int64], s: Settings, keys: Block
) -> None:
    """R7.1: the alive targets by micrometres, then by spawn number; slots are in spawning order."""
    most = 0.0
    for lane in range(lanes):
        most = arena[ALIVE + lane] if arena[ALIVE + lane] > most else most
    wires = int(most)
    for slot in range(max(wires, s.targets_seen)):
        x = targets.x[slot * LANES : (slot + 1) * LANES]
        y = targets.y[slot * LANES : (slot + 1) * LANES]
        key = keys[slot * LANES : (slot + 1) * LANES]
        for lane in range(lanes):
            near = distance_um(x[lane] - me[X + lane], y[lane] - me[Y + lane]) * _PER_UM + slot
            key[lane] = near if slot < arena[ALIVE + lane] else _ABSENT
    order(keys, network, lanes, wires)


@phase
def see_targets(
    arena: Block, me: Block, view: Block, targets: Targets, lanes: int, s: Settings, keys: Block, seen: Columns
) -> None:
    """R7.1, R7.2: the nearest targets; the view remembers their slots for the next step's choice."""
    for lane in range(lanes):
        me[SEEN + lane] = min(arena[ALIVE + lane], float(s.targets_seen))
    for rank in range(s.targets_seen):
        key = keys[rank * LANES : (rank + 1) * LANES]
        slots = view[rank * LANES : (rank + 1) * LANES]
        first = (SELF_WIDTH + rank * TARGET_WIDTH) * LANES
        columns = seen[first : first + TARGET_WIDTH * LANES]
        for lane in range(lanes):
            present = key[lane] < _ABSENT
            slot = item_of(key[lane]) if present else 0.0
            at = np.uint64(slot) * np.uint64(LANES) + np.uint64(lane)
            dx = targets.x[at] - me[X + lane]
            dy = targets.y[at] - me[Y + lane]
            sine = me[SINE + lane]
            cosine = me[COSINE + lane]
            age = (arena[TIME + lane] - targets.appeared[at]) / 1000.0
            active = 1.0 if targets.number[at] == me[ACTIVE + lane] else 0.0
            slots[lane] = slot if present else float(NO_TARGET)
            columns[0 * LANES + lane] = cosine * dx + sine * dy if present else 0.0
            columns[1 * LANES + lane] = cosine * dy - sine * dx if present else 0.0
            columns[2 * LANES + lane] = 1.0 if present else 0.0
            columns[3 * LANES + lane] = age if present else 0.0
            columns[4 * LANES + lane] = active if present else 0.0


@phase
def rank_rivals(block: Block, seat: int, lanes: int, network: NDArray[np.int64], s: Settings, keys: Block) -> None:
    """R7.1, R1.6: the other hunters by micrometres; equal distances are put right by `break_ties`."""
    me = seat_of(block, seat)
    for other in range(s.hunters):
        rival = seat_of(block, other)
        key = keys[other * LANES : (other + 1) * LANES]
        absent = other == seat
        for lane in range(lanes):
            near = distance_um(rival[X + lane] - me[X + lane], rival[Y + lane] - me[Y + lane]) * _PER_UM + other
            key[lane] = _ABSENT if absent | (rival[WITHDRAWN + lane] > 0.0) else near
    order(keys, network, lanes, s.hunters)


@rule
def equally_far(nearer: float, farther: float) -> bool:
    """Whether two keys, the second of which is not smaller, have the same micrometres."""
    return (nearer < _ABSENT) & (floor(nearer * _UM) == floor(farther * _UM))


@rule
def rival_row(block: Block, me: Block, other: float, lane: int) -> tuple[float, float, float, float, float, float]:
    """R7.1: a rival as its observer sees it: forward, left, relative cosine and sine, velocity, score difference."""
    at = (
        np.uint64(other) * np.uint64(SEAT_SIZE) + np.uint64(ARENA_ROWS * LANES) + np.uint64(lane)
    )  # in seat_of(block, other)
    dx = block[at + np.uint64(X)] - me[X + lane]
    dy = block[at + np.uint64(Y)] - me[Y + lane]
    rival_sine = block[at + np.uint64(SINE)]
    rival_cosine = block[at + np.uint64(COSINE)]
    sine = me[SINE + lane]
    cosine = me[COSINE + lane]
    return (
        cosine * dx + sine * dy,
        cosine * dy - sine * dx,
        rival_cosine * cosine + rival_sine * sine,
        rival_sine * cosine - rival_cosine * sine,
        block[at + np.uint64(SPEED)],
        block[at + np.uint64(SCORE)] - me[SCORE + lane],
    )


@rule
def stands_before(
    a: tuple[float, float, float, float, float, float], b: tuple[float, float, float, float, float, float]
) -> bool:
    """R7.1, A.7: of two rivals equally far, the one seen further left, then further forward, and so on; never by
    seat.
    """
    if a[1] != b[1]:
        return a[1] > b[1]
    if a[0] != b[0]:
        return a[0] > b[0]
    if a[2] != b[2]:
        return a[2] > b[2]
    if a[3] != b[3]:
        return a[3] > b[3]
    if a[4] != b[4]:
        return a[4] > b[4]
    return a[5] > b[5]


@phase
def break_ties(block: Block, seat: int, lane: int, s: Settings, keys: Block) -> None:
    """R7.1: one lane's rivals again, all of them, by insertion: for the rare step in which two are equally far."""
    me = seat_of(block, seat)
    count = 0
    for other in range(s.hunters):
        rival = seat_of(block, other)
        if other == seat or rival[WITHDRAWN + lane] > 0.0:
            continue
        micrometres = distance_um(rival[X + lane] - me[X + lane], rival[Y + lane] - me[Y + lane])
        row = rival_row(block, me, float(other), lane)
        at = count
        while at > 0:
            before = keys[(at - 1) * LANES + lane]
            distance = floor(before * _UM)
            if distance < micrometres:
                break
            if distance == micrometres and not stands_before(row, rival_row(block, me, item_of(before), lane)):
                break
            keys[at * LANES + lane] = before
            at -= 1
        keys[at * LANES + lane] = micrometres * _PER_UM + other
        count += 1
    for at in range(count, s.hunters):
        keys[at * LANES + lane] = _ABSENT


@phase
def see_rivals(block: Block, seat: int, lanes: int, s: Settings, keys: Block, seen: Columns) -> None:
    """R7.1: the nearest rivals."""
    me = seat_of(block, seat)
    ranks = min(s.hunters_seen, s.hunters - 2)
    ties = 0
    for rank in range(ranks):
        nearer = keys[rank * LANES : (rank + 1) * LANES]
        farther = keys[(rank + 1) * LANES : (rank + 2) * LANES]
        for lane in range(lanes):
            ties += 1 if equally_far(nearer[lane], farther[lane]) else 0
    if ties > 0:
        for lane in range(lanes):
            tied = False
            for rank in range(ranks):
                tied = tied or equally_far(keys[rank * LANES + lane], keys[(rank + 1) * LANES + lane])
            if tied:
                break_ties(block, seat, lane, s, keys)
    for rank in range(s.hunters_seen):
        first = (SELF_WIDTH + s.targets_seen * TARGET_WIDTH + rank * RIVAL_WIDTH) * LANES
        columns = seen[first : first + RIVAL_WIDTH * LANES]
        key = keys[rank * LANES : (rank + 1) * LANES]
        for lane in range(lanes):
            present = key[lane] < _ABSENT
            forward, left, cosine, sine, velocity, difference = rival_row(
                block, me, item_of(key[lane]) if present else 0.0, lane
            )
            columns[0 * LANES + lane] = forward if present else 0.0
            columns[1 * LANES + lane] = left if present else 0.0
            columns[2 * LANES + lane] = 1.0 if present else 0.0
            columns[3 * LANES + lane] = cosine if present else 0.0
            columns[4 * LANES + lane] = sine if present else 0.0
            columns[5 * LANES + lane] = velocity if present else 0.0
            columns[6 * LANES + lane] = difference if present else 0.0


@rule
def deliver(observation: NDArray[np.float32], mask: NDArray[np.int8], seen: Columns, choices: float) -> None:
    """R7.1, R7.2: one lane's numbers as the row that the agent gets, and its mask."""
    for column in range(len(observation)):
        observation[column] = seen[column * LANES]
    for rank in range(len(mask)):
        mask[rank] = 1 if rank <= choices else 0


@phase
def observe(
    block: Block,
    s: Settings,
    lanes: int,
    target_network: NDArray[np.int64],
    rival_network: NDArray[np.int64],
    scratch: Block,
    seen: Columns,
    observations: NDArray[np.float32],
    masks: NDArray[np.int8],
) -> None:
    """R7.1, R7.2: the observations (lanes, H, D) and masks (lanes, H, K + 1) of one block."""
    keys = scratch[: 64 * LANES]
    targets = targets_of(block, s)
    for seat in range(s.hunters):
        face(seat_of(block, seat), lanes)
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        see_self(block, me, lanes, s, seen)
        rank_targets(block, me, targets, lanes, target_network, s, keys)
        see_targets(block, me, view_of(block, seat, s), targets, lanes, s, keys, seen)
        if s.hunters_seen > 0:
            rank_rivals(block, seat, lanes, rival_network, s, keys)
            see_rivals(block, seat, lanes, s, keys, seen)
        for lane in range(lanes):
            deliver(observations[lane, seat], masks[lane, seat], seen[lane:], me[SEEN + lane])
