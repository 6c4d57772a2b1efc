"""Rulebook R12.4: prey's view of itself, of the hunters and of other prey, in the order of layout.py's table.

Prey's bodies lie in slots that differ by lane. They are gathered first, with rows like a seat's, so that the same code
observes hunters and prey.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.core.addresses import flat
from catch_arena.core.features import body_seen, observer_of, time_left_at
from catch_arena.core.jit import Rows, outlined, phase
from catch_arena.core.memory import Sections
from catch_arena.core.ranking import (
    FAR,
    item_of,
    key_of,
    resolve_ties,
    sort_keys,
)
from catch_arena.core.state import (
    ABSENT,
    BODY,
    BODY_ROWS,
    COSINE,
    LANES,
    NO_TARGET,
    PREY_SLOT,
    SEAT_SIZE,
    SINE,
    SPEED,
    TIMES_CAUGHT,
    TURN_RATE,
    WITHDRAWN,
    Settings,
    X,
    Y,
    prey_of,
    seat_at,
    targets_of,
)
from catch_arena.core.tiles import body_of_tile, body_tile, put_rank, put_tile, tile_index
from catch_arena.core.transfers import Place, put_rows, take_tile
from catch_arena.core.vectors import Width, group, long, select
from catch_arena.layout import MOST_SEEN_BY_PREY, BodyFeatures, PreySelfFeatures

Numbers = NDArray[np.float32]

_SELF_WIDTH: Final = len(PreySelfFeatures._fields)
_BODY_WIDTH: Final = len(BodyFeatures._fields)
_NO_OBSERVER: Final = -1
"""Value in place of an index: the observer is not one of the ranked bodies."""


@outlined
def gather_prey(chunk: Rows, s: Settings, lanes: int, targets: Rows, sections: Sections) -> None:
    """Gather the bodies of all prey from their slots. Prey that is out has zeros, and is hidden like a withdrawn
    hunter.
    """
    for index in range(s.prey):
        me, gathered = prey_of(chunk, s, index), sections.gathered_prey[index]
        for lane in range(lanes):
            slot = int(me[PREY_SLOT + lane])
            gathered[WITHDRAWN + lane] = 1.0 if slot == NO_TARGET else 0.0
            at = max(slot, 0) * s.slot_size + BODY + lane
            for row in range(0, BODY_ROWS * LANES, LANES):
                gathered[row + lane] = 0.0 if slot == NO_TARGET else targets[at + row]


class Bodies(NamedTuple):
    """Bodies that one prey may see: all hunters, or all prey."""

    rows: Rows
    """Rows of all bodies, one body after the other."""
    size: int
    """Length of each body's rows."""
    total: int
    observer_index: int
    """Index of the observer among the bodies, or _NO_OBSERVER."""
    ranks: int
    """Number of bodies that are seen."""
    first_column: int
    """First column of rank 1, in the observation of one prey."""
    is_last: bool
    """True if the last rank has the last columns of the observation: see `tiles.put_rank`."""


@phase
def bodies_of(chunk: Rows, s: Settings, index: int, of_hunters: bool, gathered_prey: Rows) -> Bodies:
    """R12.4: return the hunters, or the prey, as bodies that one prey may see."""
    hunters_seen, prey_seen = min(s.hunters, MOST_SEEN_BY_PREY), min(s.prey - 1, MOST_SEEN_BY_PREY)
    is_last = not of_hunters or prey_seen == 0
    return Bodies(
        rows=chunk[seat_at(0) : seat_at(s.hunters)] if of_hunters else gathered_prey,
        size=SEAT_SIZE if of_hunters else WITHDRAWN + LANES,
        total=s.hunters if of_hunters else s.prey,
        observer_index=_NO_OBSERVER if of_hunters else index,
        ranks=hunters_seen if of_hunters else prey_seen,
        first_column=_SELF_WIDTH + (0 if of_hunters else hunters_seen * _BODY_WIDTH),
        is_last=is_last,
    )


@phase
def body_in(bodies: Bodies, item: int) -> Rows:
    """Return the rows of one of the bodies."""
    return bodies.rows[item * bodies.size : (item + 1) * bodies.size]


