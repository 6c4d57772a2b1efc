"""What is shown, without a pixel."""

import dataclasses
import itertools

import numpy as np
import pytest

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.render import scene
from catch_arena.verdicts import Ruling, Verdict
from catch_arena.world import HunterState, TargetState, World


def a_world(*rulings: Ruling, places=((1.0, 2.0), (9.0, 3.0)), step: int = 5) -> World:
    hunters = tuple(HunterState(f"hunter_{i}", x, y, 0.5, 1.0, 0.0, 3 - i) for i, (x, y) in enumerate(places))
    targets = (
        TargetState("target_turtle_7", 7, 1.1, 2.1, 0.0, 0),
        TargetState("target_turtle_9", 9, 5.0, 5.0, 1.0, 480),
    )
    return World(100 * step, step, 11.088889122009277, hunters, targets, rulings, 9)


def shapes_of(world: World, marks=(), time_ms: float = 500.0, size=(720, 720)) -> list:
    look = scene.Look.of(ArenaConfig(hunters=len(world.hunters)))
    view = scene.Viewport(*size, world.side_m)
    poses = [(hunter.x, hunter.y, hunter.theta) for hunter in world.hunters]
    return scene.arena_shapes(
        view, look, hunters=world.hunters, poses=poses, targets=world.targets, marks=marks, time_ms=time_ms
    )


def kinds(shapes, kind) -> list:
    return [shape for shape in shapes if isinstance(shape, kind)]


def test_y_points_up_and_the_arena_lies_in_the_middle():
    view = scene.Viewport(900, 500, 10.0)
    assert view.place(5.0, 5.0) == pytest.approx((450.0, 250.0))
    left, bottom = view.place(0.0, 0.0)
    right, top = view.place(10.0, 10.0)
    assert top < bottom
    assert right - left == pytest.approx(bottom - top)
    assert (top, bottom) == (pytest.approx(500 * 0.03 / 1.06), pytest.approx(500 - 500 * 0.03 / 1.06))


@pytest.mark.parametrize(
    ("side", "size"), [(11.0889, (320, 320)), (11.0889, (720, 720)), (5000.0, (500, 472)), (2.0, (320, 2160))]
)
def test_turtles_are_large_enough_to_see_and_small_enough_for_the_arena(side, size):
    view = scene.Viewport(*size, side)
    assert view.hunter_length >= 20
    assert view.target_length >= 13
    assert view.hunter_length <= 0.35 * min(size)


def test_everybody_is_drawn_once_hunters_above_targets_and_numbers_above_both():
    world = a_world()
    shapes = shapes_of(world)
    turtles = kinds(shapes, scene.Turtle)
    assert [turtle.color for turtle in turtles] == [scene.TARGET] * 2 + list(scene.HUNTER_COLORS[:2])
    numbers = [shape.text for shape in kinds(shapes, scene.Label)]
    assert numbers == ["0", "1"]
    assert shapes.index(turtles[-1]) < min(shapes.index(label) for label in kinds(shapes, scene.Label))


def test_the_reach_circle_is_true_to_scale():
    rings = kinds(shapes_of(a_world()), scene.Ring)
    scale = scene.Viewport(720, 720, 11.088889122009277).scale
    assert [ring.radius for ring in rings if ring.veil] == [pytest.approx(0.3 * scale)] * 2


def test_a_target_is_announced_by_a_ring_when_it_appears_and_not_later():
    early = kinds(shapes_of(a_world(), time_ms=500.0), scene.Ring)
    late = kinds(shapes_of(a_world(), time_ms=480.0 + scene.SPAWN_MS), scene.Ring)
    assert len(early) == len(late) + 1


def test_rulings_are_shown_where_the_target_was_from_the_boundary_at_which_they_were_judged():
    before = a_world(step=4)
    after = a_world(
        Ruling(Verdict.GRANTED, 0, "target_turtle_7", 141421, 0),
        Ruling(Verdict.LOST_CONTEST, 1, "target_turtle_7", 200000, 0),
    )
    catch, lost = scene.marks_of(before, after)
    assert (catch.kind, catch.seat, catch.x, catch.y, catch.time_ms) == ("catch", 0, 1.1, 2.1, 400)
    assert (lost.kind, lost.seat, lost.x, lost.y, lost.time_ms) == ("lost", 1, 1.1, 2.1, 400)


