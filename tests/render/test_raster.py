"""Text is drawn with either version of OpenCV, and drawing prints nothing and opens no display."""

import os
import subprocess
import sys

import numpy as np
import pytest

from catch_arena.render import shapes, sprites, text
from catch_arena.render.raster import Canvas


def a_canvas(width: int = 200, height: int = 100) -> Canvas:
    return Canvas.blank(width, height, (10, 20, 30))


def changed(canvas: Canvas) -> np.ndarray:
    return np.any(canvas.pixels[..., :3] != (10, 20, 30), axis=2)


@pytest.mark.parametrize("bundled", [False, True], ids=["opencv 5", "opencv 4"])
def test_text_is_drawn_with_either_font(monkeypatch, bundled):
    if bundled:
        monkeypatch.setattr(text, "_FACE", None)
    cached_by_font = (text.text_width, text.truncated, sprites._label)
    for cached in cached_by_font:
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
        for cached in cached_by_font:
            cached.cache_clear()


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


def test_turtles_of_nearly_one_length_are_turned_as_each_should_be():
    """A larger turtle has more angles."""
    turtles = [
        shapes.Turtle(50.0, 50.0, np.radians(degrees), length, (255, 0, 0))
        for degrees, length in ((90, 28.2), (80, 28.4))
    ]
    alone = []
    for turtle in turtles:
        for cached in (sprites._turtle, sprites._turtle_inks):
            cached.cache_clear()
        canvas = a_canvas()
        canvas.draw([turtle])
        alone.append(canvas.pixels.copy())
    for turtle, picture in zip(turtles, alone, strict=True):
        canvas = a_canvas()
        canvas.draw([turtle])
        assert np.array_equal(canvas.pixels, picture)