@phase
def rank_bodies(me: Rows, first: int, width: Width, lanes: int, bodies: Bodies, sections: Sections) -> None:
    """R12.4: rank bodies by distance, then in R7.1's order of rivals, in the lanes of one group.

    Args:
        sections: see `memory.Sections`; its keys are the result, those of the nearest in the first rows, in order.
    """
    keys, lane = sections.keys, group(first, width)
    for item in range(bodies.total):
        other = body_in(bodies, item)
        key = key_of(other[X + lane] - me[X + lane], other[Y + lane] - me[Y + lane], item)
        unseen = (other[WITHDRAWN + lane] > 0.0) | (me[WITHDRAWN + lane] > 0.0) | (item == bodies.observer_index)
        keys[item * LANES + lane] = select(unseen, FAR, key)
    sort_keys(keys, bodies.total, bodies.ranks + 1, first, width)
    last, total, teams, tied = min(bodies.ranks, bodies.total - 1), bodies.total, sections.teams, sections.scratch_rows
    if last > 0:  # one body alone has no tie
        myself, rows, size = bodies.observer_index, bodies.rows, bodies.size
        resolve_ties(me, first, width, lanes, myself, rows, size, total, last, teams, False, keys, tied)


@phase
def write_bodies(me: Rows, first: int, width: Width, bodies: Bodies, sections: Sections, place: Place) -> None:
    """R12.4: write one prey's view of bodies, in the lanes of one group.

    Args:
        sections: see `memory.Sections`; its keys are the result of `rank_bodies`.
    """
    lane = group(first, width)
    observer = observer_of(me, lane)
    for item in range(bodies.total):
        put_tile(sections.body_tiles, item, width, body_tile(body_in(bodies, item), 0.0, lane))
    for rank in range(bodies.ranks):
        items = long(item_of(sections.keys[rank * LANES + lane]))
        present = items != ABSENT
        tile = take_tile(sections.body_tiles, tile_index(items, width))
        at = place.at + bodies.first_column + rank * _BODY_WIDTH
        is_last = bodies.is_last and rank == bodies.ranks - 1
        seen = body_seen(observer, body_of_tile(tile))
        put_rank(Place(place.out, at, place.stride), present, seen, is_last)


@phase
def write_self(chunk: Rows, me: Rows, s: Settings, first: int, width: Width, caught: Rows, place: Place) -> None:
    """R12.4: write one prey's view of itself, in the lanes of one group.

    Args:
        caught: number of times it was caught, one row.
    """
    lane = group(first, width)
    own = PreySelfFeatures(
        x=me[X + lane],
        y=me[Y + lane],
        heading_cos=me[COSINE + lane],
        heading_sin=me[SINE + lane],
        linear_velocity=me[SPEED + lane],
        angular_velocity=me[TURN_RATE + lane],
        time_left=time_left_at(chunk, s, lane),
        times_caught=caught[lane],
        alive=1.0 - me[WITHDRAWN + lane],
    )
    put_rows(place.out, place.at, place.stride, own)


@phase
def copy_lanes(staging: Numbers, start: int, columns: int, lanes: int, stride: int, out: Numbers, at: int) -> None:
    """Copy observations from the staging section: their group has lanes without an arena.

    Args:
        start: offset of the first lane's observation in `staging`.
        at: offset of the first lane's observation in `out`.
    """
    for lane in range(lanes):
        for column in range(columns):
            out[at + lane * stride + column] = staging[start + lane * stride + column]


@outlined
def observe_as_prey(chunk: Rows, s: Settings, width: Width, lanes: int, first_arena: int, sections: Sections) -> None:
    """R12.4, R12.3: write the observations of all prey of a chunk.

    Args:
        sections: see `memory.Sections`; prey's rows of `observations` are the result.
    """
    gather_prey(chunk, s, lanes, targets_of(chunk, s), sections)
    out = flat(sections.observations)
    columns = sections.observations.shape[2]
    stride = sections.observations.shape[1] * columns
    for index in range(s.prey):
        me, caught = sections.gathered_prey[index], prey_of(chunk, s, index)[TIMES_CAUGHT : TIMES_CAUGHT + LANES]
        for side in range(2):  # a loop, so that the functions it calls are compiled once
            of_hunters = side == 0
            bodies = bodies_of(chunk, s, index, of_hunters, flat(sections.gathered_prey))
            if bodies.ranks == 0:
                continue
            for first in range(0, lanes, len(width)):
                rank_bodies(me, first, width, lanes, bodies, sections)
                is_staged = lanes - first < len(width)
                staged = (s.hunters + index) * columns
                begin = (first_arena + first) * stride + staged
                place = Place(sections.staging if is_staged else out, staged if is_staged else begin, stride)
                if of_hunters:
                    write_self(chunk, me, s, first, width, caught, place)
                write_bodies(me, first, width, bodies, sections, place)
                if is_staged:
                    written = bodies.first_column + bodies.ranks * _BODY_WIDTH
                    copy_lanes(sections.staging, staged, written, lanes - first, stride, out, begin)
