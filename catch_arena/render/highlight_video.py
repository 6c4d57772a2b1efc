"""Video of highlights: slow motion around the decisive instant, and a caption."""

import os
from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Final

import numpy as np

from catch_arena.errors import ConfigError
from catch_arena.explanation.highlights import Highlight
from catch_arena.render import hud
from catch_arena.render.captions import Captions, in_words
from catch_arena.render.cards import GOLD
from catch_arena.render.encoders import Progress
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.optional_imports import cv2
from catch_arena.render.raster import Canvas, Pixels
from catch_arena.render.renderer import MatchRenderer
from catch_arena.render.shapes import Box, Label, Shape
from catch_arena.render.timing import Clip
from catch_arena.render.video import RenderReport, VideoOutput, frames_of, observed_worlds
from catch_arena.replay import Replay

SLOW: Final = Fraction(1, 4)
_SLOW_FROM_MS: Final = 400
_SLOW_TO_MS: Final = 500
_FADE_S: Final = 0.2
_CAPTION: Final = 0.13
"""Height of the caption as a part of the picture's."""


def render_highlights(
    highlights: Sequence[tuple[str, Highlight]],
    path: str | os.PathLike[str],
    *,
    size: tuple[int, int] | None = None,
    shape: hud.FrameShape | None = None,
    fps: int | None = None,
    captions: Captions = "plain",
    progress: Progress | None = None,
) -> RenderReport:
    """Write highlights as one video, in their order; memory holds one match at a time.

    Each highlight comes with the path of its replay. The other arguments and the errors are those of
    `video.render_replay`. Raises ConfigError without a highlight.
    """
    if not highlights:
        raise ConfigError("highlights must have at least one entry, got none")
    output = VideoOutput.of(path, size, shape, fps)
    frames = sum(len(slow_motion(highlight, output.fps)) for _, highlight in highlights)
    return output.write(_pictures(highlights, output.size, output.fps, captions), frames, progress)


def slow_motion(highlight: Highlight, fps: int) -> list[float]:
    """Return the instants of a highlight's frames [ms], in slow motion near the decisive one."""
    start, end = highlight.start_ms, highlight.end_ms
    slow_ms, fast_ms = max(start, highlight.decisive_ms - _SLOW_FROM_MS), min(end, highlight.decisive_ms + _SLOW_TO_MS)
    parts = (Clip(start, slow_ms, fps), Clip(slow_ms, fast_ms, fps, SLOW), Clip(fast_ms, end, fps))
    return [time_ms for part in parts for time_ms in part.times_ms if time_ms < part.end_ms]


def _pictures(
    highlights: Sequence[tuple[str, Highlight]], size: tuple[int, int], fps: int, captions: Captions
) -> Iterator[Pixels]:
    width, height = size
    frame = Canvas.blank(width, height, hud.PANEL)
    below = 0 if captions == "none" else round(_CAPTION * height)
    caption = hud.Rect(0, height - below, width, below)
    for number, (path, highlight) in enumerate(highlights, start=1):
        replay = Replay.load(path)
        info = MatchInfo.of_replay(replay, f"{replay.title or Path(path).stem}   {number} of {len(highlights)}")
        renderer = MatchRenderer(info, (width, height - below), "broadcast", replay.seed, captions="none")
        frame.clear(caption, hud.CARD)
        if below:
            frame.draw(highlight_shapes(caption, highlight, captions))
        times = slow_motion(highlight, fps)
        for done, pixels in enumerate(frames_of(observed_worlds(replay, renderer), renderer, times)):
            frame.pixels[: height - below] = pixels
            seen = min(1.0, (done + 1) / (_FADE_S * fps), (len(times) - done) / (_FADE_S * fps))
            yield (
                frame.pixels
                if seen == 1.0
                else np.asarray(cv2.convertScaleAbs(frame.pixels, alpha=seen), dtype=np.uint8)
            )


def highlight_shapes(area: hud.Rect, highlight: Highlight, captions: Captions) -> list[Shape]:
    """Return the shapes of the panel below the picture: the event, and below it the reason."""
    reason = in_words(highlight.reason, highlight.clause, captions)
    big, small = hud.font_size(0.3 * area.height, 12), hud.font_size(0.18 * area.height, 10)
    left, upper, lower = 0.2 * area.height, area.top + 0.34 * area.height, area.top + 0.72 * area.height
    room = area.width - 2.0 * left
    return [
        Box(area.left, area.top, area.width, max(2.0, 0.03 * area.height), GOLD),
        Label(area.left + left, upper, highlight.event, big, hud.BRIGHT, 800, max_width=room),
        Label(area.left + left, lower, reason, small, hud.BRIGHT, 500, max_width=room),
    ]
