"""The parts of the panel lie inside the frame and apart, at every size and for every number of hunters."""

import itertools

import pytest
from render.pictured import SIZES, an_info, assert_inside, assert_texts_apart

from catch_arena.render import hud


def overlap(a: hud.Rect, b: hud.Rect) -> bool:
    apart = a.left + a.width <= b.left or b.left + b.width <= a.left
    return not (apart or a.top + a.height <= b.top or b.top + b.height <= a.top)


@pytest.mark.parametrize(("agents", "teams"), [(1, 0), (4, 0), (16, 0), (64, 0), (4, 2), (8, 4), (24, 8), (64, 32)])
@pytest.mark.parametrize("layout", ["broadcast", "arena"])
@pytest.mark.parametrize("size", SIZES)
def test_the_parts_lie_in_the_frame_and_apart_and_the_arena_is_the_largest(size, layout, agents, teams):
    plan = hud.arrange(size, layout, agents, teams)
    parts = [plan.arena, plan.header, plan.teams, plan.standings, plan.feed, plan.timeline]
    parts = [part for part in parts if part.width]
    card = layout == "broadcast" and 0 < teams <= hud.MOST_TEAMS
    assert (plan.teams.width > 0) == card
    assert len(parts) - card in ((4, 5) if layout == "broadcast" else (2,))
    for part in parts:
        assert part.left >= 0
        assert part.top >= 0
        assert part.left + part.width <= size[0]
        assert part.top + part.height <= size[1]
        assert min(part.width, part.height) >= 20
        assert min(part.width, part.height) <= min(plan.arena.width, plan.arena.height)
    assert not any(overlap(a, b) for a, b in itertools.combinations(parts, 2))


@pytest.mark.parametrize("time_text", ["0.0", "59.9", "179.9", "3:00.0", "16666:39.9"])
@pytest.mark.parametrize("size", SIZES)
def test_the_header_fits(size, time_text):
    plan = hud.arrange(size, "broadcast", 4)
    shapes = hud.header_shapes(plan.header, an_info(4), 2**63, time_text, plan.unit)
    assert_inside(shapes, plan.header)
    assert_texts_apart(shapes)


def test_the_best_stand_first_and_equals_by_seat():
    standings = [hud.AgentScore(0, 2), hud.AgentScore(1, 5), hud.AgentScore(2, 5)]
    assert [one.agent for one in hud.ranked(standings)] == [1, 2, 0]


@pytest.mark.parametrize(
    ("time_ms", "shown"), [(0, "0.0"), (99.9, "0.0"), (18_850, "18.8"), (180_000, "3:00.0"), (3_661_500, "61:01.5")]
)
def test_the_clock_shows_tenths_that_have_passed(time_ms, shown):
    assert hud.clock(time_ms) == shown
