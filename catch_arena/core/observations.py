"""Rulebook chapter 7: observations of hunters, in the order of layout.py's table."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core import rows
from catch_arena.core.addresses import flat
from catch_arena.core.features import (
    TILE_NUMBER,
    TILE_X,
    TILE_Y,
    body_of_tile,
    body_tile,
    in_frame_of,
    moving_target_seen,
    put_rank,
    rival_seen,
    target_of_tile,
    target_seen,
    team_rival_seen,
    tile_hunters,
    tile_targets,
    time_left_at,
)
from catch_arena.core.jit import Rows, outlined, phase, rule
from catch_arena.core.math import sincos
from catch_arena.core.memory import Sections
from catch_arena.core.prey_views import gather_prey, write_prey
from catch_arena.core.random import draw, seed_of
from catch_arena.core.ranking import Bodies, measure_bodies, order_bodies, rank_targets, write_order
from catch_arena.core.state import (
    ABSENT,
    Order,
    Orders,
    Settings,
    body_of,
    item_at_rank,
    limits_of,
    most_alive,
    seat_at,
    seat_of,
    targets_of,
    targets_ranked,
)
from catch_arena.core.transfers import (
    PREFETCHED,
    STREAMED,
    TILE,
    Place,
    prefetch,
    put_rows,
    stream_eight,
    take_tile,
)
from catch_arena.core.vectors import LANES, Width, group, played_lanes
from catch_arena.core.visibility import RIVAL_KIND, TARGET_KIND, blur, blur_key
from catch_arena.layout import MovingTargetFeatures, RivalFeatures, SelfFeatures, TargetFeatures, TeamRivalFeatures

Numbers = NDArray[np.float32]

SELF_WIDTH: Final = len(SelfFeatures._fields)
TARGET_WIDTH: Final = len(TargetFeatures._fields)
MOVING_TARGET_WIDTH: Final = len(MovingTargetFeatures._fields)
RIVAL_WIDTH: Final = len(RivalFeatures._fields)
TEAM_RIVAL_WIDTH: Final = len(TeamRivalFeatures._fields)

_STREAMED: Final = 1 << 21
"""Size of a batch's observations from which they go past the caches: they would displace everything else."""
_CACHED: Final = 1 << 19
"""Number of float64 of state that stay in the caches between steps; each chunk of a larger batch comes from memory."""
_LARGE: Final = 1 << 14
"""Size of a chunk from which it is not prefetched: it would displace the current chunk from the second cache."""


@phase
def update_heading(me: Rows, width: Width) -> None:
    """Write the heading's sine and cosine, which the observation and the next step's controller read."""
    for first in range(0, played_lanes(width), len(width)):
        lane = group(first, width)
        sine, cosine = sincos(me[rows.THETA + lane])
        me[rows.SINE + lane] = sine
        me[rows.COSINE + lane] = cosine


@phase
def write_self(me: Rows, first: int, width: Width, time_left: float, place: Place) -> None:
    """R7.1: write a hunter's view of itself, in the lanes of one group; `time_left`: until the time limit [s]."""
    lane = group(first, width)
    seen = SelfFeatures(
        x=me[rows.X + lane],
        y=me[rows.Y + lane],
        heading_cos=me[rows.COSINE + lane],
        heading_sin=me[rows.SINE + lane],
        linear_velocity=me[rows.SPEED + lane],
        angular_velocity=me[rows.TURN_RATE + lane],
        time_left=time_left,
        score=me[rows.SCORE + lane],
        distance_integral=me[rows.DISTANCE_INTEGRAL + lane],
        bearing_integral=me[rows.BEARING_INTEGRAL + lane],
    )
    put_rows(place.out, place.at, place.stride, seen)


@phase
def write_targets(
    chunk: Rows, s: Settings, first: int, width: Width, seat: int, order: Order, tiles: Rows, place: Place
) -> None:
    """R7.1, R7.4: write the targets that one seat sees, in the lanes of one group."""
    lane = group(first, width)
    me, active = body_tile(seat_of(chunk, seat), 0.0, lane), seat_of(chunk, seat)[rows.ACTIVE + lane]
    for rank in range(s.targets_seen):
        slots = item_at_rank(order, rank, lane)
        present = slots != ABSENT
        target = target_of_tile(take_tile(tiles, slots, width))
        at_rank = Place(place.out, place.at + rank * target_width(s), place.stride)
        is_last = s.hunters_seen == 0 and rank + 1 == s.targets_seen
        if s.targets_move:
            put_rank(at_rank, present, moving_target_seen(me, target, active), is_last)
        else:
            put_rank(at_rank, present, target_seen(me, target, active), is_last)
    if s.view_noise_m > 0.0:
        blur_seen(chunk, s, first, width, seat, order, TARGET_KIND, tiles, place)


