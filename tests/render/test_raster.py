"""Shapes as pixels."""

import os
import subprocess
import sys

import numpy as np
import pytest

from catch_arena.render import shapes, sprites, text
from catch_arena.render.hud import Rect
from catch_arena.render.raster import Canvas, Ground
from catch_arena.render.viewport import Viewport


def a_canvas(width: int = 200, height: int = 100) -> Canvas:
    return Canvas.blank(width, height, (10, 20, 30), sprites.SpriteCache())


def changed(canvas: Canvas) -> np.ndarray:
    return np.any(canvas.pixels[..., :3] != (10, 20, 30), axis=2)


def test_a_box_covers_exactly_its_pixels():
    canvas = a_canvas()
    canvas.draw([shapes.Box(20, 30, 50, 10, (200, 100, 0))])
    red = canvas.pixels[..., 0].astype(int)
    assert (red[30:40, 20:70] >= 105).all()  # more than half
    red[30:40, 20:70] = 10
    assert (red < 105).all()
    assert tuple(canvas.pixels[35, 40, :3]) == (200, 100, 0)


@pytest.mark.parametrize(
    "shape",
    [
        shapes.Turtle(100.25, 50.75, 0.0, 40.0, (255, 170, 36)),
        shapes.Ring(100.25, 50.75, 20.0, 3.0, (255, 255, 255)),
        shapes.Polygon(((80.25, 40.75), (120.25, 40.75), (120.25, 60.75), (80.25, 60.75)), (255, 255, 255)),
        shapes.Stroke(80.25, 50.75, 120.25, 50.75, 4.0, (255, 255, 255)),
        shapes.Path(((80.25, 40.75), (120.25, 40.75), (80.25, 60.75), (120.25, 60.75)), 4.0, (255, 255, 255)),
    ],
    ids=lambda shape: type(shape).__name__,
)
def test_a_shape_stands_where_it_says(shape):
    """Its middle of mass, within half a pixel (a turtle's shadow and head pull a little more)."""
    canvas = a_canvas()
    canvas.draw([shape])
    weight = np.abs(canvas.pixels[..., :3].astype(float) - (10, 20, 30)).sum(axis=2)
    rows, columns = np.mgrid[: canvas.pixels.shape[0], : canvas.pixels.shape[1]] + 0.5
    middle = (columns * weight).sum() / weight.sum(), (rows * weight).sum() / weight.sum()
    assert middle == pytest.approx((100.25, 50.75), abs=1.5 if isinstance(shape, shapes.Turtle) else 0.6)


def a_sector(**changes) -> shapes.Sector:
    """To the right, a right angle wide, over a half of the canvas."""
    whole = {"x": 50.0, "y": 50.0, "radius": 30.0, "theta": 0.0, "angle": np.pi / 2, "color": (255, 255, 255)}
    return shapes.Sector(**{**whole, "opacity": 0.5, "soft": 2.0, "within": (0.0, 0.0, 200.0, 100.0), **changes})


def test_a_sector_lies_about_its_heading_and_what_is_under_it_shines_through():
    canvas = a_canvas()
    canvas.draw([a_sector(theta=np.pi / 2)])
    halfway = np.array((132, 138, 142))  # to white: above, where y is less
    assert np.abs(canvas.pixels[35, 50, :3] - halfway).max() <= 1
    lit = changed(canvas)
    assert not lit[55:].any()
    assert not lit[:, :26].any()
    assert not lit[:17].any()
    assert lit[21, 50]


def test_a_whole_turn_is_a_disc_and_nothing_lies_outside_the_rectangle():
    canvas = a_canvas()
    canvas.draw([a_sector(angle=2 * np.pi, within=(40.0, 10.0, 70.0, 60.0))])
    lit = changed(canvas)
    assert lit[30:60, 40:70].all()
    lit[10:60, 40:70] = False
    assert not lit.any()


@pytest.mark.parametrize("changes", [{"x": -500.0}, {"y": 900.0}, {"x": -20.0, "radius": 5000.0}, {"soft": 0.2}])
def test_a_sector_may_reach_beyond_the_canvas_or_lie_outside_of_it(changes):
    canvas = a_canvas()
    canvas.draw([a_sector(**changes)])
    assert changed(canvas).any() == (changes not in ({"x": -500.0}, {"y": 900.0}))


