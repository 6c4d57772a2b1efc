"""Rulebook chapter 7: what each hunter sees, written in the order of layout.py's table."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.arbiter import distance_um
from catch_arena.core.jit import Block, passage, phase, rule
from catch_arena.core.math import floor, sincos
from catch_arena.core.state import (
    ACTIVE,
    ALIVE,
    ARENA_ROWS,
    BEARING_INTEGRAL,
    COSINE,
    DISTANCE_INTEGRAL,
    LANES,
    RANKS_A_WORD,
    SCORE,
    SEAT_SIZE,
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
    word_at,
)
from catch_arena.core.workspace import Scratch, Tables, order_of
from catch_arena.layout import RIVAL_COLUMNS, SELF_COLUMNS, TARGET_COLUMNS

Observations = NDArray[np.float32]
"""(lanes, H, D)."""
Row = NDArray[np.float32]
"""One of them: (D,)."""
Masks = NDArray[np.int8]
"""(lanes, H, K + 1)."""

SELF_WIDTH: Final = len(SELF_COLUMNS)
TARGET_WIDTH: Final = len(TARGET_COLUMNS)
RIVAL_WIDTH: Final = len(RIVAL_COLUMNS)

_1, _2, _3, _4, _5, _6 = (np.uint64(offset) for offset in range(1, 7))

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

    Runs of keys are sorted, and then merged two by two, of which the smaller half goes on: the last part of Batcher's
    bitonic sort (Knuth, The Art of Computer Programming 3, section 5.3.4). Comparators that no output depends on are
    left out.
    """
    run = 1 << (outputs - 1).bit_length()
    comparators: list[tuple[int, int]] = []
    for first in range(0, wires, run):
        comparators += [(first + low, first + high) for low, high in _sorting_network(min(run, wires - first))]
    distance = run
    while distance < wires:
        for first in range(0, wires - distance, 2 * distance):
            second = first + distance
            comparators += [(first + run - 1 - i, second + i) for i in range(min(run, wires - second))]
            for apart in (run >> shift for shift in range(1, run.bit_length())):
                comparators += [(first + i, first + i + apart) for i in range(run) if not i & apart]
        distance *= 2
    needed = set(range(outputs))
    kept: list[tuple[int, int]] = []
    for low, high in reversed(comparators):
        if low in needed or high in needed:
            needed |= {low, high}
            kept.append((low, high))
    return np.array(kept[::-1], dtype=np.int64).reshape(-1, 2)


def _sorting_network(wires: int) -> list[tuple[int, int]]:
    """Batcher's odd-even merge sort for any number of wires (the same volume, algorithm 5.2.2M)."""
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
    return comparators


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
def item_of(key: float) -> int:
    """The slot or seat in a key."""
    return int(key) & 63


@phase
def note_order(keys: Block, ranks: int, lanes: int, words: Block) -> None:
    """The slots or seats of the first keys, as `state.item_at` reads them; 0 for what is absent."""
    place = 1.0
    for rank in range(ranks):
        key = keys[rank * LANES : (rank + 1) * LANES]
        row = rank // RANKS_A_WORD * LANES
        word = words[row : row + LANES]
        starts = rank % RANKS_A_WORD == 0
        place = 1.0 if starts else place * _PER_UM
        for lane in range(lanes):
            item = key[lane] - _PER_UM * floor(key[lane] * _UM)
            word[lane] = item if starts else word[lane] + item * place


@phase
def face(me: Block, lanes: int) -> None:
    """The heading's sine and cosine, which the observation and the next step's controller read."""
    for lane in range(lanes):
        sine, cosine = sincos(me[THETA + lane])
        me[SINE + lane] = sine
        me[COSINE + lane] = cosine


@phase
def most_alive(arena: Block, lanes: int) -> int:
    """In any lane."""
    most = 0.0
    for lane in range(lanes):
        most = arena[ALIVE + lane] if arena[ALIVE + lane] > most else most
    return int(most)


@phase
def note_ages(arena: Block, targets: Targets, lanes: int, slots: int, ages: Block) -> None:
    """R7.1: how long each target has been there [s]."""
    for slot in range(slots):
        appeared = targets.appeared[slot * LANES : (slot + 1) * LANES]
        age = ages[slot * LANES : (slot + 1) * LANES]
        for lane in range(lanes):
            age[lane] = (arena[TIME + lane] - appeared[lane]) / 1000.0


