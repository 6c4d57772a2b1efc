"""Where the hunters are between two step boundaries, and which frame shows which instant."""

import itertools
import math
from fractions import Fraction

import pytest

from catch_arena.core.physics import TICK_MS
from catch_arena.render.timing import Clip, frame_spans
from catch_arena.replay.motion import interpolate, poses_of, step_motion


def test_the_ticks_lead_exactly_from_one_world_to_the_next(worlds):
    for before, after in itertools.pairwise(worlds):
        poses = step_motion(before, after).poses
        assert poses[0].hunters == poses_of(before).hunters
        assert poses[-1] == poses_of(after)
        assert len(poses) - 1 == after.time_ms // TICK_MS - before.time_ms // TICK_MS


def test_at_a_tick_the_tick_is_shown_and_between_two_the_line_between_them(worlds):
    step = step_motion(worlds[4], worlds[5])  # 400 ms is a tick's own time
    assert step.at(416.0) == step.poses[1]
    for pose, start, end in zip(step.at(424.0).hunters, step.poses[1].hunters, step.poses[2].hunters, strict=True):
        assert pose[:2] == pytest.approx(((start[0] + end[0]) / 2, (start[1] + end[1]) / 2), abs=1e-12)


def test_the_ticks_of_targets_lead_exactly_from_one_world_to_the_next(moving):
    """Those that were there drive by their own command, and along the wall; bit for bit, as the core moves them."""
    held = 0
    for before, after in itertools.pairwise(moving.worlds()):
        motion = step_motion(before, after)
        began = poses_of(before).targets
        for target in after.targets:
            ways = [poses.targets[target.number] for poses in motion.poses]
            assert ways[-1] == poses_of(after).targets[target.number]
            assert ways[0] == began.get(target.number, ways[-1])
            if target.number in began:
                strides = [math.dist(a[:2], b[:2]) for a, b in itertools.pairwise(ways)]
                assert max(strides) <= 0.016 * target.linear_velocity * (1 + 1e-9)
                assert target.at_wall or min(strides) == pytest.approx(0.016 * target.linear_velocity)
                held += target.at_wall
    assert held


def test_a_target_stands_until_the_step_after_it_appeared_and_goes_when_it_is_caught(moving):
    """R3.8: not at the instant at which it appears, nor where it was caught."""
    appeared = caught = 0
    for before, after in itertools.pairwise(moving.worlds()):
        motion = step_motion(before, after)
        old, new = ({target.number for target in world.targets} for world in (before, after))
        for number in new - old:
            assert len({poses.targets[number] for poses in motion.poses}) == 1
            appeared += 1
        for number in old - new:
            assert not any(number in poses.targets for poses in motion.poses)
            caught += 1
    assert appeared
    assert caught


def test_targets_glide_from_frame_to_frame(moving):
    """Nobody covers more ground between two frames than its speed allows, across steps too."""
    fps = 60
    last = {}
    fastest = 0.0
    for span in frame_spans(moving.worlds(), Clip(0, 6000, fps).times_ms):
        for time_ms in span.times_ms:
            targets = span.motion.at(time_ms, span.next_tick).targets
            for number in last.keys() & targets:
                fastest = max(fastest, math.dist(last[number][:2], targets[number][:2]))
            last = targets
    assert 0.9 * 1.5 / fps < fastest <= 1.5 / fps * 1.02


@pytest.mark.parametrize(("period_ms", "most"), [(3000, 200), (30_000, 640)])
def test_in_a_step_of_many_seconds_targets_go_on(play, period_ms, most):
    """R3.8: they have no watchdog. Those of more than ten seconds go straight to where they are in the end."""
    replay = play("duel", control_period_ms=period_ms, max_cycles=2, target_motion="wander", initial_targets=8)
    before, after = itertools.islice(replay.worlds(), 2)
    motion = step_motion(before, after)
    assert len(motion.poses) <= most
    ends = poses_of(after)
    for number, pose in motion.at(period_ms - 1.0).targets.items():
        assert pose[:2] == pytest.approx(ends.targets[number][:2], abs=0.002 * 1.0 * 16)
    for pose, end in zip(motion.at(period_ms - 1.0).hunters, ends.hunters, strict=True):
        assert pose[:2] == pytest.approx(end[:2])
    if period_ms == 3000:  # on after the second in which hunters drive
        early, late = motion.at(1100.0), motion.at(2900.0)
        assert early.hunters == late.hunters
        assert any(early.targets[number] != late.targets[number] for number in early.targets)


