"""R7.1's order of rivals that are equally far is total, and the one in which Python sorts them."""

from functools import cmp_to_key
from itertools import pairwise, product

import numpy as np
import pytest

from catch_arena.config import ArenaConfig
from catch_arena.core import rows
from catch_arena.core.addresses import by_address
from catch_arena.core.jit import unkept_entry
from catch_arena.core.memory import lay_out, sections_of
from catch_arena.core.ranking import (
    Bodies,
    has_more_catches,
    is_listed_first,
    lead,
    measure_rivals,
    note_positions,
    order_bodies,
    write_order,
)
from catch_arena.core.state import ABSENT, item_at_rank, seat_at, seat_of
from catch_arena.core.vectors import HALF, LANES, SINGLE, WIDE, played_lanes
from catch_arena.engine.core_settings import settings_of, sizes_of

LOOKS = (rows.X, rows.Y, rows.SINE, rows.COSINE, rows.SPEED, rows.SCORE)


def a_chunk(hunters, looks):
    """A chunk with the rows of so many hunters, whose LOOKS are these: (hunters, len(LOOKS), LANES)."""
    chunk = np.zeros((rows.ARENA_ROWS + hunters * rows.HUNTER_ROWS) * LANES)
    for seat, own in enumerate(looks):
        for row, numbers in zip(LOOKS, own, strict=True):
            at = seat_at(seat) + row
            chunk[at : at + LANES] = numbers
    return chunk


def first_of(chunk, seat, one, other, lane, teams):
    """True if the first of two rivals precedes the second."""
    me, rows, others = (chunk[seat_at(who) :] for who in (seat, one, other))
    difference = lead(me, rows, others, lane)
    more = has_more_catches(rows, others, lane, is_listed_first(seat, one, other, teams))
    return more if difference == 0.0 else difference > 0.0


@pytest.mark.rule("R7.1")
def test_r7_1_of_two_rivals_one_precedes_the_other_and_not_the_other_way_round() -> None:
    """Whatever differs between them: without this, the order would hang on that in which they come."""
    rivals = list(product((0.0, 1.0), repeat=len(LOOKS)))
    for one, other in product(rivals, repeat=2):
        chunk = a_chunk(3, np.array([rivals[-1], one, other])[:, :, None].repeat(LANES, axis=2))
        for teams in ([0, 1, 2], [0, 0, 2], [0, 1, 0], [0, 1, 1]):
            first = first_of(chunk, 0, 1, 2, 3, np.array(teams))
            assert first != first_of(chunk, 0, 2, 1, 3, np.array(teams))
            if one == other:
                assert first == (teams != [0, 1, 0])


@unkept_entry
def sort(memory, chunk, seat, width, lanes, s, order):
    sections, chunk, order = sections_of(memory, 0), by_address(chunk), by_address(order)
    for first in range(0, played_lanes(width), len(width)):
        note_positions(chunk, s, first, width, sections.positions)
        measure_rivals(chunk, s, first, width, seat, 0.0, sections.positions, sections.keys)
        rivals = Bodies(chunk[seat_at(0) : seat_at(s.hunters)], rows.SEAT_SIZE, s.hunters, seat, s.hunters_seen, True)
        order_bodies(seat_of(chunk, seat), first, width, lanes, rivals, sections)
        write_order(sections.keys, s.hunters, s.hunters_seen, first, width, order)


@pytest.mark.rule("R7.1")
@pytest.mark.parametrize("width", [SINGLE, HALF, WIDE], ids=["one", "four", "eight"])
@pytest.mark.parametrize("hunters", [2, 3, 4, 8, 9, 20])
def test_r7_1_rivals_come_in_the_order_in_which_python_sorts_them(hunters, width) -> None:
    """On a coarse grid, where most are equally far from somebody, and many stand alike; some have withdrawn."""
    rng = np.random.default_rng(hunters)
    config = ArenaConfig(hunters=hunters)
    s = settings_of(config, with_parts=False)
    lanes = LANES if len(width) > 1 else 1
    # what one leaves in the scratch sections another finds
    memory, sections = lay_out(sizes_of(config, s, 1, 1, with_infos=False, auto_reset=False))
    tied = 0
    for _ in range(160 // hunters if lanes > 1 else 400 // hunters):
        looks = rng.integers(0, 2, (hunters, len(LOOKS), LANES)).astype(float)
        looks[:, :2] *= rng.integers(0, 3, (hunters, 2, LANES))
        chunk = a_chunk(hunters, looks)
        for seat in range(hunters):
            at = seat_at(seat) + rows.WITHDRAWN
            chunk[at : at + LANES] = rng.random(LANES) < 0.1
        teams = sections.teams[:] = rng.integers(0, hunters, hunters)
        for seat in range(hunters):
            order = np.zeros(s.hunters_seen * LANES, np.int8)
            sort(memory, chunk, seat, width, lanes, s, order)
            for lane in range(lanes):
                seen = [item_at_rank(order, rank, lane) for rank in range(s.hunters_seen)]
                expected, ties = by_python(chunk, seat, hunters, lane, teams)
                tied += ties
                assert seen == (expected + [ABSENT] * s.hunters_seen)[: s.hunters_seen]
    assert tied > 20 or hunters == 2


def by_python(chunk, seat, hunters, lane, teams):
    """The rivals in order, and how many of them are as far as the one before."""

    def distance(other):
        its, own = chunk[seat_at(other) :], chunk[seat_at(seat) :]
        return (its[rows.X + lane] - own[rows.X + lane]) ** 2 + (its[rows.Y + lane] - own[rows.Y + lane]) ** 2

    def compare(one, other):
        if distance(one) != distance(other):
            return distance(one) - distance(other)
        return -1 if first_of(chunk, seat, one, other, lane, teams) else 1

    seen = [other for other in range(hunters) if other != seat and not chunk[seat_at(other) + rows.WITHDRAWN + lane]]
    order = sorted(seen, key=cmp_to_key(compare))
    return order, sum(distance(one) == distance(other) for one, other in pairwise(order))
