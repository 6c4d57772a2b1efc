"""The scene has every turtle once, and the circle and the view of each hunter."""

import dataclasses

import pytest
from render.pictured import a_world, kinds, shapes_of

from catch_arena.render.match_info import HUNTER_COLORS
from catch_arena.render.shapes import Label, Ring, Sector, Turtle
from catch_arena.render.viewport import TARGET, Viewport


def test_everybody_is_drawn_once_hunters_above_targets_and_numbers_above_both():
    world = a_world()
    shapes = shapes_of(world)
    turtles = kinds(shapes, Turtle)
    assert [turtle.color for turtle in turtles] == [TARGET] * 2 + list(HUNTER_COLORS[:2])
    texts = [shape.text for shape in kinds(shapes, Label)]
    assert texts == ["hunter_0", "hunter_1", "0", "1"]
    assert shapes.index(turtles[-1]) < min(shapes.index(label) for label in kinds(shapes, Label))


def test_a_withdrawn_hunter_is_faded_and_reaches_for_nothing():
    world = a_world()
    gone = world.hunters[1]._replace(withdrawn=True)
    shapes = shapes_of(dataclasses.replace(world, hunters=(world.hunters[0], gone)))
    assert [turtle.faded for turtle in kinds(shapes, Turtle)] == [False, False, False, True]
    assert len([ring for ring in kinds(shapes, Ring) if ring.veil]) == 1


def test_each_hunters_circle_is_its_own_reach():
    """R2.7."""
    rings = kinds(shapes_of(a_world(), reach_m=(0.3, 0.7)), Ring)
    scale = Viewport(720, 720, 11.088889122009277).scale
    assert [ring.radius for ring in rings if ring.veil] == [pytest.approx(reach * scale) for reach in (0.3, 0.7)]


def test_who_sees_everything_or_is_withdrawn_has_no_view_to_show():
    world = a_world()
    gone = dataclasses.replace(world, hunters=(world.hunters[0], world.hunters[1]._replace(withdrawn=True)))
    assert not kinds(shapes_of(world, view_of=1), Sector)
    assert not kinds(shapes_of(gone, view_of=1, view_radius_m=2.0), Sector)
