"""The timeline fits its card and names the leader."""

import dataclasses

import pytest
from render.pictured import SIZES, an_info, assert_inside, assert_texts_apart, kinds

from catch_arena.render import hud
from catch_arena.render.shapes import Label, Path
from catch_arena.render.timeline import Timeline


@pytest.mark.parametrize("hunters", [1, 2, 4, 8, 64])
@pytest.mark.parametrize("size", SIZES)
def test_the_timeline_fits_its_card(size, hunters):
    plan, info = hud.arrange(size, "broadcast", hunters), an_info(hunters)
    timeline = Timeline(plan.timeline, info, plan.unit)
    scores = [0] * hunters
    for time_ms in range(0, 60_000, 700):
        seat = (time_ms // 700) ** 2 % hunters
        scores[seat] += 1
        timeline.record(time_ms, [seat], scores)
    shapes = timeline.past_shapes()
    assert_inside(shapes, plan.timeline)
    assert_inside(timeline.present_shapes(59_990.0), plan.timeline)
    assert_texts_apart(shapes)


def a_race(plan, info) -> Timeline:
    timeline = Timeline(plan.timeline, info, plan.unit)
    timeline.record(0, [], [0, 0, 0])
    timeline.record(10_000, [0], [1, 0, 0])
    timeline.record(20_000, [0], [2, 0, 0])
    timeline.record(30_000, [2], [2, 0, 1])
    return timeline


def test_the_leader_is_named_with_its_lead_and_its_line_is_the_highest():
    plan, info = hud.arrange((1280, 720), "broadcast", 3), an_info(3)
    shapes = a_race(plan, info).past_shapes()
    texts = [label.text for label in kinds(shapes, Label)]
    assert f"+1  {info.names[0]}" in texts
    lines = kinds(shapes, Path)
    ends = {line.color: line.points[-1][1] for line in lines}
    heights = [ends[hud.legible(info.colors[seat])] for seat in (0, 2, 1)]
    assert heights == sorted(heights)


@pytest.mark.parametrize("name", ["two\nlines\x00", "עברית", "\U0001f422" * 50, ""])
def test_a_leader_of_any_name_is_named(name):
    plan = hud.arrange((1280, 720), "broadcast", 3)
    info = dataclasses.replace(an_info(3), names=(name, "b", "c"))
    shapes = a_race(plan, info).past_shapes()
    assert_inside(shapes, plan.timeline)
    assert_texts_apart(shapes)
