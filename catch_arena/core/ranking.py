"""Rulebook R7.1: who sees whom in which order. Nearest first; then targets by spawn number, and rivals by how they are
seen.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.features import body_seen, observer_of
from catch_arena.core.jit import Block, outlined, phase, rule
from catch_arena.core.state import (
    ABSENT,
    ALIVE,
    COSINE,
    LANES,
    MOST,
    RANK_BITS,
    RANKS_PER_WORD,
    SCORE,
    SINE,
    SPEED,
    TARGET_X,
    TARGET_Y,
    WITHDRAWN,
    Settings,
    X,
    Y,
    seat_of,
)
from catch_arena.core.tiles import body_tile
from catch_arena.core.vectors import Width, any_of, group, long, number_of, select, single_bits, truncate
from catch_arena.core.visibility import is_seen

Keys = NDArray[np.int32]

_SLOTS: Final = MOST - 1
FAR: Final = 0x7F800000
"""The key of what is not there, that of an infinite distance: no key from it on is of something that is seen."""


@rule
def key_of(dx: float, dy: float, item: int) -> int:
    """R7.1: an int32 that sorts by distance and then by slot or seat: the squared distance as float32, whose bits sort
    as it does, rounded to where the last six of them have room for `item`.

    Args:
        dx: east of the observer [m].
        dy: north of it [m].
        item: the slot or seat, below MOST.
    """
    return ((single_bits(dx * dx + dy * dy) + 32) & ~_SLOTS) | item


@rule
def item_of(key: int) -> int:
    """The slot or seat in a key."""
    return select(key < FAR, key & _SLOTS, ABSENT)


@rule
def equally_far(nearer: int, farther: int) -> bool:
    """Whether two keys, the second of which is not smaller, have the same distance."""
    return (nearer < FAR) & ((nearer & ~_SLOTS) == (farther & ~_SLOTS))


@phase
def sort_keys(keys: Keys, count: int, ranks: int, first: int, width: Width) -> None:
    """Sort the keys of every lane of a group as far as somebody reads them.

    Args:
        keys: by slot or seat, rows of LANES; sorted in place, the smallest first.
        count: how many rows have keys.
        ranks: how many of the smallest are wanted in order; the others follow in any.
    """
    lane = group(first, width)
    for rank in range(min(ranks, count)):
        least = keys[rank * LANES + lane]
        for row in range(rank + 1, count):
            key = keys[row * LANES + lane]
            smaller = key < least
            keys[row * LANES + lane] = select(smaller, least, key)
            least = select(smaller, key, least)
        keys[rank * LANES + lane] = least


@phase
def pack_order(keys: Keys, there: int, ranks: int, first: int, width: Width, packed: Block) -> None:
    """The slots or seats of the first keys, packed as `state.slot_at_rank` reads them.

    Args:
        keys: sorted as far as they are read: rows of LANES.
        there: how many rows have keys.
        ranks: how many ranks are wanted.
        packed: the result, rows of LANES, RANKS_PER_WORD ranks in each.
    """
    lane = group(first, width)
    for rank in range(0, ranks, RANKS_PER_WORD):
        word = long(keys[lane] & 0)  # 0 in each lane
        for next_rank in range(RANKS_PER_WORD):
            if rank + next_rank < min(there, ranks):
                item = long(item_of(keys[(rank + next_rank) * LANES + lane]))
                word = word | (item << (RANK_BITS * next_rank))
            else:
                word = word | (ABSENT << (RANK_BITS * next_rank))
        packed[rank // RANKS_PER_WORD * LANES + lane] = number_of(word)


@phase
def rank_targets(
    block: Block,
    me: Block,
    targets: Block,
    first: int,
    width: Width,
    slots: int,
    s: Settings,
    reach_limit_m2: float,
    keys: Keys,
) -> None:
    """R7.1, R7.5: the alive targets by distance, then by spawn number; slots are in spawning order.

    Args:
        block: the block, for its row ALIVE.
        me: the rows of the seat that sees them.
        slots: how many slots are in use in any lane.
        keys: the result, rows of LANES: the keys of the nearest in the first rows, in order.
    """
    lane = group(first, width)
    x, y, sine, cosine = me[X + lane], me[Y + lane], me[SINE + lane], me[COSINE + lane]
    alive = truncate(block[ALIVE + lane])
    for slot in range(slots):
        at = slot * s.slot_size + lane
        dx, dy = targets[TARGET_X + at] - x, targets[TARGET_Y + at] - y
        there = alive > slot
        if s.partial_view:
            there = there & is_seen(dx, dy, sine, cosine, reach_limit_m2, s)
        keys[slot * LANES + lane] = select(there, key_of(dx, dy, slot), FAR)
    sort_keys(keys, slots, s.targets_seen, first, width)


@phase
def note_positions(block: Block, first: int, width: Width, s: Settings, positions: Block) -> None:
    """Where all hunters are, side by side for those who look, in the lanes of one group; who has withdrawn is seen by
    nobody (R1.6): infinitely far.

    Args:
        positions: the result [m]: x and y by seat, each as many numbers as the group has lanes.
    """
    lane = group(first, width)
    for seat in range(s.hunters):
        me = seat_of(block, seat)
        at = 2 * seat * len(width) + group(0, width)
        positions[at] = select(me[WITHDRAWN + lane] > 0.0, np.inf, me[X + lane])
        positions[len(width) + at] = me[Y + lane]


@phase
def measure_rivals(
    block: Block, seat: int, first: int, width: Width, s: Settings, reach_limit_m2: float, positions: Block, keys: Keys
) -> None:
    """R7.1, R7.5: how far the other hunters are, of those who are seen, in the lanes of one group.

    Args:
        positions: see `note_positions`.
        keys: the result, by seat, rows of LANES.
    """
    me, lane = seat_of(block, seat), group(first, width)
    x, y, sine, cosine = me[X + lane], me[Y + lane], me[SINE + lane], me[COSINE + lane]
    for other in range(s.hunters):
        at = 2 * other * len(width) + group(0, width)
        dx, dy = positions[at] - x, positions[len(width) + at] - y
        key = key_of(dx, dy, other)
        if s.partial_view:
            key = select(is_seen(dx, dy, sine, cosine, reach_limit_m2, s), key, FAR)
        keys[other * LANES + lane] = key
    keys[seat * LANES + lane] = FAR


@rule
def lead(me: Block, one: Block, other: Block, lane: int) -> float:
    """R7.1, R12.4: of two bodies equally far, the one seen further left comes first, then further forward, and so on.

    Args:
        one: the rows of a body that it sees.
        other: and of another.

    Returns:
        a number above 0 where `one` comes first, below 0 where `other` does, and 0 where they look alike.
    """
    observer = observer_of(me, lane)
    a, b = body_seen(observer, body_tile(one, 0.0, lane)), body_seen(observer, body_tile(other, 0.0, lane))
    difference = a.linear_velocity - b.linear_velocity
    difference = select(a.heading_sin == b.heading_sin, difference, a.heading_sin - b.heading_sin)
    difference = select(a.heading_cos == b.heading_cos, difference, a.heading_cos - b.heading_cos)
    difference = select(a.forward == b.forward, difference, a.forward - b.forward)
    return select(a.left == b.left, difference, a.left - b.left)


@rule
def is_listed_first(seat: int, one: int, other: int, teams: NDArray[np.int64]) -> bool:
    """R7.1, A.7: of two rivals who look alike, a team-mate comes first; then the seat tells them apart, which shows
    where the view has noise.

    Args:
        one: the seat of a rival.
        other: and of another.
    """
    mate = bool(teams[one] == teams[seat])
    return one < other if mate == (teams[other] == teams[seat]) else mate


@rule
def has_more_catches(one: Block, other: Block, lane: int, listed_first: bool) -> bool:
    """R7.1: of two rivals who look alike, the one with more catches comes first, then who `is_listed_first`; arguments
    as of `precedes`.
    """
    catches, others_catches = one[SCORE + lane], other[SCORE + lane]
    more: bool = select(catches == others_catches, listed_first, catches > others_catches)
    return more


@rule
def precedes(me: Block, one: Block, other: Block, lane: int, listed_first: bool) -> bool:
    """R7.1: of two rivals equally far, the one that `lead`s, then the one that `has_more_catches`.

    Args:
        one: the rows of a rival that it sees.
        other: and of another.
        listed_first: whether `one` comes first where nothing else tells them apart.
    """
    first = lead(me, one, other, lane)
    return select(first == 0.0, has_more_catches(one, other, lane, listed_first), first > 0.0)


@rule
def stand_together(one: Block, other: Block, lane: int) -> bool:
    """Whether two bodies are in one place and move alike: then they look alike, whoever looks."""
    in_one_place = (one[X + lane] == other[X + lane]) & (one[Y + lane] == other[Y + lane])
    head_alike = (one[SINE + lane] == other[SINE + lane]) & (one[COSINE + lane] == other[COSINE + lane])
    together: bool = in_one_place & head_alike & (one[SPEED + lane] == other[SPEED + lane])
    return together


@rule
def some_tied(keys: Keys, ranks: int, lane: int) -> bool:
    """R7.1, R12.4: in which lanes two that are seen, or the last one and the next, are equally far.

    Args:
        keys: sorted by distance as far as one beyond `ranks`, two rows of LANES at least.
        ranks: how many are seen.
    """
    tied = equally_far(keys[lane], keys[LANES + lane])
    for rank in range(1, ranks):
        tied = tied | equally_far(keys[rank * LANES + lane], keys[(rank + 1) * LANES + lane])
    return tied


@phase
def gather_ties(lane: int, ranks: int, total: int, keys: Keys) -> int:
    """R7.1: where the first rival beyond the view is as far as the last one that is seen, it may have to come before
    it. Then all others who are as far come right after it, in the place of those farther away.

    Args:
        ranks: how many rivals are seen, at least one; the next one is the first beyond the view.
        total: how many bodies there are.
        keys: as `sort_keys` leaves them, rows of LANES.

    Returns:
        how many keys, from the first on, have to be put in order.
    """
    edge = keys[ranks * LANES + lane]
    if not equally_far(keys[(ranks - 1) * LANES + lane], edge):
        return ranks
    count = ranks + 1
    for at in range(count, total):
        key = keys[at * LANES + lane]
        if equally_far(edge, key):
            keys[count * LANES + lane] = key
            count += 1
    return count


@outlined
def sort_ties(
    block: Block,
    seat: int,
    first: int,
    last: int,
    s: Settings,
    ranks: int,
    teams: NDArray[np.int64],
    keys: Keys,
    tied: Block,
) -> None:
    """R7.1: in each lane the sorted rivals who are equally far are put in order among themselves, by insertion.

    Args:
        first: the first lane.
        last: the lane behind the last.
        ranks: see `some_tied`.
        keys: sorted by distance, rows of LANES.
        tied: one row, flags: see `some_tied`.
    """
    me = seat_of(block, seat)
    for lane in range(first, last):
        if tied[lane] == 0.0:
            continue
        for newest in range(1, gather_ties(lane, ranks, s.hunters, keys)):
            key = keys[newest * LANES + lane]
            at = newest
            while at > 0:
                before = keys[(at - 1) * LANES + lane]
                if not equally_far(before, key):
                    break
                one, other = item_of(key), item_of(before)
                newer, older = seat_of(block, one), seat_of(block, other)
                listed_first = is_listed_first(seat, one, other, teams)
                if stand_together(newer, older, lane):  # as most who are tied do, late in an episode
                    ahead = has_more_catches(newer, older, lane, listed_first)
                else:
                    ahead = precedes(me, newer, older, lane, listed_first)
                if not ahead:
                    break
                keys[at * LANES + lane] = before
                at -= 1
            keys[at * LANES + lane] = key


@phase
def resolve_ties(
    block: Block,
    seat: int,
    first: int,
    width: Width,
    lanes: int,
    s: Settings,
    teams: NDArray[np.int64],
    keys: Keys,
    tied: Block,
) -> None:
    """R7.1: lanes in which two rivals that are seen, or the last one and the next, are equally far. This is the order
    in which they are listed; who wins a target is `arbiter.is_preferred`.

    Args:
        keys: sorted by distance, rows of LANES; put right in place.
        tied: room for one row.
    """
    ranks = min(s.hunters_seen, s.hunters - 2)
    lane = group(first, width)
    some = some_tied(keys, ranks, lane)
    if any_of(some):
        tied[lane] = select(some, 1.0, 0.0)
        sort_ties(block, seat, first, min(first + len(width), lanes), s, ranks, teams, keys, tied)
