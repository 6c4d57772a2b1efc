"""What a frame of the arena shows, as shapes.

Pure functions of the world, of the hunters' poses at an instant, and of what was ruled lately.
World units are metres, y up; shapes are in pixels, y down. raster.py turns shapes into pixels.
"""

import math
from collections.abc import Sequence
from typing import Final

from catch_arena.render.annotations import Annotation, annotation_shapes
from catch_arena.render.shapes import WHITE, Box, Color, Polygon, Ring, Shape, Stroke, Turtle, mix
from catch_arena.render.viewport import GROUND, TARGET, TRACE, MatchInfo, Pose, Viewport
from catch_arena.world import HunterState, TargetState

WALL: Final[Color] = (112, 127, 255)
GRID: Final[Color] = (78, 95, 255)
SPAWN_MS: Final = 450.0
"""How long the ring about a new target is seen."""


def ground_shapes(viewport: Viewport) -> list[Shape]:
    """What lies under everything and never changes: the square within its walls, and a grid of whole metres."""
    left, bottom = viewport.to_pixels(0.0, 0.0)
    side = viewport.side_m * viewport.scale
    top = bottom - side
    shapes: list[Shape] = [Box(left, top, side, side, GROUND)]
    spacing = next(
        step * 10.0**power
        for power in range(5)
        for step in (1.0, 2.0, 5.0)
        if step * 10.0**power * viewport.scale >= 24
    )
    for line in range(1, math.ceil(viewport.side_m / spacing)):
        x, y = viewport.to_pixels(line * spacing, line * spacing)
        shapes += [Stroke(x, top, x, bottom, 1.0, GRID), Stroke(left, y, left + side, y, 1.0, GRID)]
    corners = ((left, bottom), (left + side, bottom), (left + side, top), (left, top))
    shapes += [Stroke(*a, *b, 1.0, WALL) for a, b in zip(corners, (*corners[1:], corners[0]), strict=True)]
    return shapes


def trail_shapes(viewport: Viewport, seat_color: Color, start: Pose, end: Pose) -> tuple[Stroke, Stroke]:
    """A piece of a hunter's way: in its colour, which fades, and in the trace's, which stays longer."""
    points = (*viewport.to_pixels(*start[:2]), *viewport.to_pixels(*end[:2]))
    width = viewport.trail_width
    return Stroke(*points, width, seat_color), Stroke(*points, width, TRACE)


def arena_shapes(
    viewport: Viewport,
    info: MatchInfo,
    *,
    hunters: Sequence[HunterState],
    poses: Sequence[Pose],
    targets: Sequence[TargetState],
    annotations: Sequence[Annotation],
    time_ms: float,
) -> list[Shape]:
    """Everything that moves or comes and goes, from the lowest to the topmost."""
    shapes: list[Shape] = []
    for target in targets:
        shapes += _target(viewport, target, time_ms)
    for seat, hunter in enumerate(hunters):
        shapes += _hunter(viewport, hunter, poses[seat], info.color(seat), info.config.reaches[seat] * viewport.scale)
    return shapes + annotation_shapes(viewport, info, poses, annotations, time_ms)


def _target(viewport: Viewport, target: TargetState, time_ms: float) -> list[Shape]:
    x, y = viewport.to_pixels(target.x, target.y)
    shapes: list[Shape] = []
    age = time_ms - target.spawned_ms
    if 0.0 <= age < SPAWN_MS and target.spawned_ms > 0:
        part = age / SPAWN_MS
        radius = viewport.target_length * (1.3 - 0.7 * part)
        shapes.append(Ring(x, y, radius, 1.5, WHITE, 0.8 * part))
    shapes.append(Turtle(x, y, target.theta, viewport.target_length, TARGET, contrast=0.6))
    return shapes


def _hunter(viewport: Viewport, hunter: HunterState, pose: Pose, color: Color, reach: float) -> list[Shape]:
    x, y = viewport.to_pixels(pose[0], pose[1])
    length = viewport.hunter_length
    body = Turtle(x, y, pose[2], length, color, faded=hunter.withdrawn)
    if hunter.withdrawn:
        return [body]
    forward = (math.cos(pose[2]), -math.sin(pose[2]))
    base, size = max(reach, 0.55 * length) + 1.5, max(4.0, 0.16 * length)
    left = (forward[1], -forward[0])
    tip = (
        (x + forward[0] * (base + size), y + forward[1] * (base + size)),
        (x + forward[0] * base + left[0] * size * 0.62, y + forward[1] * base + left[1] * size * 0.62),
        (x + forward[0] * base - left[0] * size * 0.62, y + forward[1] * base - left[1] * size * 0.62),
    )
    circle = Ring(x, y, reach, 1.3, mix(color, WHITE, 0.55), 0.85, veil=0.14)
    return [circle, Polygon(tip, mix(color, WHITE, 0.45)), body]
