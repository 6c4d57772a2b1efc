"""The timeline, without a pixel."""

import dataclasses

import pytest
from render.pictured import SIZES, an_info, assert_inside, assert_texts_apart, kinds

from catch_arena.render import hud
from catch_arena.render.shapes import Box, Label, Path
from catch_arena.render.timeline import (
    COLUMNS,
    Timeline,
    lead,
    over_average,
    present_shapes,
    tick_seconds,
    timeline_shapes,
)


@pytest.mark.parametrize("hunters", [1, 2, 4, 8, 64])
@pytest.mark.parametrize("size", SIZES)
def test_the_timeline_fits_its_card(size, hunters):
    plan, info = hud.arrange(size, "broadcast", hunters), an_info(hunters)
    timeline = Timeline(info.duration_ms)
    scores = [0] * hunters
    for time_ms in range(0, 60_000, 700):
        seat = (time_ms // 700) ** 2 % hunters
        scores[seat] += 1
        timeline.record(time_ms, [seat], scores)
    shapes = timeline_shapes(plan.timeline, info, timeline, plan.unit)
    assert_inside(shapes, plan.timeline)
    assert_inside(present_shapes(plan.timeline, info, timeline, 59_990.0, plan.unit), plan.timeline)
    assert_texts_apart(shapes)


def test_the_lead():
    assert lead([3, 7, 5]) == (1, 2)
    assert lead([7, 7, 5]) == (-1, 0)
    assert lead([0, 0]) == (-1, 0)
    assert lead([4]) == (0, 4)


def test_lines_stand_for_how_far_each_is_ahead_of_the_average():
    assert over_average([4, 2, 0]) == [2.0, 0.0, -2.0]
    assert over_average([7]) == [7]


def test_the_timeline_keeps_every_hunters_catches_and_the_scores_between_them():
    timeline = Timeline(COLUMNS * 100)  # 100 ms a column
    timeline.record(0, [], [0, 0])
    timeline.record(500, [0, 1], [1, 1])
    timeline.record(550, [1], [1, 2])
    timeline.record(900, [], [1, 2])
    assert timeline.catches == 3
    assert timeline.catchers[5] == {0, 1}
    assert timeline.scores == [(0, 0)] * 5 + [(1, 2)] * 5
    assert timeline.last_change == 5


def test_the_timeline_does_not_grow_with_the_match():
    timeline = Timeline(10**9)
    for time_ms in range(0, 10**9, 10**5):
        timeline.record(time_ms, [0], [time_ms, 0])
    assert len(timeline.catchers) == len(timeline.scores) == COLUMNS


def a_race() -> Timeline:
    timeline = Timeline(60_000)
    timeline.record(0, [], [0, 0, 0])
    timeline.record(10_000, [0], [1, 0, 0])
    timeline.record(20_000, [0], [2, 0, 0])
    timeline.record(30_000, [2], [2, 0, 1])
    return timeline


def test_the_leader_is_named_with_its_lead_and_its_line_is_the_highest():
    plan, info = hud.arrange((1280, 720), "broadcast", 3), an_info(3)
    shapes = timeline_shapes(plan.timeline, info, a_race(), plan.unit)
    texts = [label.text for label in kinds(shapes, Label)]
    assert info.names[0] in texts
    assert "  +1" in texts
    lines = kinds(shapes, Path)
    ends = {line.color: line.points[-1][1] for line in lines}
    assert [ends[hud.legible(info.color(seat))] for seat in (0, 2, 1)] == sorted(ends.values())


@pytest.mark.parametrize("name", ["two\nlines\x00", "עברית", "\U0001f422" * 50, ""])
def test_a_leader_of_any_name_is_named(name):
    plan = hud.arrange((1280, 720), "broadcast", 3)
    info = dataclasses.replace(an_info(3), names=(name, "b", "c"))
    shapes = timeline_shapes(plan.timeline, info, a_race(), plan.unit)
    assert_inside(shapes, plan.timeline)
    assert_texts_apart(shapes)


def test_the_lines_reach_to_the_present_and_end_in_dots():
    plan, info = hud.arrange((1280, 720), "broadcast", 3), an_info(3)
    timeline = a_race()
    (x,) = {
        box.left + box.width / 2 for box in kinds(present_shapes(plan.timeline, info, timeline, 45_000.0, 1.0), Box)[1:]
    }
    history = kinds(timeline_shapes(plan.timeline, info, timeline, 1.0), Path)[0].points[-1][0]
    assert history < x < plan.timeline.left + plan.timeline.width


@pytest.mark.parametrize("duration_s", [0.1, 3.0, 60.0, 61.7, 3600.0, 1e6])
def test_the_axis_has_some_round_times_but_not_too_many(duration_s):
    ticks = tick_seconds(duration_s, 7.0)
    assert 2 <= len(ticks) <= 7
    assert ticks[0] == 0.0
    assert ticks[-1] <= duration_s * (1 + 1e-9)
