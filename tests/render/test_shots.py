"""Chosen instants, and cuts of different pace one after the other."""

from fractions import Fraction

from hypothesis import given, settings
from hypothesis import strategies as st
from render.films import SMALL

from catch_arena.render.motion import Cut
from catch_arena.render.shots import Splice, Stills
from catch_arena.render.video import filmed, stage_of


@settings(deadline=None, max_examples=50)
@given(
    lengths=st.lists(st.integers(1, 1000), min_size=1, max_size=4),
    speeds=st.lists(st.sampled_from([Fraction(1), Fraction(1, 4), Fraction(3)]), min_size=4, max_size=4),
    fps=st.sampled_from([24, 25, 30, 60]),
)
def test_the_frames_of_a_splice_go_forward_and_are_counted_at_every_instant(lengths, speeds, fps):
    cuts, start = [], 500
    for length, speed in zip(lengths, speeds, strict=False):
        cuts.append(Cut(start, start + length, fps, speed))
        start += length
    splice = Splice(tuple(cuts))
    times = [splice.time_ms(frame) for frame in range(splice.frames)]
    assert times == sorted(set(times))
    assert all(500 <= time < start for time in times)
    for instant in range(0, start + 200, 50):
        assert splice.frames_before(instant) == sum(time < instant for time in times)


def test_slow_motion_takes_its_share_of_the_frames():
    splice = Splice((Cut(0, 1000, 60), Cut(1000, 2000, 60, Fraction(1, 4)), Cut(2000, 3000, 60)))
    assert splice.frames == 60 + 240 + 60
    assert splice.cut_of(59)[0].speed == splice.cut_of(300)[0].speed == 1
    assert splice.cut_of(60)[0].speed == splice.cut_of(299)[0].speed == Fraction(1, 4)


def test_stills_are_the_frames_that_a_film_has_at_those_instants(match):
    whole = Cut(0, 3000, 10)
    stage = stage_of(match, SMALL["size"], "broadcast")
    film = [pixels.copy() for pixels in filmed(match, stage, whole)]
    stage = stage_of(match, SMALL["size"], "broadcast")
    stills = [pixels.copy() for pixels in filmed(match, stage, Stills((0.0, 700.0, 700.0, 2500.0)))]
    assert len(stills) == 4
    for still, frame in zip(stills, (film[0], film[7], film[7], film[25]), strict=True):
        # what fades does so a little otherwise where frames are left out
        assert abs(still.astype(int) - frame).mean() < 1.5
