"""Frames of single instants equal the frames of a video at the same instants."""

from render.videos import SMALL

from catch_arena.render.timing import Clip
from catch_arena.render.video import frames_of, rendered_frames, renderer_for


def test_single_instants_are_the_frames_that_a_video_has_there(match):
    renderer = renderer_for(match, SMALL["size"], "broadcast")
    video = [pixels.copy() for pixels in rendered_frames(match, renderer, Clip(0, 3000, 10))]
    renderer = renderer_for(match, SMALL["size"], "broadcast")
    times = [0.0, 700.0, 700.0, 2500.0]
    stills = [pixels.copy() for pixels in frames_of(match.worlds(), renderer, times)]
    assert len(stills) == 4
    for still, frame in zip(stills, (video[0], video[7], video[7], video[25]), strict=True):
        # what fades does so a little otherwise where frames are left out
        assert abs(still.astype(int) - frame).mean() < 1.5