@phase
def rank_targets(
    arena: Block, me: Block, targets: Targets, lanes: int, slots: int, network: NDArray[np.int64], keys: Block
) -> None:
    """R7.1: the alive targets by micrometres, then by spawn number; slots are in spawning order."""
    for slot in range(slots):
        x = targets.x[slot * LANES : (slot + 1) * LANES]
        y = targets.y[slot * LANES : (slot + 1) * LANES]
        key = keys[slot * LANES : (slot + 1) * LANES]
        for lane in range(lanes):
            near = distance_um(x[lane] - me[X + lane], y[lane] - me[Y + lane]) * _PER_UM + slot
            key[lane] = near if slot < arena[ALIVE + lane] else _ABSENT
    order(keys, network, lanes, slots)


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
def rival_row(block: Block, me: Block, other: int, lane: int) -> tuple[float, float, float, float, float, float]:
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
        row = rival_row(block, me, other, lane)
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
def settle_ties(block: Block, seat: int, lane: int, ranks: int, keys: Block) -> None:
    """R7.1: one lane's sorted rivals, of whom those equally far are put in order among themselves, by insertion."""
    me = seat_of(block, seat)
    for rank in range(1, ranks + 1):
        at = rank
        while at > 0:
            before = keys[(at - 1) * LANES + lane]
            key = keys[at * LANES + lane]
            if not equally_far(before, key):
                break
            if not stands_before(rival_row(block, me, item_of(key), lane), rival_row(block, me, item_of(before), lane)):
                break
            keys[(at - 1) * LANES + lane] = key
            keys[at * LANES + lane] = before
            at -= 1


@phase
def mend_ties(block: Block, seat: int, lanes: int, s: Settings, keys: Block) -> None:
    """R7.1: lanes in which two rivals that are seen, or the last one and the next, are equally far."""
    ranks = min(s.hunters_seen, s.hunters - 2)
    ties = 0
    for rank in range(ranks):
        nearer = keys[rank * LANES : (rank + 1) * LANES]
        farther = keys[(rank + 1) * LANES : (rank + 2) * LANES]
        for lane in range(lanes):
            ties += 1 if equally_far(nearer[lane], farther[lane]) else 0
    if ties == 0:
        return
    all_sorted = ranks + 1 >= s.hunters - 1
    for lane in range(lanes):
        if all_sorted or not equally_far(keys[(ranks - 1) * LANES + lane], keys[ranks * LANES + lane]):
            settle_ties(block, seat, lane, ranks, keys)
        else:
            break_ties(block, seat, lane, s, keys)


@phase
def write_self(me: Block, lane: int, time_left: float, row: Row) -> None:
    """R7.1: what a hunter knows of itself."""
    row[0] = me[X + lane]
    row[1] = me[Y + lane]
    row[2] = me[COSINE + lane]
    row[3] = me[SINE + lane]
    row[4] = me[SPEED + lane]
    row[5] = me[TURN_RATE + lane]
    row[6] = time_left
    row[7] = me[SCORE + lane]
    row[8] = me[DISTANCE_INTEGRAL + lane]
    row[9] = me[BEARING_INTEGRAL + lane]


@phase
def write_targets(
    me: Block, view: Block, targets: Targets, ages: Block, lane: int, there: int, s: Settings, row: Row
) -> None:
    """R7.1: the nearest targets, `there` of them."""
    x, y, sine, cosine = me[X + lane], me[Y + lane], me[SINE + lane], me[COSINE + lane]
    at = np.uint64(SELF_WIDTH)
    slots = np.uint64(0)  # as `item_at` reads them, but each word once, from its first rank on
    for rank in range(there):
        if rank % RANKS_A_WORD == 0:
            slots = np.uint64(word_at(view, rank, lane))
        place = (slots & np.uint64(63)) * np.uint64(LANES) + np.uint64(lane)
        slots >>= np.uint64(6)
        dx, dy = targets.x[place] - x, targets.y[place] - y
        # all are made first and then written: what lies side by side is then stored at once
        forward = np.float32(cosine * dx + sine * dy)
        left = np.float32(cosine * dy - sine * dx)
        age = np.float32(ages[place])
        active = np.float32(1.0 if targets.number[place] == me[ACTIVE + lane] else 0.0)
        row[at] = forward
        row[at + _1] = left
        row[at + _2] = np.float32(1.0)
        row[at + _3] = age
        row[at + _4] = active
        at += np.uint64(TARGET_WIDTH)
    for column in range(SELF_WIDTH + there * TARGET_WIDTH, SELF_WIDTH + s.targets_seen * TARGET_WIDTH):
        row[column] = np.float32(0.0)


