"""Standings fit their card, and lines climb smoothly."""

import itertools

import pytest
from render.pictured import SIZES, an_info, assert_inside, assert_texts_apart

from catch_arena.render import hud
from catch_arena.render.shapes import Label
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
