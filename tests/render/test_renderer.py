"""`env.render()` returns a fresh frame of the size that was asked for."""

import numpy as np
import pytest

import catch_arena
from catch_arena.errors import ConfigError
from catch_arena.render.renderer import ArenaPainter, checked_size


def test_frames_are_fresh_arrays_of_the_size_asked_for(match, worlds):
    painter = ArenaPainter(match.config, size=(500, 400))
    first = painter.paint(worlds[0])
    kept = first.copy()
    second = painter.paint(worlds[10])
    assert first.shape == (400, 500, 3)
    assert first.dtype == np.uint8
    assert first.flags.owndata or first.base is None or not np.shares_memory(first, painter._renderer.pixels)
    assert not np.shares_memory(first, second)
    assert np.array_equal(first, kept)
    assert not np.array_equal(first, second)
    first[:] = 0  # whoever owns a frame may write on it
    assert second.any()


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
    with pytest.raises(ConfigError, match="layout must be one of broadcast, arena, got 'arean'"):
        ArenaPainter(match.config, layout="arean")


def test_rgb_array_and_the_painter_agree():
    env = catch_arena.parallel_env("duel", render_mode="rgb_array")
    env.reset(seed=1)
    assert np.array_equal(env.render(), ArenaPainter(env.config).paint(env.world()))
