"""Ghost of a hunter: its way with the actions that would have won a contest, and the answer in words.

The page's player shows the same ghost (player/page/overlays.js).
"""

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence

from catch_arena.explanation.what_if import WhatIf
from catch_arena.render.captions import LOW, panel_shapes
from catch_arena.render.raster import Pixels
from catch_arena.render.renderer import MatchRenderer
from catch_arena.render.shapes import WHITE, Color, Path, Shape, Turtle, mix
from catch_arena.render.viewport import Viewport
from catch_arena.replay.motion import Pose2D, interpolate, poses_of


def with_ghost(
    pictures: Iterable[Pixels], renderer: MatchRenderer, times_ms: Sequence[float], answer: WhatIf, *, words: bool
) -> Iterator[Pixels]:
    """Yield the renderer's pictures of a match with the ghost of an answer, and with `words` the answer's sentence."""
    viewport = renderer.viewport
    color, track = renderer.info.colors[answer.seat], ghost_track(answer)
    at_top = is_low(track, viewport.side_m)
    for pixels, time_ms in zip(pictures, times_ms, strict=True):
        renderer.draw_over(ghost_shapes(viewport, color, track, time_ms))
        if words:
            renderer.draw_over(panel_shapes(viewport, color, answer.sentence, at_top=at_top, whole=True))
        yield pixels


def is_low(track: Sequence[tuple[float, Pose2D]], side_m: float) -> bool:
    """Return whether a ghost's way ends so low in the arena that the answer stands at the top."""
    return bool(track) and track[-1][1][1] < LOW * side_m


def ghost_track(answer: WhatIf) -> list[tuple[float, Pose2D]]:
    """Return the ghost's poses in each state from the first changed step on, with their instants [ms]."""
    if answer.alternative is None:
        return []
    worlds = [world for world in answer.alternative.worlds() if world.step >= min(answer.actions)]
    return [(float(world.time_ms), poses_of(world).hunters[answer.seat]) for world in worlds]


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