@phase
def write_rivals(block: Block, me: Block, order: Block, lane: int, there: int, s: Settings, row: Row) -> None:
    """R7.1: the nearest rivals, `there` of them."""
    at = np.uint64(SELF_WIDTH + s.targets_seen * TARGET_WIDTH)
    seats = np.uint64(0)
    for rank in range(there):
        if rank % RANKS_A_WORD == 0:
            seats = np.uint64(word_at(order, rank, lane))
        other = int(seats & np.uint64(63))
        seats >>= np.uint64(6)
        forward, left, cosine, sine, velocity, difference = rival_row(block, me, other, lane)
        row[at] = forward
        row[at + _1] = left
        row[at + _2] = np.float32(1.0)
        row[at + _3] = cosine
        row[at + _4] = sine
        row[at + _5] = velocity
        row[at + _6] = difference
        at += np.uint64(RIVAL_WIDTH)
    for column in range(at, len(row)):
        row[column] = np.float32(0.0)


@phase
def write_mask(there: int, ranks: int, mask: NDArray[np.int8]) -> None:
    """R7.2: hold and the ranks that have a target. Masks change rarely, and most need not be written."""
    if mask[there] == 0 or (there < ranks and mask[there + 1] == 1):
        for rank in range(ranks + 1):
            mask[rank] = 1 if rank <= there else 0


@phase
def write(block: Block, s: Settings, lanes: int, scratch: Scratch, seen: Observations, masks: Masks) -> None:
    """R7.1, R7.2: the rows one after the other, as they lie in memory: it is the memory that large batches wait for."""
    targets = targets_of(block, s)
    for lane in range(lanes):
        targets_there = min(int(block[ALIVE + lane]), s.targets_seen)
        remaining = s.time_limit - block[TIME + lane]
        time_left = remaining / 1000.0 if remaining > 0.0 else 0.0
        present = 0
        for seat in range(s.hunters):
            present += 1 if seat_of(block, seat)[WITHDRAWN + lane] == 0.0 else 0
        for seat in range(s.hunters):
            me = seat_of(block, seat)
            row = seen[lane, seat]
            others = present - (1 if me[WITHDRAWN + lane] == 0.0 else 0)
            write_self(me, lane, time_left, row)
            write_targets(me, view_of(block, seat, s), targets, scratch.ages, lane, targets_there, s, row)
            write_rivals(block, me, order_of(scratch, seat), lane, min(others, s.hunters_seen), s, row)
            write_mask(targets_there, s.targets_seen, masks[lane, seat])


@passage
def observe(
    block: Block,
    s: Settings,
    lanes: int,
    tables: Tables,
    scratch: Scratch,
    seen: Observations,
    masks: Masks,
) -> None:
    """R7.1, R7.2: who sees whom in which order, and then the observations and masks of one block. The order of the
    targets stays in the arena: the next step's choices are ranks in it.
    """
    targets = targets_of(block, s)
    slots = most_alive(block, lanes)
    note_ages(block, targets, lanes, slots, scratch.ages)
    for seat in range(s.hunters):
        face(seat_of(block, seat), lanes)
    for seat in range(s.hunters):
        rank_targets(block, seat_of(block, seat), targets, lanes, slots, tables.target_network, scratch.keys)
        note_order(scratch.keys, min(slots, s.targets_seen), lanes, view_of(block, seat, s))
        if s.hunters_seen > 0:
            rank_rivals(block, seat, lanes, tables.rival_network, s, scratch.keys)
            mend_ties(block, seat, lanes, s, scratch.keys)
            note_order(scratch.keys, s.hunters_seen, lanes, order_of(scratch, seat))
    write(block, s, lanes, scratch, seen, masks)
