"""Poses between two step boundaries follow the core's ticks, and each frame shows its instant."""

import itertools
import math
from fractions import Fraction

import pytest

from catch_arena.core.physics import TICK_MS
from catch_arena.render.timing import Clip, frame_spans
from catch_arena.replay.motion import poses_of, step_motion


def test_the_ticks_lead_exactly_from_one_world_to_the_next(worlds):
    for before, after in itertools.pairwise(worlds):
        poses = step_motion(before, after).poses
        assert poses[0].hunters == poses_of(before).hunters
        assert poses[-1] == poses_of(after)
        assert len(poses) - 1 == after.time_ms // TICK_MS - before.time_ms // TICK_MS


@pytest.mark.parametrize("speed", [Fraction(1), Fraction(1, 3), Fraction(7)])
@pytest.mark.parametrize("fps", [1, 7, 25, 60, 240])
@pytest.mark.parametrize("period", [16, 33, 100, 1500])
def test_every_frame_belongs_to_one_step_and_lies_in_it(play, fps, period, speed):
    replay = play("duel", control_period_ms=period, max_cycles=6)
    clip = Clip(0, 6 * period, fps, speed)
    shown = []
    for motion, times_ms, _ in frame_spans(replay.worlds(), clip.times_ms):
        for time_ms in times_ms:
            assert motion.before.time_ms <= time_ms < motion.after.time_ms or time_ms == 0
            shown.append(time_ms)
    assert shown == clip.times_ms == [pytest.approx(1000 * float(speed) * k / fps) for k in range(clip.frames)]


def test_a_part_of_a_match_begins_and_ends_where_it_is_told_and_no_later_step_is_played(match):
    clip = Clip(1250, 2000, 60)
    read = list(frame_spans(match.worlds(), clip.times_ms))
    frames = [(motion, time_ms) for motion, times_ms, _ in read for time_ms in times_ms]
    assert len(frames) == 45
    assert frames[0][1] == 1250.0
    assert frames[0][0].before.time_ms == 1200
    assert read[0][0].before.time_ms == 0  # the step before the first frame comes too, without frames
    assert read[-1][0].after.time_ms == 2000


@pytest.mark.parametrize(
    ("start", "end", "fps", "speed", "frames"),
    [
        (0, 60_000, 60, 1, 3600),
        (0, 0, 60, 1, 1),
        (0, 100, 60, 1, 6),
        (0, 25, 60, 1, 2),
        (0, 33, 30, 1, 1),
        (5_000, 6_000, 60, Fraction(1, 4), 240),
        (0, 60_000, 25, 8, 188),
    ],
)
def test_a_video_is_as_long_as_its_part_of_the_match(start, end, fps, speed, frames):
    clip = Clip(start, end, fps, Fraction(speed))
    assert clip.frames == frames
    assert clip.times_ms[-1] <= end


def test_motion_is_smooth_across_step_boundaries(match):
    """No hunter moves farther between two frames than its speed allows."""
    fps = 60
    limit = match.config.max_speed_mps / fps * 1.02
    last = None
    fastest = 0.0
    for motion, times_ms, next_tick in frame_spans(match.worlds(), Clip(0, 3000, fps).times_ms):
        for time_ms in times_ms:
            poses = motion.at(time_ms, next_tick).hunters
            if last is not None:
                fastest = max(fastest, *(math.dist(a[:2], b[:2]) for a, b in zip(last, poses, strict=True)))
            last = poses
    assert 0.9 * match.config.max_speed_mps / fps < fastest <= limit
