"""Rulebook R7.1: order in which hunters see targets and rivals. Nearest first; then targets by spawn number, and rivals
by their appearance to the hunter.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.core import rows
from catch_arena.core.features import body_seen, body_tile
from catch_arena.core.jit import Rows, outlined, phase, rule
from catch_arena.core.memory import Sections
from catch_arena.core.state import ABSENT, MOST, Order, Settings
from catch_arena.core.vectors import LANES, Width, any_of, byte, group, select, single_bits, truncate
from catch_arena.core.visibility import is_seen

Keys = NDArray[np.int32]

_SLOTS: Final = MOST - 1
FAR: Final = 0x7F800000
"""Key of an absent or unseen target or hunter, that of an infinite distance; keys of seen ones are smaller."""


@rule
def key_of(dx: float, dy: float, item: int) -> int:
    """R7.1: return an int32 that sorts by distance and then by `item`, the slot or seat. It holds the squared distance
    as float32, whose bits sort as it does, rounded so that the last six bits have room for the item.
    """
    return ((single_bits(dx * dx + dy * dy) + 32) & ~_SLOTS) | item


@rule
def item_of(key: int) -> int:
    """Return the slot or seat in a key; ABSENT for none."""
    return select(key < FAR, key & _SLOTS, ABSENT)


@rule
def are_equally_far(nearer: int, farther: int) -> bool:
    """Return whether two keys have the same distance; `farther` must not be the smaller one."""
    return (nearer < FAR) & ((nearer & ~_SLOTS) == (farther & ~_SLOTS))


@phase
def sort_keys(keys: Keys, count: int, ranks: int, first: int, width: Width) -> None:
    """Sort the first `count` rows of keys in place, in the lanes of one group. The smallest `ranks` come first, in
    order; the others follow in any order.
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
def write_order(keys: Keys, there: int, ranks: int, first: int, width: Width, order: Order) -> None:
    """Write the order of the first keys, in the lanes of one group. If only `there` rows have keys, ABSENT follows."""
    lane = group(first, width)
    for rank in range(ranks):
        if rank < there:
            order[rank * LANES + lane] = byte(item_of(keys[rank * LANES + lane]))
        else:
            order[rank * LANES + lane] = ABSENT


@phase
def rank_targets(
    chunk: Rows,
    me: Rows,
    s: Settings,
    first: int,
    width: Width,
    targets: Rows,
    slots: int,
    reach_um: float,
    keys: Keys,
) -> None:
    """R7.1, R7.5: rank the alive targets by distance, then by spawn number; slots are in spawning order. The first rows
    of `keys` are the result.
    """
    lane = group(first, width)
    x, y, sine, cosine = me[rows.X + lane], me[rows.Y + lane], me[rows.SINE + lane], me[rows.COSINE + lane]
    alive = truncate(chunk[rows.ALIVE + lane])
    for slot in range(slots):
        at = slot * s.slot_size + lane
        dx, dy = targets[rows.TARGET_X + at] - x, targets[rows.TARGET_Y + at] - y
        there = alive > slot
        if s.partial_view:
            there = there & is_seen(dx, dy, sine, cosine, reach_um, s)
        keys[slot * LANES + lane] = select(there, key_of(dx, dy, slot), FAR)
    sort_keys(keys, slots, s.targets_seen, first, width)


NO_OBSERVER: Final = -1
"""Value in place of an index: the observer is not one of the ranked bodies."""


class Bodies(NamedTuple):
    """Bodies that a hunter or prey may see: all hunters, or all prey."""

    rows: Rows
    """Rows of all bodies, one body after the other."""
    size: int
    """Length of each body's rows."""
    total: int
    observer: int
    """Index of the observer among the bodies, or NO_OBSERVER."""
    ranks: int
    """Number of bodies that are seen."""
    are_rivals: bool
    """True if a hunter sees its rivals, which differ in catches, team and seat too."""


@phase
def body_in(bodies: Bodies, item: int) -> Rows:
    """Return the rows of one of the bodies."""
    return bodies.rows[item * bodies.size : (item + 1) * bodies.size]


@phase
def measure_bodies(
    me: Rows, s: Settings, first: int, width: Width, bodies: Bodies, reach_um: float, keys: Keys
) -> None:
    """R7.1, R7.5, R12.4: write the keys of the bodies that are seen, by index, in the lanes of one group. Withdrawn
    hunters, and prey that is out, are not seen (R1.6).
    """
    lane = group(first, width)
    x, y, sine, cosine = me[rows.X + lane], me[rows.Y + lane], me[rows.SINE + lane], me[rows.COSINE + lane]
    for item in range(bodies.total):
        at = item * bodies.size + lane
        dx, dy = bodies.rows[rows.X + at] - x, bodies.rows[rows.Y + at] - y
        seen = bodies.rows[rows.WITHDRAWN + at] == 0.0
        if bodies.are_rivals and s.partial_view:
            seen = seen & is_seen(dx, dy, sine, cosine, reach_um, s)
        keys[item * LANES + lane] = select(seen, key_of(dx, dy, item), FAR)
    if bodies.observer != NO_OBSERVER:
        keys[bodies.observer * LANES + lane] = FAR


