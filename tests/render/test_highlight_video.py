"""The video of highlights has captions, slow motion, and every frame of each highlight."""

import numpy as np
import pytest
from render.videos import decoded

from catch_arena.errors import ConfigError
from catch_arena.explanation.highlights import Highlight
from catch_arena.render import hud
from catch_arena.render.highlight_video import (
    highlight_shapes,
    render_highlights,
    slow_motion,
)
from catch_arena.render.shapes import Label

HIGHLIGHT = Highlight("contest", 500, 1500, 2500, 0.9, "bob beats ann by 0.21 mm", "the nearest wins", "R5.4")
AREA = hud.Rect(0, 300, 640, 60)


@pytest.mark.parametrize(
    ("captions", "reason"), [("plain", "the nearest wins"), ("clauses", "the nearest wins (R5.4)")]
)
def test_the_caption_says_what_and_why(captions, reason):
    shapes = highlight_shapes(AREA, HIGHLIGHT, captions)
    assert [shape.text for shape in shapes if isinstance(shape, Label)] == [HIGHLIGHT.event, reason]


def test_time_runs_slowly_about_the_decisive_instant_only():
    times = slow_motion(HIGHLIGHT, 60)
    assert times[0] == 500
    assert 2480 < times[-1] < 2500
    assert times == sorted(times)
    assert sum(1100 <= time_ms < 2000 for time_ms in times) == 60 * 0.9 * 4


def test_the_video_has_every_frame_of_every_highlight(match, tmp_path):
    path = tmp_path / "m.replay"
    match.save(path)
    late = Highlight("finish", 2000, 2900, 4400, 0.5, "ann 3, bob 2 at the end", "One catch decides", "R6.1")
    report = render_highlights(
        [(str(path), HIGHLIGHT), (str(path), late)],
        tmp_path / "best.mp4",
        size=(480, 320),
        fps=20,
    )
    frames = decoded(report.path)
    assert len(frames) == report.frames == len(slow_motion(HIGHLIGHT, 20)) + len(slow_motion(late, 20))
    brightness = [float(frame.mean()) for frame in frames]
    second = len(slow_motion(HIGHLIGHT, 20))
    assert max(brightness[0], brightness[second - 1], brightness[second]) < 0.8 * np.median(brightness)  # fades
    caption = frames[20][-38:].astype(int)
    assert (caption.max(axis=2) > 200).any()  # there are words


def test_without_highlights_there_is_no_video(tmp_path):
    with pytest.raises(ConfigError, match="at least one entry"):
        render_highlights([], tmp_path / "best.mp4")
    assert list(tmp_path.iterdir()) == []