@phase
def write_rivals(
    chunk: Rows, s: Settings, first: int, width: Width, seat: int, sections: Sections, place: Place
) -> None:
    """R7.1, R7.4: write the rivals that one seat sees, in the lanes of one group."""
    order, tiles, lane = sections.rival_orders[seat], sections.body_tiles, group(first, width)
    me = body_tile(seat_of(chunk, seat), 0.0, lane)
    for rank in range(s.hunters_seen):
        seats = item_at_rank(order, rank, lane)
        present = seats != ABSENT
        rival = body_of_tile(take_tile(tiles, seats, width))
        at_rank = Place(place.out, place.at + rank * rival_width(s), place.stride)
        is_last = rank + 1 == s.hunters_seen
        if s.has_teams:
            put_rank(at_rank, present, team_rival_seen(me, rival, float(sections.teams[seat])), is_last)
        else:
            put_rank(at_rank, present, rival_seen(me, rival), is_last)
    if s.view_noise_m > 0.0:
        blur_seen(chunk, s, first, width, seat, order, RIVAL_KIND, tiles, place)


@outlined
def blur_seen(
    chunk: Rows,
    s: Settings,
    first: int,
    width: Width,
    seat: int,
    order: Order,
    kind: np.uint64,
    tiles: Rows,
    place: Place,
) -> None:
    """R7.6: add the errors to the positions that one seat sees, and write them again."""
    of_targets = kind == TARGET_KIND
    columns = target_width(s) if of_targets else rival_width(s)
    for lane in range(first, first + len(width)):
        me = body_tile(seat_of(chunk, seat), 0.0, lane)
        seed = seed_of(chunk, lane)
        key = blur_key(seed, chunk[rows.STEP + lane], seat, kind)
        at = place.at + (lane - first) * place.stride
        for rank in range(s.targets_seen if of_targets else s.hunters_seen):
            item = item_at_rank(order, rank, lane)
            if item != ABSENT:
                tile = (item * len(width) + lane - first) * TILE
                forward, left = in_frame_of(me, tiles[tile + TILE_X] - me.x, tiles[tile + TILE_Y] - me.y)
                drawn = draw(key, np.uint64(tiles[tile + TILE_NUMBER]) if of_targets else np.uint64(item))
                place.out[at] = np.float32(forward + blur(drawn, 0, s.view_noise_m))
                place.out[at + 1] = np.float32(left + blur(drawn, 1, s.view_noise_m))
            at += columns


@rule
def target_width(s: Settings) -> int:
    """R7.4: return the number of columns of each target."""
    return MOVING_TARGET_WIDTH if s.targets_move else TARGET_WIDTH


@rule
def rival_width(s: Settings) -> int:
    """R7.4: return the number of columns of each rival."""
    return TEAM_RIVAL_WIDTH if s.has_teams else RIVAL_WIDTH


@phase
def write_masks(chunk: Rows, s: Settings, lanes: int, orders: Orders, masks: NDArray[np.int8]) -> None:
    """R7.2: update the masks, 1 for hold and for ranks that have a target. They change rarely; with a full view, all
    seats of an arena change together.
    """
    ranks = s.targets_seen
    for lane in range(lanes):
        seat = 0
        while seat < s.hunters:
            present = targets_ranked(chunk, s, lane, orders[seat])
            if masks[lane, seat, present] == 0 or (present < ranks and masks[lane, seat, present + 1] == 1):
                for rank in range(ranks + 1):
                    masks[lane, seat, rank] = 1 if rank <= present else 0
            elif not s.partial_view:
                break
            seat += 1


@phase
def copy_to_observations(staging: Numbers, count: int, out: Numbers, at: int) -> None:
    """Copy `count` numbers of a group's observations from the staging section to out[at], past the caches."""
    whole = count - count % STREAMED
    offset = 0
    while offset < whole:  # not a range: with Numba's a large batch is a quarter slower
        stream_eight(out, at + offset, staging, offset)
        offset += STREAMED
    for offset in range(whole, count):
        out[at + offset] = staging[offset]


@phase
def prefetch_part(next_chunk: Rows, part: int, parts: int) -> None:
    """Prefetch one of several equal parts of the next chunk. All parts together would make the current chunk wait
    too.
    """
    at, end = len(next_chunk) * part // parts, len(next_chunk) * (part + 1) // parts
    while at < end:  # see `copy_to_observations`
        prefetch(next_chunk, at)
        at += PREFETCHED


