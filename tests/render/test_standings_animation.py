"""The standings, without a pixel: everybody's line at every instant."""

import itertools

import pytest
from render.pictured import SIZES, an_info, assert_inside, assert_texts_apart

from catch_arena.render import hud
from catch_arena.render.shapes import Box, Label
from catch_arena.render.standings_animation import CLIMB_MS, StandingsAnimation, standings_shapes


def settled(standings) -> tuple:
    animation = StandingsAnimation()
    animation.record(0.0, standings)
    return animation.lines(0.0)


@pytest.mark.parametrize("hunters", [1, 2, 4, 8, 16, 33, 64])
@pytest.mark.parametrize("size", SIZES)
def test_the_standings_fit_their_card(size, hunters):
    plan, info = hud.arrange(size, "broadcast", hunters), an_info(hunters)
    standings = [hud.AgentScore(seat, (seat * 37) % 123, withdrawn=seat == 1) for seat in range(hunters)]
    shapes = standings_shapes(plan.standings, info, settled(standings), plan.unit)
    assert_inside(shapes, plan.standings)
    assert_texts_apart(shapes)
    assert any(label.text == str(max(one.score for one in standings)) for label in shapes if isinstance(label, Label))


def test_they_say_whose_view_is_shown():
    plan, info = hud.arrange((1280, 720), "broadcast", 3), an_info(3)
    lines = settled([hud.AgentScore(seat, seat, withdrawn=seat == 1) for seat in range(3)])
    told = [standings_shapes(plan.standings, info, lines, plan.unit, view_of) for view_of in (None, 0, 1)]
    names = [{s.text for s in shapes if isinstance(s, Label) and s.text.startswith(info.names)} for shapes in told]
    one, two, three = info.names
    assert names[0] == names[2] == {one, f"{two}  (out)", three}
    assert names[1] == {f"{one}  (its view)", f"{two}  (out)", three}


@pytest.mark.parametrize("hunters", [4, 64])
@pytest.mark.parametrize("size", [(320, 320), (1280, 720)])
def test_lines_that_climb_stay_in_the_card(size, hunters):
    plan, info = hud.arrange(size, "broadcast", hunters), an_info(hunters)
    animation = StandingsAnimation()
    animation.record(0.0, [hud.AgentScore(seat, seat) for seat in range(hunters)])
    animation.record(1000.0, [hud.AgentScore(seat, hunters - seat) for seat in range(hunters)])
    for time_ms in range(1000, 1500, 30):
        assert_inside(standings_shapes(plan.standings, info, animation.lines(time_ms), plan.unit), plan.standings)


def test_bars_are_as_long_as_their_part_of_the_leaders_score():
    plan, info = hud.arrange((1280, 720), "broadcast", 2), an_info(2)
    lines = settled([hud.AgentScore(0, 40), hud.AgentScore(1, 20)])
    shapes = standings_shapes(plan.standings, info, lines, plan.unit)
    full, half = (next(s for s in shapes if isinstance(s, Box) and s.color == info.color(seat)) for seat in (0, 1))
    assert half.width == pytest.approx(full.width / 2)


def test_a_line_climbs_to_its_place_in_small_steps_and_then_rests():
    animation = StandingsAnimation()
    animation.record(0.0, [hud.AgentScore(0, 2), hud.AgentScore(1, 1), hud.AgentScore(2, 0)])
    assert [line.position for line in animation.lines(0.0)] == [0.0, 1.0, 2.0]
    animation.record(100.0, [hud.AgentScore(0, 2), hud.AgentScore(1, 1), hud.AgentScore(2, 3)])
    seen = [animation.lines(100.0 + CLIMB_MS * part / 20.0) for part in range(21)]
    assert [line.position for line in seen[0]] == [0.0, 1.0, 2.0]
    assert [line.position for line in seen[-1]] == [1.0, 2.0, 0.0]
    for before, after in itertools.pairwise(seen):
        assert all(abs(a.position - b.position) < 0.2 for a, b in zip(before, after, strict=True))
    assert [line.climbs for line in seen[5]] == [False, False, True]
    assert animation.lines(100.0 + CLIMB_MS) is animation.lines(90_000.0)  # nothing is drawn again


def test_a_change_on_the_way_does_not_make_lines_jump():
    animation = StandingsAnimation()
    animation.record(0.0, [hud.AgentScore(0, 2), hud.AgentScore(1, 1)])
    animation.record(100.0, [hud.AgentScore(0, 2), hud.AgentScore(1, 3)])
    before = animation.lines(300.0)
    animation.record(300.0, [hud.AgentScore(0, 4), hud.AgentScore(1, 3)])
    assert [line.position for line in animation.lines(300.0)] == pytest.approx([line.position for line in before])
    assert [line.position for line in animation.lines(300.0 + CLIMB_MS)] == [0.0, 1.0]
