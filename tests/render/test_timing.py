"""Single instants, and clips of different pace one after the other."""

from fractions import Fraction

from hypothesis import given, settings
from hypothesis import strategies as st
from render.videos import SMALL

from catch_arena.render.timing import Clip, ClipSequence, Snapshots
from catch_arena.render.video import rendered_frames, renderer_for


@settings(deadline=None, max_examples=50)
@given(
    lengths=st.lists(st.integers(1, 1000), min_size=1, max_size=4),
    speeds=st.lists(st.sampled_from([Fraction(1), Fraction(1, 4), Fraction(3)]), min_size=4, max_size=4),
    fps=st.sampled_from([24, 25, 30, 60]),
)
def test_the_frames_of_a_sequence_go_forward_and_are_counted_at_every_instant(lengths, speeds, fps):
    clips, start = [], 500
    for length, speed in zip(lengths, speeds, strict=False):
        clips.append(Clip(start, start + length, fps, speed))
        start += length
    sequence = ClipSequence(tuple(clips))
    times = [sequence.time_ms(frame) for frame in range(sequence.frames)]
    assert times == sorted(set(times))
    assert all(500 <= time < start for time in times)
    for instant in range(0, start + 200, 50):
        assert sequence.frames_before(instant) == sum(time < instant for time in times)


def test_slow_motion_takes_its_share_of_the_frames():
    sequence = ClipSequence((Clip(0, 1000, 60), Clip(1000, 2000, 60, Fraction(1, 4)), Clip(2000, 3000, 60)))
    assert sequence.frames == 60 + 240 + 60
    assert sequence.clip_of(59)[0].speed == sequence.clip_of(300)[0].speed == 1
    assert sequence.clip_of(60)[0].speed == sequence.clip_of(299)[0].speed == Fraction(1, 4)


def test_snapshots_are_the_frames_that_a_video_has_at_those_instants(match):
    whole = Clip(0, 3000, 10)
    renderer = renderer_for(match, SMALL["size"], "broadcast")
    video = [pixels.copy() for pixels in rendered_frames(match, renderer, whole)]
    renderer = renderer_for(match, SMALL["size"], "broadcast")
    stills = [pixels.copy() for pixels in rendered_frames(match, renderer, Snapshots((0.0, 700.0, 700.0, 2500.0)))]
    assert len(stills) == 4
    for still, frame in zip(stills, (video[0], video[7], video[7], video[25]), strict=True):
        # what fades does so a little otherwise where frames are left out
        assert abs(still.astype(int) - frame).mean() < 1.5