@rule
def lead(me: Rows, one: Rows, other: Rows, lane: int) -> float:
    """R7.1, R12.4: compare two equally far bodies: the one seen further left comes first, then further forward, and so
    on. Return a number above 0 if `one` comes first, below 0 if `other` does, and 0 if they look alike.
    """
    observer = body_tile(me, 0.0, lane)
    a, b = body_seen(observer, body_tile(one, 0.0, lane)), body_seen(observer, body_tile(other, 0.0, lane))
    difference = a.linear_velocity - b.linear_velocity
    difference = select(a.heading_sin == b.heading_sin, difference, a.heading_sin - b.heading_sin)
    difference = select(a.heading_cos == b.heading_cos, difference, a.heading_cos - b.heading_cos)
    difference = select(a.forward == b.forward, difference, a.forward - b.forward)
    return select(a.left == b.left, difference, a.left - b.left)


@rule
def is_listed_first(bodies: Bodies, one: int, other: int, lane: int, teams: NDArray[np.int64]) -> bool:
    """R7.1, A.7: return whether one of two rivals who look alike comes first: the one with more catches, then a
    team-mate, then the lower seat. If the view has noise, the order by seat is visible.
    """
    catches, others_catches = body_in(bodies, one)[rows.SCORE + lane], body_in(bodies, other)[rows.SCORE + lane]
    if catches != others_catches:
        return bool(catches > others_catches)
    mate = bool(teams[one] == teams[bodies.observer])
    return one < other if mate == (teams[other] == teams[bodies.observer]) else mate


@rule
def any_tied(keys: Keys, ranks: int, lane: int) -> bool:
    """R7.1, R12.4: return for each lane whether two seen bodies, or the last one and the next, are equally far.
    The keys are sorted up to that one; there are at least two.
    """
    tied = are_equally_far(keys[lane], keys[LANES + lane])
    for rank in range(1, ranks):
        tied = tied | are_equally_far(keys[rank * LANES + lane], keys[(rank + 1) * LANES + lane])
    return tied


@phase
def gather_ties(lane: int, ranks: int, total: int, keys: Keys) -> int:
    """R7.1: gather all bodies that are as far as the last seen one, if the first beyond the view is equally far: it may
    have to come before the last one. They then follow right after it, in the place of those farther away.
    Return the number of keys, from the first on, that must be sorted.
    """
    edge = keys[ranks * LANES + lane]
    if not are_equally_far(keys[(ranks - 1) * LANES + lane], edge):
        return ranks
    count = ranks + 1
    for at in range(count, total):
        key = keys[at * LANES + lane]
        if are_equally_far(edge, key):
            keys[count * LANES + lane] = key
            count += 1
    return count


@outlined
def sort_ties(
    me: Rows, first: int, last: int, bodies: Bodies, ranks: int, teams: NDArray[np.int64], keys: Keys, tied: Rows
) -> None:
    """R7.1, R12.4: sort the keys of equally far bodies by insertion, as far as the first `ranks` need it. This is done
    in the lanes from `first` to before `last` in which `tied` is 1.
    """
    for lane in range(first, last):
        if tied[lane] == 0.0:
            continue
        for newest in range(1, gather_ties(lane, ranks, bodies.total, keys)):
            key = keys[newest * LANES + lane]
            at = newest
            while at > 0:
                before = keys[(at - 1) * LANES + lane]
                if not are_equally_far(before, key):
                    break
                one, other = item_of(key), item_of(before)
                difference = lead(me, body_in(bodies, one), body_in(bodies, other), lane)
                goes_first = difference > 0.0
                if difference == 0.0 and bodies.are_rivals:
                    goes_first = is_listed_first(bodies, one, other, lane, teams)
                if not goes_first:
                    break
                keys[at * LANES + lane] = before
                at -= 1
            keys[at * LANES + lane] = key


@phase
def order_bodies(me: Rows, first: int, width: Width, lanes: int, bodies: Bodies, sections: Sections) -> None:
    """R7.1, R12.4: sort the keys of measured bodies by distance, then by their appearance, in the lanes of one group.
    This is the order in observations; `arbiter.is_preferred` decides contests.
    """
    keys, tied, lane = sections.keys, sections.scratch_rows, group(first, width)
    # one rank more than is seen, to notice a tie at the edge of the view
    sort_keys(keys, bodies.total, bodies.ranks + 1, first, width)
    ranks = min(bodies.ranks, bodies.total - 1)
    if ranks > 0:  # one body alone has no tie
        some = any_tied(keys, ranks, lane)
        if any_of(some):
            tied[lane] = select(some, 1.0, 0.0)
            sort_ties(me, first, min(first + len(width), lanes), bodies, ranks, sections.teams, keys, tied)
