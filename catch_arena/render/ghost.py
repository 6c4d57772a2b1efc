"""Ghost of a hunter in a video: its way with the actions that would have won a contest, and the answer in words."""

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Final

from catch_arena.core.physics import TICK_MS
from catch_arena.explanation.what_if import WhatIf
from catch_arena.render import hud
from catch_arena.render.encoders import Pixels
from catch_arena.render.renderer import MatchRenderer
from catch_arena.render.shapes import WHITE, Box, Color, Label, Path, Shape, Turtle, mix
from catch_arena.render.text import text_width
from catch_arena.render.viewport import Viewport
from catch_arena.replay.motion import Pose2D, interpolate, poses_of, step_motion

BEFORE_MS: Final = 2000
AFTER_MS: Final = 1500
"""Parts of the match that are shown before and after the contest [ms]."""
_LOW: Final = 0.25
"""Part of the arena's height below which the ghost's way ends near the words, so that they stand at the top."""


def with_ghost(
    pictures: Iterable[Pixels], renderer: MatchRenderer, times_ms: Sequence[float], answer: WhatIf, *, words: bool
) -> Iterator[Pixels]:
    """Yield the pictures of a match with the ghost of an answer, and the answer's sentence.

    Args:
        pictures: frames in the renderer's buffer.
        renderer: the renderer that draws them.
        times_ms: the instants of the frames.
        answer: the answer.
        words: whether to show the sentence.
    """
    viewport = Viewport(renderer.arena.width, renderer.arena.height, renderer.info.config.side_m)
    color, track = renderer.info.color(answer.seat), ghost_track(answer)
    at_top = bool(track) and track[-1][1][1] < _LOW * viewport.side_m
    for pixels, time_ms in zip(pictures, times_ms, strict=True):
        renderer.draw_over(ghost_shapes(viewport, color, track, time_ms))
        if words:
            renderer.draw_over(_sentence_shapes(viewport, color, answer.sentence, at_top=at_top))
        yield pixels


def ghost_track(answer: WhatIf) -> list[tuple[float, Pose2D]]:
    """Return the ghost's poses, each with its instant [ms]: at the first changed step, and then at each tick."""
    if answer.alternative is None:
        return []
    first, seat = min(answer.actions), answer.seat
    worlds = [world for world in answer.alternative.worlds() if world.step >= first]
    track = [(float(worlds[0].time_ms), poses_of(worlds[0]).hunters[seat])]
    for before, after in pairwise(worlds):
        tick = before.time_ms // TICK_MS
        poses = step_motion(before, after).poses[1:]
        track += [(float((tick + count) * TICK_MS), pose.hunters[seat]) for count, pose in enumerate(poses, start=1)]
    return track


def ghost_shapes(
    viewport: Viewport, color: Color, track: Sequence[tuple[float, Pose2D]], time_ms: float
) -> list[Shape]:
    """Return the ghost's way up to an instant, and the ghost: a faded turtle, which stays at the end of its way."""
    passed = bisect_right(track, time_ms, key=lambda moment: moment[0])
    if not passed:
        return []
    began_ms, pose = track[passed - 1]
    if passed < len(track):
        next_ms, next_pose = track[passed]
        pose = interpolate(pose, next_pose, (time_ms - began_ms) / (next_ms - began_ms))
    x, y, theta = pose
    points = [*(track_pose for _, track_pose in track[:passed]), pose]
    return [
        Path(tuple(viewport.to_pixels(*point[:2]) for point in points), viewport.trail_width, mix(color, WHITE, 0.5)),
        Turtle(*viewport.to_pixels(x, y), theta, viewport.hunter_length, color, faded=True),
    ]


def _sentence_shapes(viewport: Viewport, color: Color, sentence: str, *, at_top: bool) -> list[Shape]:
    """Return the shapes of a sentence in as many lines as it needs, in a box at the bottom or top of the arena."""
    size = hud.font_size(0.021 * min(viewport.width, viewport.height), 10)
    gap, lines = 0.6 * size, [""]
    for word in sentence.split():
        longer = f"{lines[-1]} {word}".strip()
        if text_width(longer, size, 600) <= viewport.width - 7.0 * gap:
            lines[-1] = longer
        else:
            lines.append(word)
    height = 1.35 * size * len(lines) + gap
    top = gap if at_top else viewport.height - gap - height
    first = top + 0.5 * gap + 0.68 * size
    return [
        Box(gap, top, viewport.width - 2.0 * gap, height, hud.PANEL, gap),
        Box(2.0 * gap, first - 0.4 * size, 0.8 * size, 0.8 * size, color, 0.4 * size),
        *(Label(5.0 * gap, first + 1.35 * size * row, line, size, hud.BRIGHT, 600) for row, line in enumerate(lines)),
    ]
