"""Frames one after the other, and the painter behind `env.render()`."""

import math

import numpy as np
import pytest

import catch_arena
from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.render.match_info import HUNTER_COLORS, MatchInfo
from catch_arena.render.raster import Ground
from catch_arena.render.renderer import ArenaPainter, checked_size
from catch_arena.render.sprites import SpriteCache
from catch_arena.render.timing import Clip, frame_spans
from catch_arena.render.video import rendered_frames, renderer_for
from catch_arena.render.viewport import TARGET_TRAIL, Viewport


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
    with pytest.raises(ConfigError, match="layout must be one of broadcast, arena, got 'arean'; did you mean arena"):
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


def test_moving_targets_leave_trails_of_a_colour_of_their_own_which_fade_to_nothing(moving):
    """And still ones leave none; nothing of a target's trail stays in the trace of the hunters' ways."""
    info = MatchInfo.of(ArenaConfig(hunters=64))
    ground = Ground(Viewport(1200, 1200, moving.config.side_m), SpriteCache())
    clean = ground.pixels.copy()
    ground.target_trail((2.0, 2.0, 0.0), (6.0, 2.0, 0.0))
    x, y = (round(part) for part in ground.viewport.to_pixels(4.0, 2.0))
    assert tuple(ground.pixels[y, x, :3]) == TARGET_TRAIL
    assert TARGET_TRAIL not in info.colors
    ground.fade(30_000.0)
    assert np.array_equal(ground.pixels, clean)


def test_a_film_of_moving_targets_shows_them_where_they_are(moving):
    """Sixty frames of a second: each target's white is at its place, and behind the fast ones lies their sand."""
    renderer = renderer_for(moving, (400, 400), "arena")
    clip = Clip(3000, 4000, 60)
    shown = trails = 0
    for span in frame_spans(moving.worlds(), clip.times_ms):
        renderer.enter(span.motion)
        for time_ms in span.times_ms:
            poses = span.motion.at(time_ms, span.next_tick)
            pixels = renderer.draw(time_ms, poses)[renderer.arena.top :].astype(int)
            viewport = Viewport(*renderer.arena[2:], moving.config.side_m)
            apart = {
                number: min(math.dist(pose[:2], other[:2]) for other in poses.hunters)
                for number, pose in poses.targets.items()
            }
            for target in span.motion.after.targets:
                if apart[target.number] < 1.2 or target.spawned_ms > time_ms:
                    continue
                x, y = (round(part) for part in viewport.to_pixels(*poses.targets[target.number][:2]))
                assert pixels[max(0, y - 6) : y + 7, max(0, x - 6) : x + 7, :3].min(axis=2).max() > 150
                shown += 1
            trails += int((np.abs(pixels[..., :3] - TARGET_TRAIL).sum(axis=2) < 30).sum())
    assert shown > 200
    assert trails > 1000


def test_a_view_is_drawn_where_it_is_asked_for_and_changes_nothing_else(play):
    """Within the radius only, and not under who is withdrawn."""
    replay = play(time_limit_s=2.0, view_radius_m=2.0)
    drawn = []
    for view_of in (None, 0):
        renderer = renderer_for(replay, (400, 400), "arena")
        renderer.view_of = view_of
        (pixels,) = (pixels.copy() for pixels in rendered_frames(replay, renderer, Clip(1500, 1500, 60)))
        drawn.append(pixels[renderer.arena.top :, :, :3].astype(int))
    (span,) = (span for span in frame_spans(replay.worlds(), [1500.0]) if span.times_ms)
    viewport = Viewport(*renderer.arena[2:], replay.config.side_m)
    x, y = viewport.to_pixels(*span.motion.at(1500.0).hunters[0][:2])
    rows, columns = np.nonzero(np.abs(drawn[1] - drawn[0]).sum(axis=2))
    far = np.hypot(columns + 0.5 - x, rows + 0.5 - y)
    assert 0.8 * 2.0 * viewport.scale < far.max() < 2.0 * viewport.scale + viewport.hunter_length
    assert len(far) > 1000
