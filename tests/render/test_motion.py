"""Where the hunters are between two step boundaries."""

import itertools
import math

import pytest

from catch_arena.render.motion import TICK_MS, between, leg, passages
from catch_arena.render.video import frame_count


def poses_of(world) -> tuple:
    return tuple((hunter.x, hunter.y, hunter.theta) for hunter in world.hunters)


def test_the_ticks_lead_exactly_from_one_world_to_the_next(worlds):
    for before, after in itertools.pairwise(worlds):
        poses = leg(before, after).poses
        assert poses[0] == poses_of(before)
        assert poses[-1] == poses_of(after)
        assert len(poses) - 1 == after.time_ms // TICK_MS - before.time_ms // TICK_MS


def test_at_a_tick_the_tick_is_shown_and_between_two_the_line_between_them(worlds):
    step = leg(worlds[4], worlds[5])  # 400 ms is a tick's own time
    assert step.at(416.0) == step.poses[1]
    for pose, start, end in zip(step.at(424.0), step.poses[1], step.poses[2], strict=True):
        assert pose[:2] == pytest.approx(((start[0] + end[0]) / 2, (start[1] + end[1]) / 2), abs=1e-12)


def test_turning_takes_the_shorter_way():
    _, _, theta = between((0.0, 0.0, 3.0), (0.0, 0.0, -3.0), 0.5)
    assert math.cos(theta) == pytest.approx(-1.0)


@pytest.mark.parametrize("fps", [1, 7, 25, 60, 144, 240])
@pytest.mark.parametrize("period", [16, 33, 100, 1500])
def test_every_frame_belongs_to_one_step_and_lies_in_it(play, fps, period):
    replay = play("duel", control_period_ms=period, max_cycles=6)
    frames = frame_count(6 * period, fps)
    shown = []
    for passage in passages(replay.worlds(), fps, frames):
        for frame in passage.frames:
            assert passage.leg.before.time_ms <= 1000 * frame / fps < passage.leg.after.time_ms or frame == 0
            shown.append(frame)
    assert shown == list(range(frames))


def test_motion_is_smooth_across_step_boundaries(match):
    """Nobody covers more ground between two frames than its speed allows, which a tick's lag would break."""
    fps = 60
    limit = match.config.max_speed_mps / fps * 1.02
    last = None
    fastest = 0.0
    for passage in passages(match.worlds(), fps, 180):
        for frame in passage.frames:
            poses = passage.leg.at(1000.0 * frame / fps, passage.next_tick)
            if last is not None:
                fastest = max(fastest, *(math.dist(a[:2], b[:2]) for a, b in zip(last, poses, strict=True)))
            last = poses
    assert 0.9 * match.config.max_speed_mps / fps < fastest <= limit


def test_in_a_step_of_many_seconds_everybody_stands_after_the_first(play):
    """R2.4: the watchdog; and the list of ticks does not grow with the period."""
    worlds = list(play("duel", control_period_ms=10_000, max_cycles=2).worlds())
    step = leg(worlds[0], worlds[1])
    assert len(step.poses) <= 64
    assert step.at(1100.0) == step.at(9_999.0)
    for shown, there in zip(step.at(9_999.0), poses_of(worlds[1]), strict=True):
        assert shown[:2] == pytest.approx(there[:2])
        assert math.cos(shown[2] - there[2]) == pytest.approx(1.0)
    assert step.at(0.0)[0][:2] == pytest.approx(poses_of(worlds[0])[0][:2])


def test_only_two_steps_ahead_are_read(match):
    read = 0

    def counted():
        nonlocal read
        for world in match.worlds():
            read += 1
            yield world

    for index, _ in enumerate(passages(counted(), 60, 180)):
        assert read <= index + 3


def test_a_match_without_steps_is_one_picture(worlds):
    (passage,) = passages(worlds[:1], 60, 1)
    assert list(passage.frames) == [0]
    assert passage.leg.at(0.0) == poses_of(worlds[0])
