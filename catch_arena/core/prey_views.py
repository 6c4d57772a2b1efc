"""Rulebook R12.4: what prey sees of itself, of the hunters and of other prey, in the order of layout.py's table.

Prey's bodies lie in slots that differ by lane. They are gathered first, with rows like a seat's, so that hunters and
prey are seen by the same code.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.jit import Block, phase, rare
from catch_arena.core.memory import Sections
from catch_arena.core.ranking import (
    FAR,
    Keys,
    body_at,
    equally_far,
    gather_ties,
    item_of,
    key_of,
    lead,
    some_tied,
    sort_keys,
)
from catch_arena.core.state import (
    BODY,
    BODY_ROWS,
    COSINE,
    LANES,
    NO_TARGET,
    PREY_SLOT,
    SEAT_SIZE,
    SINE,
    SPEED,
    TIME,
    TIMES_CAUGHT,
    TURN_RATE,
    WITHDRAWN,
    Settings,
    X,
    Y,
    prey_of,
    seat_at,
    span,
    targets_of,
)
from catch_arena.core.vectors import Width, copy_eight, copy_four, group, put_rows, select
from catch_arena.core.workspace import FEATURE_STRIDE, GATHERED_SIZE, Scratch, gathered_of
from catch_arena.layout import MOST_SEEN_BY_PREY, BodyFeatures, PreySelfFeatures

Numbers = NDArray[np.float32]

_SELF_WIDTH: Final = len(PreySelfFeatures._fields)
_BODY_WIDTH: Final = len(BodyFeatures._fields)
_NOT_AMONG_THEM: Final = -1
"""Instead of an index: the observer is not one of the bodies that are ranked."""


@rare
def gather_prey(block: Block, s: Settings, lanes: int, targets: Block, scratch: Scratch) -> None:
    """The bodies of all prey, from their slots; those of prey that is out are zero, and hidden like a withdrawn hunter.

    Args:
        block: the block.
        s: the settings.
        lanes: how many lanes are arenas.
        targets: the slots of the block.
        scratch: see `workspace.Scratch`; the result.
    """
    for index in range(s.prey):
        me, gathered = prey_of(block, index, s), gathered_of(scratch, index)
        for lane in range(lanes):
            slot = int(me[PREY_SLOT + lane])
            gathered[WITHDRAWN + lane] = 1.0 if slot == NO_TARGET else 0.0
            at = max(slot, 0) * s.slot_size + BODY + lane
            for row in range(0, BODY_ROWS * LANES, LANES):
                gathered[row + lane] = 0.0 if slot == NO_TARGET else targets[at + row]


@phase
def rank_bodies(
    me: Block,
    others: Block,
    size: int,
    count: int,
    myself: int,
    width: Width,
    lanes: int,
    ranks: int,
    network: NDArray[np.int64],
    keys: Keys,
) -> None:
    """R12.4: bodies by distance, then as R7.1 has rivals.

    Args:
        me: the rows of the observer.
        others: the rows of all bodies.
        size: how many numbers there are of each.
        count: how many bodies.
        myself: which of them is the observer, or _NOT_AMONG_THEM.
        width: how many lanes a group has.
        lanes: how many lanes are arenas.
        ranks: how many are seen.
        network: (comparators, 2): see `ranking.selection_network`.
        keys: the result, rows of LANES: the keys of the nearest in the first rows, in order.
    """
    for item in range(count):
        other = others[item * size : (item + 1) * size]
        for first in range(0, span(width), len(width)):
            lane = group(first, width)
            key = key_of(other[X + lane] - me[X + lane], other[Y + lane] - me[Y + lane], item)
            unseen = (other[WITHDRAWN + lane] > 0.0) | (me[WITHDRAWN + lane] > 0.0) | (item == myself)
            keys[item * LANES + lane] = select(unseen, FAR, key)
    sort_keys(keys, network, width, count)
    last = min(ranks, count - 1)
    for first in range(0, span(width), len(width)):
        if some_tied(keys, last, group(first, width)):
            sort_tied_bodies(me, others, size, first, min(first + len(width), lanes), last, count, keys)


@rare
def sort_tied_bodies(
    me: Block, others: Block, size: int, first: int, last: int, ranks: int, count: int, keys: Keys
) -> None:
    """R12.4: in each lane the sorted bodies that are equally far are put in order among themselves, by insertion.

    `ranking.sort_ties` does the same with rivals, which differ in catches, team and seat too; bodies have none.

    Args:
        me: the rows of the observer.
        others: the rows of all bodies.
        size: how many numbers there are of each.
        first: the first lane.
        last: the lane behind the last.
        ranks: see `ranking.some_tied`.
        count: how many bodies.
        keys: sorted by distance, rows of LANES.
    """
    for lane in range(first, last):
        if not some_tied(keys, ranks, lane):
            continue
        for newest in range(1, gather_ties(lane, ranks, count, keys)):
            key = keys[newest * LANES + lane]
            body = others[item_of(key) * size :]
            at = newest
            while at > 0:
                before = keys[(at - 1) * LANES + lane]
                if not equally_far(before, key) or lead(me, body, others[item_of(before) * size :], lane) <= 0.0:
                    break
                keys[at * LANES + lane] = before
                at -= 1
            keys[at * LANES + lane] = key


@phase
def write_bodies(
    me: Block,
    others: Block,
    size: int,
    count: int,
    first: int,
    width: Width,
    ranks: int,
    exactly: bool,
    keys: Keys,
    features: Numbers,
    out: Numbers,
    at: int,
    stride: int,
) -> None:
    """R12.4: what one prey sees of bodies, in the lanes of one group.

    Args:
        me: the rows of the observer.
        others: the rows of all bodies.
        size: how many numbers there are of each.
        count: how many bodies.
        first: the first lane of the group.
        width: how many lanes the group has.
        ranks: how many are seen.
        exactly: whether the last one is copied only so far as it goes, since nothing is written behind it.
        keys: as `rank_bodies` leaves them.
        features: room for the columns of all bodies: see `observations.compute_target_features`.
        out: observations, flat.
        at: where in `out` the columns of rank 1 begin, of the first lane.
        stride: how far behind them those of the next lane begin.
    """
    for item in range(count):
        seen = body_at(me, others[item * size :], group(first, width))
        put_rows(features, item * len(width) * FEATURE_STRIDE, FEATURE_STRIDE, seen)
    for mine in range(len(width)):
        for rank in range(ranks):
            source = (item_of(keys[rank * LANES + first + mine]) * len(width) + mine) * FEATURE_STRIDE
            to = at + mine * stride + rank * _BODY_WIDTH
            if exactly and rank == ranks - 1:
                copy_four(out, to, features, source)
                copy_four(out, to + _BODY_WIDTH - 4, features, source + _BODY_WIDTH - 4)
            else:
                copy_eight(out, to, features, source)


@phase
def write_self(
    block: Block,
    caught: Block,
    me: Block,
    s: Settings,
    first: int,
    width: Width,
    out: Numbers,
    at: int,
    stride: int,
) -> None:
    """R12.4: what one prey knows of itself, in the lanes of one group.

    Args:
        block: the block.
        caught: how often it was caught, one row.
        me: the rows of the observer.
        s: the settings.
        first: the first lane of the group.
        width: how many lanes the group has.
        out: observations, flat.
        at: where in `out` its columns begin, of the first lane.
        stride: how far behind them those of the next lane begin.
    """
    lane = group(first, width)
    remaining = s.time_limit_ms - block[TIME + lane]
    own = PreySelfFeatures(
        x=me[X + lane],
        y=me[Y + lane],
        heading_cos=me[COSINE + lane],
        heading_sin=me[SINE + lane],
        linear_velocity=me[SPEED + lane],
        angular_velocity=me[TURN_RATE + lane],
        time_left=select(remaining > 0.0, remaining / 1000.0, 0.0),
        times_caught=caught[lane],
        alive=1.0 - me[WITHDRAWN + lane],
    )
    put_rows(out, at, stride, own)


@rare
def observe_as_prey(
    block: Block, s: Settings, width: Width, arena: int, lanes: int, sections: Sections, scratch: Scratch
) -> None:
    """R12.4, R12.3: the observations of all prey of a block.

    Args:
        block: the block.
        s: the settings.
        width: how many lanes a group has.
        arena: which of the batch is the first lane.
        lanes: how many lanes are arenas.
        sections: see `memory`; `prey_observations` is the result.
        scratch: see `workspace.Scratch`.
    """
    gather_prey(block, s, lanes, targets_of(block, s), scratch)
    out = sections.prey_observations.reshape(-1)
    hunters_seen, prey_seen = min(s.hunters, MOST_SEEN_BY_PREY), min(s.prey - 1, MOST_SEEN_BY_PREY)
    columns = _SELF_WIDTH + (hunters_seen + prey_seen) * _BODY_WIDTH
    stride = s.prey * columns
    hunters = block[seat_at(0) : seat_at(s.hunters)]
    for index in range(s.prey):
        me, caught = gathered_of(scratch, index), prey_of(block, index, s)[TIMES_CAUGHT : TIMES_CAUGHT + LANES]
        for side in range(2):
            of_hunters = side == 0
            others = hunters if of_hunters else scratch.gathered_prey
            size, count = (SEAT_SIZE, s.hunters) if of_hunters else (GATHERED_SIZE, s.prey)
            ranks = hunters_seen if of_hunters else prey_seen
            network = sections.hunter_network if of_hunters else sections.prey_network
            at = _SELF_WIDTH + (0 if of_hunters else hunters_seen * _BODY_WIDTH)
            if ranks == 0:
                continue
            rank_bodies(
                me,
                others,
                size,
                count,
                _NOT_AMONG_THEM if of_hunters else index,
                width,
                lanes,
                ranks,
                network,
                scratch.keys,
            )
            exactly = not of_hunters or prey_seen == 0
            for first in range(0, span(width), len(width)):
                if first >= lanes:
                    break
                apart = lanes - first < len(width)
                to = scratch.staging if apart else out
                begin = (0 if apart else (arena + first) * stride) + index * columns
                if of_hunters:
                    write_self(block, caught, me, s, first, width, to, begin, stride)
                write_bodies(
                    me,
                    others,
                    size,
                    count,
                    first,
                    width,
                    ranks,
                    exactly,
                    scratch.keys,
                    scratch.rival_features,
                    to,
                    begin + at,
                    stride,
                )
                if apart:
                    for lane in range(first, lanes):
                        for column in range(at if not of_hunters else 0, at + ranks * _BODY_WIDTH):
                            source = (lane - first) * stride + index * columns + column
                            out[(arena + lane) * stride + index * columns + column] = scratch.staging[source]
