"""Shapes as pixels, and the painter behind `env.render()`."""

import os
import subprocess
import sys

import numpy as np
import pytest

import catch_arena
from catch_arena.errors import ConfigError
from catch_arena.render import raster, scene, sprites, text
from catch_arena.render.raster import ArenaPainter, Canvas, Ground, checked_size


def a_canvas(width: int = 200, height: int = 100) -> Canvas:
    return Canvas.blank(width, height, (10, 20, 30), sprites.SpriteCache())


def changed(canvas: Canvas) -> np.ndarray:
    return np.any(canvas.pixels[..., :3] != (10, 20, 30), axis=2)


def test_a_box_covers_exactly_its_pixels():
    canvas = a_canvas()
    canvas.draw([scene.Box(20, 30, 50, 10, (200, 100, 0))])
    red = canvas.pixels[..., 0].astype(int)
    assert (red[30:40, 20:70] >= 105).all()  # more than half
    red[30:40, 20:70] = 10
    assert (red < 105).all()
    assert tuple(canvas.pixels[35, 40, :3]) == (200, 100, 0)


@pytest.mark.parametrize(
    "shape",
    [
        scene.Turtle(100.25, 50.75, 0.0, 40.0, (255, 170, 36)),
        scene.Ring(100.25, 50.75, 20.0, 3.0, (255, 255, 255)),
        scene.Polygon(((80.25, 40.75), (120.25, 40.75), (120.25, 60.75), (80.25, 60.75)), (255, 255, 255)),
        scene.Stroke(80.25, 50.75, 120.25, 50.75, 4.0, (255, 255, 255)),
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
    assert middle == pytest.approx((100.25, 50.75), abs=1.5 if isinstance(shape, scene.Turtle) else 0.6)


def test_a_turtle_faces_its_heading():
    """The head, wider than the tail, lies in front: at theta = pi / 2 above, since theta is counter-clockwise."""
    canvas = a_canvas(100, 100)
    canvas.draw([scene.Turtle(50, 50, np.pi / 2, 60.0, (255, 170, 36))])
    lit = canvas.pixels[..., 0] > 120  # the shadow is dark
    above, below = lit[:28, 40:60].sum(), lit[72:, 40:60].sum()
    assert above > 1.5 * below


def test_what_lies_outside_is_cut_off():
    canvas = a_canvas()
    part = canvas.part(raster.hud.Rect(50, 20, 40, 40))
    part.draw([scene.Turtle(0, 0, 0.3, 60.0, (255, 0, 0)), scene.Stroke(-50, 20, 90, 20, 5, (255, 0, 0))])
    touched = changed(canvas)
    assert touched[20:60, 50:90].any()
    touched[20:60, 50:90] = False
    assert not touched.any()


@pytest.mark.parametrize("bundled", [False, True], ids=["opencv 5", "opencv 4"])
def test_text_is_drawn_with_either_font(monkeypatch, bundled):
    if bundled:
        monkeypatch.setattr(text, "_FACE", None)
    for cached in (text.text_width, text.fitted):
        cached.cache_clear()
    try:
        canvas = a_canvas()
        canvas.draw([scene.Label(100, 50, "hunter_7", 20, (255, 255, 255), align="center", outline=(0, 0, 0))])
        rows, columns = np.nonzero(changed(canvas))
        assert 40 < columns.max() - columns.min() < 140
        assert 10 < rows.max() - rows.min() < 32
        assert abs((columns.max() + columns.min()) / 2 - 100) < 3
        assert canvas.pixels[..., :3].max() == 255
    finally:
        for cached in (text.text_width, text.fitted):
            cached.cache_clear()


def test_sprites_make_room_for_each_other():
    cache = sprites.SpriteCache(most_bytes=100_000)
    canvas = Canvas.blank(200, 200, (0, 0, 0), cache)
    for step in range(60):
        canvas.draw([scene.Turtle(100.0, 100.0, step / 9.0, 40.0, (255, 0, 0))])
    assert cache._bytes <= 100_000
    assert cache._bytes == sum(sprites._bytes_of(made) for made in cache._sprites.values())


def test_trails_fade_to_a_trace_and_the_trace_to_nothing():
    ground = Ground(scene.Viewport(200, 200, 11.0), sprites.SpriteCache())
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


def test_frames_are_fresh_arrays_of_the_size_asked_for(match, worlds):
    painter = ArenaPainter(match.config, size=(500, 400))
    first = painter.paint(worlds[0])
    kept = first.copy()
    second = painter.paint(worlds[10])
    assert first.shape == (400, 500, 3)
    assert first.dtype == np.uint8
    assert first.flags.owndata or first.base is None or not np.shares_memory(first, painter._stage.pixels)
    assert not np.shares_memory(first, second)
    assert np.array_equal(first, kept)
    assert not np.array_equal(first, second)
    first[:] = 0  # whoever owns a frame may write on it
    assert second.any()


def test_a_new_episode_has_no_old_trails(match, worlds):
    painter = ArenaPainter(match.config)
    for world in worlds[:12]:
        painter.paint(world)
    again = painter.paint(worlds[0])
    assert np.array_equal(again, ArenaPainter(match.config).paint(worlds[0]))


def test_painting_a_world_twice_changes_nothing(match, worlds):
    painter = ArenaPainter(match.config)
    for world in worlds[:8]:
        frame = painter.paint(world)
    assert np.array_equal(painter.paint(worlds[7]), frame)


def test_a_jump_that_nobody_can_drive_leaves_no_trail(match, worlds, play):
    """A new episode of which the first frame asked for is a later one."""
    other = list(play(time_limit_s=3.0, seed=99).worlds())[20]
    painter = ArenaPainter(match.config)
    painter.paint(worlds[10])
    assert np.array_equal(painter.paint(other), ArenaPainter(match.config).paint(other))


def test_hunters_are_seen_in_their_colours_where_they_are(match, worlds):
    frame = ArenaPainter(match.config).paint(worlds[0])
    view = scene.Viewport(500, 472, worlds[0].side_m)
    for seat, hunter in enumerate(worlds[0].hunters):
        x, y = (round(part) for part in view.place(hunter.x, hunter.y))
        around = frame[28 + y - 14 : 28 + y + 14, x - 14 : x + 14].reshape(-1, 3).astype(int)
        nearest = np.abs(around - scene.HUNTER_COLORS[seat]).sum(axis=1).min()
        assert nearest < 60


@pytest.mark.parametrize("hunters", [1, 16, 64])
@pytest.mark.parametrize("layout", ["arena", "broadcast"])
@pytest.mark.parametrize("size", [(320, 320), (501, 333)])
def test_any_number_of_hunters_is_painted(play, hunters, layout, size):
    replay = play("standard", hunters=hunters, max_cycles=3)
    painter = ArenaPainter(replay.config, size=size, layout=layout)
    frames = [painter.paint(world) for world in replay.worlds()]
    assert frames[-1].shape == (size[1], size[0], 3)
    assert not np.array_equal(frames[0], frames[-1])


@pytest.mark.parametrize(
    "size", [(319, 320), (320, 319), (3841, 2160), (3840, 2161), (500,), (500.0, 500), (True, 500), "500x500", None]
)
def test_sizes_that_cannot_be(size):
    with pytest.raises(ConfigError, match="size must be two whole numbers from 320 x 320 to 3840 x 2160, got"):
        checked_size(size)


def test_a_layout_that_is_none(match):
    with pytest.raises(ConfigError, match="layout must be broadcast or arena, got 'arean'; did you mean arena"):
        ArenaPainter(match.config, layout="arean")


def test_rgb_array_and_the_painter_agree():
    env = catch_arena.parallel_env("duel", render_mode="rgb_array")
    env.reset(seed=1)
    assert np.array_equal(env.render(), ArenaPainter(env.config).paint(env.world()))


def test_nothing_is_printed_no_display_is_opened_and_the_environment_stays_as_it_was():
    code = """
import os
from catch_arena import ArenaConfig, Engine
from catch_arena.render.raster import ArenaPainter
from catch_arena.render.sdl import pygame
engine = Engine(ArenaConfig())
engine.reset([1])
assert ArenaPainter(ArenaConfig()).paint(engine.world()).any()
assert not pygame.display.get_init()
assert "PYGAME_HIDE_SUPPORT_PROMPT" not in os.environ
"""
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER", "SDL_VIDEO_DRIVER", "PYGAME_HIDE_SUPPORT_PROMPT")
    bare = {name: value for name, value in os.environ.items() if name not in hidden}
    bare["PYTHONPATH"] = os.pathsep.join(sys.path)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=bare)
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