@phase
def write(
    chunk: Rows, s: Settings, width: Width, lanes: int, first_arena: int, orders: Orders, slots: int, sections: Sections
) -> None:
    """R7.1: write the observations of a chunk, one group of lanes after the other.

    They are written in place, with two exceptions that use the staging section: a group with lanes without an arena,
    and a batch so large that its observations should go past the caches, in the order of the memory.
    """
    next_chunk = chunk_after(sections.chunks, first_arena)
    columns, out = sections.observations.shape[2], flat(sections.observations)
    stride = sections.observations.shape[1] * columns
    for first in range(0, lanes, len(width)):
        is_staged = lanes - first < len(width) or len(out) > _STREAMED
        destination = sections.staging if is_staged else out
        begin = 0 if is_staged else (first_arena + first) * stride
        tile_targets(chunk, s, first, width, targets_of(chunk, s), slots, sections.target_tiles)
        if s.hunters_seen > 0:
            tile_hunters(chunk, s, first, width, sections.teams, sections.body_tiles)
        time_left = time_left_at(chunk, s, group(first, width))
        for seat in range(s.hunters):
            at = begin + seat * columns
            at_targets = at + SELF_WIDTH
            at_rivals = at_targets + s.targets_seen * target_width(s)
            write_self(seat_of(chunk, seat), first, width, time_left, Place(destination, at, stride))
            of_targets = Place(destination, at_targets, stride)
            write_targets(chunk, s, first, width, seat, orders[seat], sections.target_tiles, of_targets)
            write_rivals(chunk, s, first, width, seat, sections, Place(destination, at_rivals, stride))
            prefetch_part(next_chunk, first // len(width) * s.hunters + seat, LANES // len(width) * s.hunters)
        if s.prey > 0:
            write_prey(chunk, s, first, width, lanes, sections, Place(destination, begin, stride))
        if is_staged:
            copy_to_observations(
                sections.staging, min(len(width), lanes - first) * stride, out, (first_arena + first) * stride
            )


@phase
def chunk_after(chunks: NDArray[np.float64], first_arena: int) -> Rows:
    """Return the chunk that is played next, if it comes from memory and is not large; otherwise an empty one."""
    size = chunks.shape[1]
    begin = (first_arena // LANES + 1) * size
    return flat(chunks)[begin : begin + (size if len(flat(chunks)) > _CACHED and size < _LARGE else 0)]


@phase
def rank_seen(
    chunk: Rows, s: Settings, first: int, width: Width, lanes: int, orders: Orders, slots: int, sections: Sections
) -> None:
    """R7.1: rank the targets (in `orders`) and rivals (in the section) that each hunter sees, in the lanes of one
    group. One group's numbers, which are read again and again, stay in the first cache.
    """
    keys, targets, hunters = sections.keys, targets_of(chunk, s), chunk[seat_at(0) : seat_at(s.hunters)]
    for seat in range(s.hunters):
        me = seat_of(chunk, seat)
        reach_um = limits_of(sections.limits, seat).reach_um
        rank_targets(chunk, me, s, first, width, targets, slots, reach_um, keys)
        write_order(keys, slots, s.targets_seen, first, width, orders[seat])
        if s.hunters_seen > 0:
            rivals = Bodies(hunters, rows.SEAT_SIZE, s.hunters, seat, s.hunters_seen, True)
            measure_bodies(me, s, first, width, rivals, reach_um, keys)
            order_bodies(me, first, width, lanes, rivals, sections)
            write_order(keys, s.hunters, s.hunters_seen, first, width, sections.rival_orders[seat])


@phase
def observe(chunk: Rows, s: Settings, width: Width, first_arena: int, stop_arena: int, sections: Sections) -> None:
    """R7.1, R7.2: rank each hunter's view, and then write the observations and masks of a chunk, for the arenas from
    `first_arena` up to, but not including, `stop_arena`.

    The orders of the targets are kept: the next step's choices are ranks in them.
    """
    lanes, orders = stop_arena - first_arena, sections.target_orders[first_arena // LANES]
    targets = targets_of(chunk, s)
    slots = most_alive(chunk, lanes)
    for seat in range(s.hunters):
        update_heading(seat_of(chunk, seat), width)
    if s.targets_move:
        for slot in range(slots):
            update_heading(body_of(targets, s, slot), width)
    for first in range(0, lanes, len(width)):
        rank_seen(chunk, s, first, width, lanes, orders, slots, sections)
    if s.prey > 0:
        gather_prey(chunk, s, lanes, targets, sections)
    write(chunk, s, width, lanes, first_arena, orders, slots, sections)
    write_masks(chunk, s, lanes, orders, sections.masks[first_arena:stop_arena])
