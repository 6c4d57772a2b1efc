"""Rulebook R12.4: prey's view of itself, of the hunters and of other prey, in the order of layout.py's table.

Prey's bodies lie in slots that differ by lane. They are gathered first, with rows like a seat's, so that the same code
observes hunters and prey.
"""

from typing import Final

from catch_arena.core import rows
from catch_arena.core.addresses import flat
from catch_arena.core.features import body_of_tile, body_seen, body_tile, put_rank, put_tile, time_left_at
from catch_arena.core.jit import Rows, outlined, phase
from catch_arena.core.memory import Sections
from catch_arena.core.ranking import NO_OBSERVER, Bodies, body_in, item_of, measure_bodies, order_bodies
from catch_arena.core.state import ABSENT, Settings, prey_of, seat_at
from catch_arena.core.transfers import Place, put_rows, take_tile
from catch_arena.core.vectors import LANES, Width, group, long
from catch_arena.layout import MOST_SEEN_BY_PREY, BodyFeatures, PreySelfFeatures

_SELF_WIDTH: Final = len(PreySelfFeatures._fields)
_BODY_WIDTH: Final = len(BodyFeatures._fields)


@outlined
def gather_prey(chunk: Rows, s: Settings, lanes: int, targets: Rows, sections: Sections) -> None:
    """Gather the bodies of all prey from their slots. Prey that is out has zeros, and is hidden like a withdrawn
    hunter.
    """
    for index in range(s.prey):
        me, gathered = prey_of(chunk, s, index), sections.gathered_prey[index]
        for lane in range(lanes):
            slot = int(me[rows.PREY_SLOT + lane])
            gathered[rows.WITHDRAWN + lane] = 1.0 if slot == rows.NO_TARGET else 0.0
            at = max(slot, 0) * s.slot_size + rows.BODY + lane
            for row in range(0, rows.BODY_ROWS * LANES, LANES):
                gathered[row + lane] = 0.0 if slot == rows.NO_TARGET else targets[at + row]


@phase
def write_bodies(
    me: Rows, first: int, width: Width, bodies: Bodies, is_last: bool, sections: Sections, place: Place
) -> None:
    """R12.4: write one prey's view of the ranked bodies, in the lanes of one group; while it is out, it sees none of
    them. `is_last`: the last rank has the last columns of the observation.
    """
    lane = group(first, width)
    observer = body_tile(me, 0.0, lane)
    for item in range(bodies.total):
        put_tile(sections.body_tiles, item, width, body_tile(body_in(bodies, item), 0.0, lane))
    for rank in range(bodies.ranks):
        items = long(item_of(sections.keys[rank * LANES + lane]))
        present = (items != ABSENT) & (me[rows.WITHDRAWN + lane] == 0.0)
        tile = take_tile(sections.body_tiles, items, width)
        at_rank = Place(place.out, place.at + rank * _BODY_WIDTH, place.stride)
        seen = body_seen(observer, body_of_tile(tile))
        put_rank(at_rank, present, seen, is_last and rank == bodies.ranks - 1)


@phase
def write_self(chunk: Rows, me: Rows, s: Settings, first: int, width: Width, index: int, place: Place) -> None:
    """R12.4: write one prey's view of itself, in the lanes of one group."""
    lane = group(first, width)
    own = PreySelfFeatures(
        x=me[rows.X + lane],
        y=me[rows.Y + lane],
        heading_cos=me[rows.COSINE + lane],
        heading_sin=me[rows.SINE + lane],
        linear_velocity=me[rows.SPEED + lane],
        angular_velocity=me[rows.TURN_RATE + lane],
        time_left=time_left_at(chunk, s, lane),
        times_caught=prey_of(chunk, s, index)[rows.TIMES_CAUGHT + lane],
        alive=1.0 - me[rows.WITHDRAWN + lane],
    )
    put_rows(place.out, place.at, place.stride, own)


@outlined
def write_prey(
    chunk: Rows, s: Settings, first: int, width: Width, lanes: int, sections: Sections, place: Place
) -> None:
    """R12.4, R12.3: write the observations of all prey, in the lanes of one group; `gather_prey` comes first.
    At `place` the observation of the first hunter is written.
    """
    columns = sections.observations.shape[2]
    for index in range(s.prey):
        me = sections.gathered_prey[index]
        own = Place(place.out, place.at + (s.hunters + index) * columns, place.stride)
        write_self(chunk, me, s, first, width, index, own)
        at = own.at + _SELF_WIDTH
        for side in range(2):  # a loop, so that the functions it calls are compiled once
            of_prey = side == 1
            bodies = Bodies(
                rows=flat(sections.gathered_prey) if of_prey else chunk[seat_at(0) : seat_at(s.hunters)],
                size=rows.WITHDRAWN + LANES if of_prey else rows.SEAT_SIZE,
                total=s.prey if of_prey else s.hunters,
                observer=index if of_prey else NO_OBSERVER,
                ranks=min(s.prey - 1 if of_prey else s.hunters, MOST_SEEN_BY_PREY),
                are_rivals=False,
            )
            if bodies.ranks > 0:
                measure_bodies(me, s, first, width, bodies, 0.0, sections.keys)
                order_bodies(me, first, width, lanes, bodies, sections)
                is_last = of_prey or s.prey == 1
                write_bodies(me, first, width, bodies, is_last, sections, Place(place.out, at, place.stride))
            at += bodies.ranks * _BODY_WIDTH
