"""The panel, without a pixel: everything in its place, at every size and for every number of hunters."""

import itertools

import pytest
from render.pictured import SIZES, an_info, assert_inside, assert_texts_apart

from catch_arena.config import ArenaConfig
from catch_arena.render import hud
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import Label


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


@pytest.mark.parametrize("hunters", [1, 4, 16, 64])
@pytest.mark.parametrize("size", SIZES)
def test_the_line_over_the_arena_fits(size, hunters):
    plan = hud.arrange(size, "arena", hunters)
    chips, clock = hud.split_strip(plan.header, "59.9")
    standings = [hud.AgentScore(seat, 11 * seat) for seat in range(hunters)]
    shapes = hud.chip_shapes(chips, an_info(hunters), (), standings)
    assert_inside(shapes, chips)
    assert_texts_apart(shapes)
    assert_inside(hud.strip_clock_shapes(clock, "59.9"), clock)


def test_the_best_stand_first_and_equals_by_seat():
    standings = [hud.AgentScore(0, 2), hud.AgentScore(1, 5), hud.AgentScore(2, 5)]
    assert [one.agent for one in hud.ranked(standings)] == [1, 2, 0]


@pytest.mark.parametrize(
    ("time_ms", "shown"), [(0, "0.0"), (99.9, "0.0"), (18_850, "18.8"), (180_000, "3:00.0"), (3_661_500, "61:01.5")]
)
def test_the_clock_shows_tenths_that_have_passed(time_ms, shown):
    assert hud.clock(time_ms) == shown


@pytest.mark.parametrize("hunters", [2, 4, 8])
def test_a_usual_video_has_room_for_the_feed(hunters):
    assert hud.arrange((1280, 720), "broadcast", hunters).feed.height >= 2 * hud.FEED_ROW


@pytest.mark.parametrize("seat", range(24))
def test_every_hunters_colour_is_lightened_until_it_can_be_read_on_a_card(seat):
    color = hud.legible(an_info(24).color(seat))
    assert 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2] > 100


@pytest.mark.parametrize(("width", "named"), [(1920, True), (720, True), (400, False)])
def test_the_line_over_the_arena_has_all_names_or_none(width, named):
    info = MatchInfo.of(ArenaConfig(hunters=4), ["nearest", "patrol", "contested", "first"])
    shapes = hud.chip_shapes(
        hud.Rect(0, 0, width, 40), info, (), [hud.AgentScore(seat, 10 + seat) for seat in range(4)]
    )
    shown = [shape.text for shape in shapes if isinstance(shape, Label)]
    assert [name in shown for name in info.names] == [named] * 4
    assert all(str(10 + seat) in shown for seat in range(4))
    assert_inside(shapes, hud.Rect(0, 0, width, 40))
    assert_texts_apart(shapes)
