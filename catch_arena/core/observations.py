"""Rulebook chapter 7: what each hunter sees, written in the order of layout.py's table."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.features import moving_target_at, rival_at, target_at, time_left_at
from catch_arena.core.jit import Block, inlined, outlined, phase, rule
from catch_arena.core.math import sincos
from catch_arena.core.memory import Sections
from catch_arena.core.prey_views import observe_as_prey
from catch_arena.core.random import draw, seed_of
from catch_arena.core.ranking import (
    count_ranks,
    measure_rivals,
    pack_order,
    rank_targets,
    resolve_ties,
    sort_keys,
)
from catch_arena.core.state import (
    ABSENT,
    APPEARED,
    BEARING_INTEGRAL,
    COSINE,
    DISTANCE_INTEGRAL,
    LANES,
    NUMBER,
    RANKS_PER_WORD,
    SCORE,
    SEED_HIGH,
    SEED_LOW,
    SEEN,
    SINE,
    SPEED,
    STEP,
    THETA,
    TIME,
    TURN_RATE,
    Settings,
    X,
    Y,
    body_of,
    limits_of,
    most_alive,
    seat_of,
    slot_at_rank,
    slot_in_word,
    span,
    target_order_of,
    targets_of,
    word_of_rank,
)
from catch_arena.core.transfers import (
    COPIED,
    PREFETCHED,
    Place,
    copy_rank,
    prefetch,
    put_rows,
    stream_eight,
)
from catch_arena.core.vectors import Width, group, single
from catch_arena.core.visibility import RIVAL_KIND, TARGET_KIND, blur, blur_key
from catch_arena.core.workspace import FEATURE_STRIDE, Scratch, rival_order_of
from catch_arena.layout import MovingTargetFeatures, RivalFeatures, SelfFeatures, TargetFeatures, TeamRivalFeatures

Masks = NDArray[np.int8]
"""(lanes, H, K + 1)."""
Numbers = NDArray[np.float32]

SELF_WIDTH: Final = len(SelfFeatures._fields)
TARGET_WIDTH: Final = len(TargetFeatures._fields)
MOVING_TARGET_WIDTH: Final = len(MovingTargetFeatures._fields)
RIVAL_WIDTH: Final = len(RivalFeatures._fields)
TEAM_RIVAL_WIDTH: Final = len(TeamRivalFeatures._fields)

_MANY: Final = 4
"""As many hunters for each that is seen: then what is seen of them is found out one by one."""
_STREAMED: Final = 1 << 21
"""From so many numbers on, what a batch sees would push everything else out of the caches."""
_CACHED: Final = 1 << 19
"""So many numbers of state stay in the caches from one step to the next; of more, each block comes from the memory."""
_LARGE: Final = 1 << 14
"""A block of so many numbers is not asked for early: it would push out of the second cache what is being played."""


@phase
def update_heading(me: Block, width: Width) -> None:
    """The heading's sine and cosine, which the observation and the next step's controller read.

    Args:
        me: the rows of one body; SINE and COSINE are written.
        width: how many lanes a group has.
    """
    for first in range(0, span(width), len(width)):
        lane = group(first, width)
        sine, cosine = sincos(me[THETA + lane])
        me[SINE + lane] = sine
        me[COSINE + lane] = cosine


@phase
def compute_ages(block: Block, targets: Block, width: Width, slots: int, s: Settings, ages: Numbers) -> None:
    """R7.1: how long each target has been there.

    Args:
        block: the block, for its row TIME [ms].
        targets: the slots of the block.
        width: how many lanes a group has.
        slots: how many slots are in use in any lane.
        s: the settings.
        ages: the result [s], (slots * LANES,).
    """
    for slot in range(slots):
        for first in range(0, span(width), len(width)):
            lane = group(first, width)
            appeared = targets[slot * s.slot_size + APPEARED + lane]
            ages[slot * LANES + lane] = single((block[TIME + lane] - appeared) / 1000.0)


@phase
def compute_time_left(block: Block, s: Settings, width: Width, time_left: Block) -> None:
    """R7.1: until the time limit.

    Args:
        block: the block, for its row TIME [ms].
        s: the settings.
        width: how many lanes a group has.
        time_left: the result [s], one row, (LANES,).
    """
    for first in range(0, span(width), len(width)):
        lane = group(first, width)
        time_left[lane] = time_left_at(block, s, lane)


@phase
def compute_target_features(
    me: Block, targets: Block, ages: Numbers, first: int, width: Width, slots: int, s: Settings, features: Numbers
) -> None:
    """R7.1: every target as one seat sees it, in the lanes of one group, where targets are still.

    Args:
        me: the rows of the seat.
        targets: the slots of the block.
        ages: how long each has been there [s], (slots * LANES,).
        first: the first lane of the group.
        width: how many lanes the group has.
        slots: how many slots are in use in any lane.
        s: the settings.
        features: the result, the columns of `layout.TargetFeatures`: those of slot s in the group's lane l from
            features[(s * len(width) + l) * FEATURE_STRIDE] on.
    """
    lane = group(first, width)
    for slot in range(slots):
        seen = target_at(me, targets, slot * s.slot_size + lane, lane, ages[slot * LANES + lane])
        put_rows(features, slot * len(width) * FEATURE_STRIDE, FEATURE_STRIDE, seen)


@phase
def compute_moving_target_features(
    me: Block, targets: Block, ages: Numbers, first: int, width: Width, slots: int, s: Settings, features: Numbers
) -> None:
    """R7.4: the same where targets move, with the columns of `layout.MovingTargetFeatures`."""
    lane = group(first, width)
    for slot in range(slots):
        seen = moving_target_at(me, targets, slot * s.slot_size + lane, lane, ages[slot * LANES + lane])
        put_rows(features, slot * len(width) * FEATURE_STRIDE, FEATURE_STRIDE, seen)


@outlined
def blur_targets(
    block: Block, seat: int, targets: Block, order: Block, first: int, width: Width, s: Settings, features: Numbers
) -> None:
    """R7.6: the targets that one seat sees are seen some way from where they are, in the lanes of one group.

    Args:
        block: the block.
        seat: who sees.
        targets: the slots of the block.
        order: slots by rank, packed: see `state.slot_at_rank`.
        first: the first lane of the group.
        width: how many lanes the group has.
        s: the settings.
        features: as of `compute_target_features`; forward and left are written anew.
    """
    me = seat_of(block, seat)
    for lane in range(first, first + len(width)):
        key = blur_key_at(block, seat, TARGET_KIND, lane)
        for rank in range(int(me[SEEN + lane])):
            slot = slot_at_rank(order, rank, lane)
            seen = target_at(me, targets, slot * s.slot_size + lane, lane, 0.0)
            at = (slot * len(width) + lane - first) * FEATURE_STRIDE
            number = np.uint64(targets[slot * s.slot_size + NUMBER + lane])
            write_blurred(draw(key, number), seen.forward, seen.left, s, features, at)


@outlined
def blur_rivals(
    block: Block,
    seat: int,
    order: Block,
    first: int,
    width: Width,
    s: Settings,
    teams: NDArray[np.int64],
    features: Numbers,
) -> None:
    """R7.6: and the rivals.

    Args:
        block: the block.
        seat: who sees.
        order: seats by rank, packed: see `state.slot_at_rank`.
        first: the first lane of the group.
        width: how many lanes the group has.
        s: the settings.
        teams: see `memory.Sections`.
        features: as of `compute_rival_features`; forward and left are written anew.
    """
    for lane in range(first, first + len(width)):
        key = blur_key_at(block, seat, RIVAL_KIND, lane)
        for rank in range(s.hunters_seen):
            other = slot_at_rank(order, rank, lane)
            if other != ABSENT:
                seen = rival_at(block, seat, other, lane, teams)
                at = (other * len(width) + lane - first) * FEATURE_STRIDE
                write_blurred(draw(key, np.uint64(other)), seen.forward, seen.left, s, features, at)


@phase
def compute_rival_features(
    block: Block, seat: int, first: int, width: Width, s: Settings, teams: NDArray[np.int64], features: Numbers
) -> None:
    """R7.1: every rival as one seat sees it, in the lanes of one group.

    Args:
        block: the block.
        seat: who sees.
        first: the first lane of the group.
        width: how many lanes the group has.
        s: the settings.
        teams: see `memory.Sections`.
        features: the result, the columns of `layout.TeamRivalFeatures`: those of seat r in the group's lane l from
            features[(r * len(width) + l) * FEATURE_STRIDE] on.
    """
    for other in range(s.hunters):
        if other != seat:
            seen = rival_at(block, seat, other, group(first, width), teams)
            put_rows(features, other * len(width) * FEATURE_STRIDE, FEATURE_STRIDE, seen)


@rule
def blur_key_at(block: Block, seat: int, kind: np.uint64, lane: int) -> np.uint64:
    """R7.6: `visibility.blur_key` of what a seat sees of one kind in one lane."""
    return blur_key(seed_of(block[SEED_HIGH + lane], block[SEED_LOW + lane]), block[STEP + lane], seat, kind)


@phase
def write_blurred(key: np.uint64, forward: float, left: float, s: Settings, out: Numbers, at: int) -> None:
    """R7.6: where one thing is seen that is so far ahead and to the left [m]: two columns from out[at] on.

    Args:
        key: `visibility.blur_key`'s stream of what is seen.
        forward: how far ahead it is [m].
        left: how far to the left [m].
        s: the settings.
        out: features or observations, flat.
        at: where in `out` the two columns begin.
    """
    out[at] = np.float32(forward + blur(key, 0, s.view_noise_m))
    out[at + 1] = np.float32(left + blur(key, 1, s.view_noise_m))


@phase
def write_self(me: Block, time_left: Block, first: int, width: Width, place: Place) -> None:
    """R7.1: what a hunter knows of itself, in the lanes of one group.

    Args:
        me: the rows of its seat.
        time_left: until the time limit [s], one row, (LANES,).
        first: the first lane of the group.
        width: how many lanes the group has.
        place: see `transfers.Place`; the columns of `layout.SelfFeatures` are written.
    """
    lane = group(first, width)
    seen = SelfFeatures(
        x=me[X + lane],
        y=me[Y + lane],
        heading_cos=me[COSINE + lane],
        heading_sin=me[SINE + lane],
        linear_velocity=me[SPEED + lane],
        angular_velocity=me[TURN_RATE + lane],
        time_left=time_left[lane],
        score=me[SCORE + lane],
        distance_integral=me[DISTANCE_INTEGRAL + lane],
        bearing_integral=me[BEARING_INTEGRAL + lane],
    )
    put_rows(place.out, place.at, place.stride, seen)


@phase
def write_ranked(
    order: Block,
    ranks: int,
    exactly: bool,
    lane: int,
    features: Numbers,
    width: Width,
    columns: int,
    out: Numbers,
    at: int,
) -> None:
    """R7.1: the features of one lane's targets or rivals, in the order of their ranks.

    What is copied of one rank too much is written over by the next one.

    Args:
        order: slots or seats by rank, packed: see `state.slot_at_rank`.
        ranks: how many ranks are seen.
        exactly: whether the last one is copied only so far as it goes, since nothing is written behind it.
        lane: the lane.
        features: of every slot or seat: see `compute_target_features`.
        width: how many lanes the group has in which they were computed.
        columns: how many columns there are of each, as the compiler knows.
        out: observations, flat.
        at: where in `out` the columns of rank 1 begin.
    """
    mine = lane % len(width)
    copied = ranks - 1 if exactly else ranks
    rank = 0
    while rank + RANKS_PER_WORD <= copied:
        word = word_of_rank(order, rank, lane)
        for next_rank in range(RANKS_PER_WORD):  # as often as the compiler knows: eight ranks without a loop
            source = (slot_in_word(word, next_rank) * len(width) + mine) * FEATURE_STRIDE
            copy_rank(out, at + next_rank * columns, features, source, columns, False)
        at += RANKS_PER_WORD * columns
        rank += RANKS_PER_WORD
    while rank < copied:
        source = (slot_at_rank(order, rank, lane) * len(width) + mine) * FEATURE_STRIDE
        copy_rank(out, at, features, source, columns, False)
        at += columns
        rank += 1
    if rank < ranks:
        source = (slot_at_rank(order, rank, lane) * len(width) + mine) * FEATURE_STRIDE
        copy_rank(out, at, features, source, columns, True)


@phase
def write_rivals(
    block: Block,
    seat: int,
    order: Block,
    ranks: int,
    lane: int,
    s: Settings,
    teams: NDArray[np.int64],
    out: Numbers,
    at: int,
) -> None:
    """R7.1: the rivals of one lane, each looked at when its rank is written: for a few of very many, of whom it would
    take longer to compute all features.

    Args:
        block: the block.
        seat: who sees.
        order: seats by rank, packed: see `state.slot_at_rank`.
        ranks: how many ranks are seen.
        lane: the lane.
        s: the settings.
        teams: see `memory.Sections`.
        out: observations, flat.
        at: where in `out` the columns of rank 1 begin.
    """
    columns = rival_width(s)
    for rank in range(ranks):
        other = slot_at_rank(order, rank, lane)
        if other == ABSENT:
            for column in range(columns):
                out[at + column] = 0.0
        else:
            seen = rival_at(block, seat, other, lane, teams)
            if s.has_teams:
                put_rows(out, at, columns, seen)
            else:
                put_rows(out, at, columns, seen[:RIVAL_WIDTH])
            if s.view_noise_m > 0.0:
                key = draw(blur_key_at(block, seat, RIVAL_KIND, lane), np.uint64(other))
                write_blurred(key, seen.forward, seen.left, s, out, at)
        at += columns


@rule
def target_width(s: Settings) -> int:
    """R7.4: how many columns there are of each target."""
    return MOVING_TARGET_WIDTH if s.targets_move else TARGET_WIDTH


@rule
def rival_width(s: Settings) -> int:
    """R7.4: how many columns there are of each rival."""
    return TEAM_RIVAL_WIDTH if s.has_teams else RIVAL_WIDTH


@phase
def write_masks(block: Block, s: Settings, lanes: int, masks: Masks) -> None:
    """R7.2: hold and the ranks that have a target. They change rarely, and where all see everything for all seats of an
    arena.

    Args:
        block: the block.
        s: the settings.
        lanes: how many of its lanes are arenas.
        masks: the result, (lanes, H, K + 1).
    """
    ranks = s.targets_seen
    for lane in range(lanes):
        seat = 0
        while seat < s.hunters:
            there = int(seat_of(block, seat)[SEEN + lane])
            if masks[lane, seat, there] == 0 or (there < ranks and masks[lane, seat, there + 1] == 1):
                for rank in range(ranks + 1):
                    masks[lane, seat, rank] = 1 if rank <= there else 0
            elif not s.partial_view:
                break
            seat += 1


@phase
def copy_to_observations(staging: Numbers, count: int, out: Numbers, at: int) -> None:
    """Observations that were put together apart from where they belong; they go past the caches.

    Args:
        staging: the observations of a group of lanes.
        count: how many numbers they are.
        out: observations, flat.
        at: where in `out` they belong.
    """
    whole = count - count % COPIED
    for offset in range(0, whole, COPIED):
        stream_eight(out, at + offset, staging, offset)
    for offset in range(whole, count):
        out[at + offset] = staging[offset]


@phase
def write_seat(
    block: Block,
    seat: int,
    s: Settings,
    first: int,
    width: Width,
    slots: int,
    teams: NDArray[np.int64],
    scratch: Scratch,
    place: Place,
) -> None:
    """R7.1: the observations of one seat, in the lanes of one group.

    Args:
        block: the block.
        seat: who sees.
        s: the settings.
        first: the first lane of the group.
        width: how many lanes the group has.
        slots: how many slots are in use in any lane.
        teams: see `memory.Sections`.
        scratch: see `workspace.Scratch`; ages, the time left (its first row) and the rivals' orders are read.
        place: see `transfers.Place`.
    """
    me, targets = seat_of(block, seat), targets_of(block, s)
    targets_in_order, rivals_in_order = target_order_of(block, seat, s), rival_order_of(scratch, seat)
    ages, features, rivals = scratch.ages, scratch.target_features, scratch.rival_features
    few_of_many = s.hunters > _MANY * s.hunters_seen
    write_self(me, scratch.rows, first, width, place)
    if s.targets_move:
        compute_moving_target_features(me, targets, ages, first, width, slots, s, features)
    else:
        compute_target_features(me, targets, ages, first, width, slots, s, features)
    if not few_of_many:
        compute_rival_features(block, seat, first, width, s, teams, rivals)
    if s.view_noise_m > 0.0:
        blur_targets(block, seat, targets, targets_in_order, first, width, s, features)
        if not few_of_many:
            blur_rivals(block, seat, rivals_in_order, first, width, s, teams, rivals)
    alone = s.hunters_seen == 0
    for lane in range(first, first + len(width)):
        out, at = place.out, place.at + (lane - first) * place.stride + SELF_WIDTH
        # a call for each width, so that the compiler knows it
        if s.targets_move:
            write_ranked(targets_in_order, s.targets_seen, alone, lane, features, width, MOVING_TARGET_WIDTH, out, at)
        else:
            write_ranked(targets_in_order, s.targets_seen, alone, lane, features, width, TARGET_WIDTH, out, at)
        at += s.targets_seen * target_width(s)
        if few_of_many:
            write_rivals(block, seat, rivals_in_order, s.hunters_seen, lane, s, teams, out, at)
        elif s.has_teams:
            write_ranked(rivals_in_order, s.hunters_seen, True, lane, rivals, width, TEAM_RIVAL_WIDTH, out, at)
        else:
            write_ranked(rivals_in_order, s.hunters_seen, True, lane, rivals, width, RIVAL_WIDTH, out, at)


@phase
def prefetch_part(ahead: Block, part: int, parts: int) -> None:
    """Ask for one of as many parts of what is played next. All at once would make this block wait too.

    Args:
        ahead: the next block; or nothing.
        part: which one, from 0.
        parts: how many there are.
    """
    for at in range(len(ahead) * part // parts, len(ahead) * (part + 1) // parts, PREFETCHED):
        prefetch(ahead, at)


@inlined
def write(
    block: Block,
    s: Settings,
    width: Width,
    lanes: int,
    slots: int,
    teams: NDArray[np.int64],
    scratch: Scratch,
    out: Numbers,
    arena: int,
    ahead: Block,
) -> None:
    """R7.1: the observations of a block, one group of lanes after the other.

    They are written at once, unless the group has lanes that are no arenas, or the batch is so large that they
    had better go past the caches, in the order of the memory.

    Args:
        block: the block.
        s: the settings.
        width: how many lanes a group has.
        lanes: how many of its lanes are arenas.
        slots: how many slots are in use in any lane.
        teams: see `memory.Sections`.
        scratch: see `workspace.Scratch`.
        out: the observations of the whole batch, flat.
        arena: which of the batch is the first lane.
        ahead: see `prefetch_part`.
    """
    compute_ages(block, targets_of(block, s), width, slots, s, scratch.ages)
    compute_time_left(block, s, width, scratch.rows)
    columns = SELF_WIDTH + s.targets_seen * target_width(s) + s.hunters_seen * rival_width(s)
    stride = s.hunters * columns
    for first in range(0, span(width), len(width)):
        if first >= lanes:
            break
        apart = lanes - first < len(width) or len(out) > _STREAMED
        to = scratch.staging if apart else out
        begin = 0 if apart else (arena + first) * stride
        for seat in range(s.hunters):
            write_seat(block, seat, s, first, width, slots, teams, scratch, Place(to, begin + seat * columns, stride))
            prefetch_part(ahead, first // len(width) * s.hunters + seat, LANES // len(width) * s.hunters)
        if apart:
            copy_to_observations(
                scratch.staging, min(len(width), lanes - first) * stride, out, (arena + first) * stride
            )


@inlined
def block_after(blocks: NDArray[np.float64], first: int) -> Block:
    """The block that is played next, if it has to come from the memory and is not large; or nothing.

    Args:
        blocks: see `memory.Sections`.
        first: the first arena of the block that is played.
    """
    after = first // LANES + 1
    return blocks[after : after + (1 if blocks.size > _CACHED and blocks.shape[1] < _LARGE else 0)].reshape(-1)


@inlined
def observe(
    block: Block, s: Settings, width: Width, first: int, last: int, sections: Sections, scratch: Scratch
) -> None:
    """R7.1, R7.2: who sees whom in which order, and then the observations and masks of a block: of the arenas from
    `first` up to, but not including, `last`.

    The order of the targets stays in the arena: the next step's choices are ranks in it.

    Args:
        block: the block.
        s: the settings.
        width: how many lanes a group has.
        first: the first arena of the block.
        last: the arena behind its last.
        sections: see `memory.Sections`.
        scratch: see `workspace.Scratch`.
    """
    lanes = last - first
    targets = targets_of(block, s)
    slots = most_alive(block, lanes)
    for seat in range(s.hunters):
        update_heading(seat_of(block, seat), width)
    if s.targets_move:
        for slot in range(slots):
            update_heading(body_of(targets, slot, s), width)
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        reach_limit_m2 = limits_of(sections.limits, seat).reach_limit_m2
        rank_targets(block, me, targets, width, slots, sections.target_network, s, reach_limit_m2, scratch.keys)
        pack_order(scratch.keys, slots, s.targets_seen, width, target_order_of(block, seat, s))
        if s.hunters_seen > 0:
            order = rival_order_of(scratch, seat)
            measure_rivals(block, seat, width, s, reach_limit_m2, scratch.keys)
            if s.hunters <= RANKS_PER_WORD:
                count_ranks(block, seat, width, s, sections.teams, scratch.keys, scratch.rows, order)
            else:
                sort_keys(scratch.keys, sections.rival_network, width, s.hunters)
                resolve_ties(block, seat, width, lanes, s, sections.teams, scratch.keys)
                pack_order(scratch.keys, s.hunters, s.hunters_seen, width, order)
    observations, ahead = sections.observations.reshape(-1), block_after(sections.blocks, first)
    write(block, s, width, lanes, slots, sections.teams, scratch, observations, first, ahead)
    write_masks(block, s, lanes, sections.masks[first:last])
    if s.prey > 0:
        observe_as_prey(block, s, width, first, lanes, sections, scratch)
