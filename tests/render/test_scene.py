"""What is shown, without a pixel."""

import dataclasses
import math

import pytest
from render.pictured import a_world, kinds, shapes_of

from catch_arena.render import scene
from catch_arena.render.match_info import HUNTER_COLORS
from catch_arena.render.shapes import Label, Ring, Sector, Turtle
from catch_arena.render.viewport import TARGET, Viewport


def test_y_points_up_and_the_arena_lies_in_the_middle():
    viewport = Viewport(900, 500, 10.0)
    assert viewport.to_pixels(5.0, 5.0) == pytest.approx((450.0, 250.0))
    left, bottom = viewport.to_pixels(0.0, 0.0)
    right, top = viewport.to_pixels(10.0, 10.0)
    assert top < bottom
    assert right - left == pytest.approx(bottom - top)
    assert (top, bottom) == (pytest.approx(500 * 0.03 / 1.06), pytest.approx(500 - 500 * 0.03 / 1.06))


@pytest.mark.parametrize(
    ("side", "size"), [(11.0889, (320, 320)), (11.0889, (720, 720)), (5000.0, (500, 472)), (2.0, (320, 2160))]
)
def test_turtles_are_large_enough_to_see_and_small_enough_for_the_arena(side, size):
    viewport = Viewport(*size, side)
    assert viewport.hunter_length >= 20
    assert viewport.target_length >= 13
    assert viewport.hunter_length <= 0.35 * min(size)


def test_everybody_is_drawn_once_hunters_above_targets_and_numbers_above_both():
    world = a_world()
    shapes = shapes_of(world)
    turtles = kinds(shapes, Turtle)
    assert [turtle.color for turtle in turtles] == [TARGET] * 2 + list(HUNTER_COLORS[:2])
    numbers = [shape.text for shape in kinds(shapes, Label)]
    assert numbers == ["0", "1"]
    assert shapes.index(turtles[-1]) < min(shapes.index(label) for label in kinds(shapes, Label))


def test_the_reach_circle_is_true_to_scale():
    rings = kinds(shapes_of(a_world()), Ring)
    scale = Viewport(720, 720, 11.088889122009277).scale
    assert [ring.radius for ring in rings if ring.veil] == [pytest.approx(0.3 * scale)] * 2


def test_a_target_is_announced_by_a_ring_when_it_appears_and_not_later():
    early = kinds(shapes_of(a_world(), time_ms=500.0), Ring)
    late = kinds(shapes_of(a_world(), time_ms=480.0 + scene.SPAWN_MS), Ring)
    assert len(early) == len(late) + 1


def test_a_withdrawn_hunter_is_faded_and_reaches_for_nothing():
    world = a_world()
    gone = dataclasses.replace(world.hunters[1], withdrawn=True)
    shapes = shapes_of(dataclasses.replace(world, hunters=(world.hunters[0], gone)))
    assert [turtle.faded for turtle in kinds(shapes, Turtle)] == [False, False, False, True]
    assert len([ring for ring in kinds(shapes, Ring) if ring.veil]) == 1


def test_each_hunters_circle_is_its_own_reach():
    """R2.7."""
    rings = kinds(shapes_of(a_world(), reach_m=(0.3, 0.7)), Ring)
    scale = Viewport(720, 720, 11.088889122009277).scale
    assert [ring.radius for ring in rings if ring.veil] == [pytest.approx(reach * scale) for reach in (0.3, 0.7)]


@pytest.mark.parametrize(
    ("settings", "radius", "angle"),
    [
        ({"view_radius_m": 2.5}, 2.5, 360.0),
        ({"view_angle_deg": 100.0}, 11.088889122009277 * math.sqrt(2.0), 100.0),
        ({"view_radius_m": 4.0, "view_angle_deg": 90.0}, 4.0, 90.0),
    ],
)
def test_the_view_that_is_asked_for_lies_under_everything_and_is_true_to_scale(settings, radius, angle):
    """R7.5: at the hunter's place, about its heading."""
    world = a_world()
    scale = Viewport(720, 720, world.side_m).scale
    assert not kinds(shapes_of(world, **settings), Sector)
    first, *rest = shapes_of(world, view_of=1, **settings)
    assert isinstance(first, Sector)
    assert not kinds(rest, Sector)
    assert (first.x, first.y) == Viewport(720, 720, world.side_m).to_pixels(9.0, 3.0)
    assert (first.radius, first.theta) == (pytest.approx(radius * scale), 0.5)
    assert math.degrees(first.angle) == pytest.approx(angle)


def test_who_sees_everything_or_is_withdrawn_has_no_view_to_show():
    world = a_world()
    gone = dataclasses.replace(world, hunters=(world.hunters[0], dataclasses.replace(world.hunters[1], withdrawn=True)))
    assert not kinds(shapes_of(world, view_of=1), Sector)
    assert not kinds(shapes_of(gone, view_of=1, view_radius_m=2.0), Sector)