def test_turning_takes_the_shorter_way():
    _, _, theta = interpolate((0.0, 0.0, 3.0), (0.0, 0.0, -3.0), 0.5)
    assert math.cos(theta) == pytest.approx(-1.0)


@pytest.mark.parametrize("speed", [Fraction(1), Fraction(1, 3), Fraction(7)])
@pytest.mark.parametrize("fps", [1, 7, 25, 60, 240])
@pytest.mark.parametrize("period", [16, 33, 100, 1500])
def test_every_frame_belongs_to_one_step_and_lies_in_it(play, fps, period, speed):
    replay = play("duel", control_period_ms=period, max_cycles=6)
    clip = Clip(0, 6 * period, fps, speed)
    shown = []
    for span in frame_spans(replay.worlds(), clip.times_ms):
        for time_ms in span.times_ms:
            assert span.motion.before.time_ms <= time_ms < span.motion.after.time_ms or time_ms == 0
            shown.append(time_ms)
    assert shown == clip.times_ms == [pytest.approx(1000 * float(speed) * k / fps) for k in range(clip.frames)]


def test_a_part_of_a_match_begins_and_ends_where_it_is_told_and_no_later_step_is_played(match):
    clip = Clip(1250, 2000, 60)
    read = list(frame_spans(match.worlds(), clip.times_ms))
    frames = [(span.motion, time_ms) for span in read for time_ms in span.times_ms]
    assert len(frames) == 45
    assert frames[0][1] == 1250.0
    assert frames[0][0].before.time_ms == 1200
    assert read[0].motion.before.time_ms == 0  # what came before is told, without frames
    assert read[-1].motion.after.time_ms == 2000


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


def test_the_ticks_between_two_instants_are_each_told_once(worlds):
    step = step_motion(worlds[3], worlds[4])  # 300 to 400 ms: ticks at 304, 320, ... 400
    assert step.ticks_between(300.0, 400.0) == list(step.poses[1:])
    assert step.ticks_between(304.0, 336.0) == list(step.poses[2:4])
    assert step.ticks_between(305.0, 319.0) == []


def test_motion_is_smooth_across_step_boundaries(match):
    """Nobody covers more ground between two frames than its speed allows, which a tick's lag would break."""
    fps = 60
    limit = match.config.max_speed_mps / fps * 1.02
    last = None
    fastest = 0.0
    for span in frame_spans(match.worlds(), Clip(0, 3000, fps).times_ms):
        for time_ms in span.times_ms:
            poses = span.motion.at(time_ms, span.next_tick).hunters
            if last is not None:
                fastest = max(fastest, *(math.dist(a[:2], b[:2]) for a, b in zip(last, poses, strict=True)))
            last = poses
    assert 0.9 * match.config.max_speed_mps / fps < fastest <= limit


def test_in_a_step_of_many_seconds_everybody_stands_after_the_first(play):
    """R2.4: the watchdog; and the list of ticks does not grow with the period."""
    worlds = list(play("duel", control_period_ms=10_000, max_cycles=2).worlds())
    step = step_motion(worlds[0], worlds[1])
    assert len(step.poses) <= 64
    assert step.at(1100.0) == step.at(9_999.0)
    for shown, there in zip(step.at(9_999.0).hunters, poses_of(worlds[1]).hunters, strict=True):
        assert shown[:2] == pytest.approx(there[:2])
        assert math.cos(shown[2] - there[2]) == pytest.approx(1.0)
    assert step.at(0.0).hunters[0][:2] == pytest.approx(poses_of(worlds[0]).hunters[0][:2])


def test_only_two_steps_ahead_are_read(match):
    read = 0

    def counted():
        nonlocal read
        for world in match.worlds():
            read += 1
            yield world

    for index, _ in enumerate(frame_spans(counted(), Clip(0, 3000, 60).times_ms)):
        assert read <= index + 3


def test_a_match_without_steps_is_one_picture(worlds):
    (span,) = frame_spans(worlds[:1], [0.0])
    assert span.times_ms == [0.0]
    assert span.motion.at(0.0) == poses_of(worlds[0])