def test_a_grant_of_what_never_was_is_shown_at_the_hunter():
    """The capstone profile grants any name (R9.1)."""
    (mark,) = scene.marks_of(a_world(step=4), a_world(Ruling(Verdict.GRANTED, 1, "no_such_turtle")))
    assert (mark.x, mark.y) == (9.0, 3.0)


@pytest.mark.parametrize("verdict", [Verdict.OUT_OF_REACH, Verdict.MALFORMED, Verdict.ALREADY_CAUGHT])
def test_other_verdicts_are_not_shown(verdict):
    assert scene.marks_of(a_world(step=4), a_world(Ruling(verdict, 0, "target_turtle_7"))) == ()


@pytest.mark.parametrize(("kind", "word"), [("catch", "+1"), ("lost", "−"), ("refused", "!")])
def test_a_mark_puts_its_word_over_the_hunter_and_passes(kind, word):
    mark = scene.Mark(kind, 400, 1, 9.0, 3.0)
    assert word in [label.text for label in kinds(shapes_of(a_world(), [mark]), scene.Label)]
    assert scene.still_seen([mark], 400 + mark.lasts_ms - 1) == [mark]
    assert scene.still_seen([mark], 400 + mark.lasts_ms) == []


def test_a_lost_contest_is_a_line_from_the_loser_to_the_target():
    mark = scene.Mark("lost", 400, 1, 1.1, 2.1)
    view = scene.Viewport(720, 720, 11.088889122009277)
    (line,) = kinds(shapes_of(a_world(), [mark]), scene.Stroke)
    assert (line.x0, line.y0, line.x1, line.y1) == (*view.place(9.0, 3.0), *view.place(1.1, 2.1))


def test_of_repeated_refusals_only_the_latest_is_seen():
    marks = [scene.Mark("refused", time_ms, 0, 1.0, 1.0) for time_ms in (0, 100, 200)]
    assert scene.still_seen(marks, 250.0) == marks[2:]


@pytest.mark.parametrize("size", [(320, 298), (720, 720)])
@pytest.mark.parametrize("kind", ["catch", "lost", "refused"])
def test_words_stay_inside_the_picture_at_every_corner(size, kind):
    for x, y in itertools.product((0.0, 11.0888), repeat=2):
        world = a_world(places=((x, y),))
        for time_ms in (400.0, 800.0, 1000.0):
            words = list(kinds(shapes_of(world, [scene.Mark(kind, 400, 0, x, y)], time_ms, size), scene.Label))
            for word in words:
                assert word.size * 0.5 <= word.y <= size[1] - word.size * 0.5
                assert word.size * 0.5 <= word.x <= size[0] - word.size * 0.5


def test_a_withdrawn_hunter_is_faded_and_reaches_for_nothing():
    world = a_world()
    gone = dataclasses.replace(world.hunters[1], withdrawn=True)
    shapes = shapes_of(dataclasses.replace(world, hunters=(world.hunters[0], gone)))
    assert [turtle.faded for turtle in kinds(shapes, scene.Turtle)] == [False, False, False, True]
    assert len([ring for ring in kinds(shapes, scene.Ring) if ring.veil]) == 1


def test_names_must_fit_the_seats():
    with pytest.raises(ConfigError, match="names must be one for each of 4 hunters, got 3"):
        scene.Look.of(ArenaConfig(), ["a", "b", "c"])


# Machado, Oliveira and Fernandes (2009), severity 1, on linear RGB
_SIGHTS = {
    "normal": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}


def lab(color, sight) -> np.ndarray:
    """A colour as somebody of that sight sees it, in CIE Lab."""
    part = np.array(color) / 255.0
    linear = np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)
    seen = np.clip(np.array(_SIGHTS[sight]) @ linear, 0.0, 1.0)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    xyz = to_xyz @ seen / [0.9505, 1.0, 1.089]
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("sight", _SIGHTS)
def test_eight_hunters_keep_apart_for_every_sight(sight):
    """A difference of 10 in Lab is plain at a glance; the numbers on the shells help besides."""
    colors = [*scene.HUNTER_COLORS, scene.GROUND, scene.TARGET]
    seen = [lab(color, sight) for color in colors]
    worst = min(float(np.linalg.norm(a - b)) for a, b in itertools.combinations(seen, 2))
    assert worst > 14.0


def test_sixty_four_hunters_have_colours_and_neighbours_in_the_table_differ():
    look = scene.Look.of(ArenaConfig(hunters=64))
    colors = [look.color(seat) for seat in range(64)]
    assert len(set(colors)) == 24
    assert all(a != b for a, b in itertools.pairwise(colors))