def test_the_edge_of_a_sector_is_soft():
    canvas = a_canvas()
    canvas.draw([a_sector(soft=6.0)])
    edge = canvas.pixels[50, 70:90, 0].astype(int)
    assert (np.diff(edge) <= 0).all()
    assert len(set(edge)) > 6


def test_a_turtle_faces_its_heading():
    """The head, wider than the tail, lies in front: at theta = pi / 2 above, since theta is counter-clockwise."""
    canvas = a_canvas(100, 100)
    canvas.draw([shapes.Turtle(50, 50, np.pi / 2, 60.0, (255, 170, 36))])
    lit = canvas.pixels[..., 0] > 120  # the shadow is dark
    above, below = lit[:28, 40:60].sum(), lit[72:, 40:60].sum()
    assert above > 1.5 * below


def test_what_lies_outside_is_cut_off():
    canvas = a_canvas()
    part = canvas.part(Rect(50, 20, 40, 40))
    part.draw([shapes.Turtle(0, 0, 0.3, 60.0, (255, 0, 0)), shapes.Stroke(-50, 20, 90, 20, 5, (255, 0, 0))])
    touched = changed(canvas)
    assert touched[20:60, 50:90].any()
    touched[20:60, 50:90] = False
    assert not touched.any()


@pytest.mark.parametrize("bundled", [False, True], ids=["opencv 5", "opencv 4"])
def test_text_is_drawn_with_either_font(monkeypatch, bundled):
    if bundled:
        monkeypatch.setattr(text, "_FACE", None)
    for cached in (text.text_width, text.truncated):
        cached.cache_clear()
    try:
        canvas = a_canvas()
        canvas.draw([shapes.Label(100, 50, "hunter_7", 20, (255, 255, 255), align="center", outline=(0, 0, 0))])
        rows, columns = np.nonzero(changed(canvas))
        assert 40 < columns.max() - columns.min() < 140
        assert 10 < rows.max() - rows.min() < 32
        assert abs((columns.max() + columns.min()) / 2 - 100) < 3
        assert canvas.pixels[..., :3].max() == 255
    finally:
        for cached in (text.text_width, text.truncated):
            cached.cache_clear()


def test_sprites_make_room_for_each_other():
    cache = sprites.SpriteCache(most_bytes=100_000)
    canvas = Canvas.blank(200, 200, (0, 0, 0), cache)
    for step in range(60):
        canvas.draw([shapes.Turtle(100.0, 100.0, step / 9.0, 40.0, (255, 0, 0))])
    assert 1 < len(cache) < 60
    assert 0 < cache.bytes <= 100_000


def test_trails_fade_to_a_trace_and_the_trace_to_nothing():
    ground = Ground(Viewport(200, 200, 11.0), sprites.SpriteCache())
    clean = ground.pixels.copy()
    ground.trail((255, 0, 0), (2.0, 5.5, 0.0), (9.0, 5.5, 0.0))
    fresh = ground.pixels.copy()
    ground.fade(20_000.0)
    trace = ground.pixels.copy()
    for minutes in range(1, 20):
        ground.fade(60_000.0 * minutes)
    row, column = 99, 100
    assert fresh[row, column, 0] > trace[row, column, 0] > clean[row, column, 0]
    assert np.array_equal(ground.pixels, clean)


def test_nothing_is_printed_and_no_display_is_opened():
    code = """
import os
from catch_arena import ArenaConfig, Engine
from catch_arena.render.renderer import ArenaPainter
from catch_arena.render.optional_imports import pygame
engine = Engine(ArenaConfig())
engine.reset([1])
assert ArenaPainter(ArenaConfig()).paint(engine.world()).any()
assert not pygame.display.get_init()
"""
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER", "SDL_VIDEO_DRIVER", "PYGAME_HIDE_SUPPORT_PROMPT")
    bare = {name: value for name, value in os.environ.items() if name not in hidden}
    bare["PYTHONPATH"] = os.pathsep.join(sys.path)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=bare)
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
