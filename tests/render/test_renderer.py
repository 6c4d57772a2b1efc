"""Frames one after the other, and the painter behind `env.render()`."""

import numpy as np
import pytest

import catch_arena
from catch_arena.errors import ConfigError
from catch_arena.render.renderer import ArenaPainter, checked_size
from catch_arena.render.viewport import HUNTER_COLORS, Viewport


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
    viewport = Viewport(500, 472, worlds[0].side_m)
    for seat, hunter in enumerate(worlds[0].hunters):
        x, y = (round(part) for part in viewport.to_pixels(hunter.x, hunter.y))
        around = frame[28 + y - 14 : 28 + y + 14, x - 14 : x + 14].reshape(-1, 3).astype(int)
        nearest = np.abs(around - HUNTER_COLORS[seat]).sum(axis=1).min()
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


def test_a_painter_draws_the_way_to_a_world_and_ends_with_the_picture_of_it(match, worlds):
    at_once, on_the_way = ArenaPainter(match.config), ArenaPainter(match.config)
    assert on_the_way.enter(worlds[0]) == 0.0
    first = on_the_way.draw(1.0).copy()
    at_once.paint(worlds[0])
    assert on_the_way.enter(worlds[1]) == match.config.control_period_ms
    halfway = on_the_way.draw(0.5).copy()
    assert not np.array_equal(halfway, first)
    assert not np.array_equal(halfway, on_the_way.draw(1.0))
    drawn = on_the_way.draw(1.0)[..., :3].astype(int)
    assert np.abs(drawn - at_once.paint(worlds[1])).mean() < 0.1  # all but where a trail's pieces meet
