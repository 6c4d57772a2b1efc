"""What a frame of the arena shows, as shapes.

Pure functions of the world, of everybody's poses at an instant, and of what was ruled lately.
World units are metres, y up; shapes are in pixels, y down. raster.py turns shapes into pixels.
"""

import math
from collections.abc import Sequence
from typing import Final

from catch_arena.render.annotations import Annotation, annotation_shapes
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.motion import Poses
from catch_arena.render.shapes import WHITE, Box, Color, Polygon, Ring, Sector, Shape, Stroke, Turtle, mix
from catch_arena.render.viewport import GROUND, TARGET, TARGET_TRAIL, TRACE, Pose, Viewport
from catch_arena.world import HunterState, TargetState

WALL: Final[Color] = (112, 127, 255)
GRID: Final[Color] = (78, 95, 255)
SPAWN_MS: Final = 450.0
"""How long the ring about a new target is seen."""
_VIEW_OPACITY: Final = 0.25


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


def target_trail_shape(viewport: Viewport, start: Pose, end: Pose) -> Stroke:
    """A piece of a target's way, which fades and leaves no trace: there are too many of them."""
    return Stroke(
        *viewport.to_pixels(*start[:2]), *viewport.to_pixels(*end[:2]), viewport.target_trail_width, TARGET_TRAIL
    )


def arena_shapes(
    viewport: Viewport,
    info: MatchInfo,
    *,
    hunters: Sequence[HunterState],
    poses: Poses,
    targets: Sequence[TargetState],
    annotations: Sequence[Annotation],
    time_ms: float,
    view_of: int | None = None,
) -> list[Shape]:
    """Everything that moves or comes and goes, from the lowest to the topmost; `view_of` is the seat whose view is
    shown.
    """
    shapes: list[Shape] = []
    if view_of is not None and info.config.partial_view and not hunters[view_of].withdrawn:
        shapes.append(_view(viewport, info, poses.hunters[view_of], info.color(view_of)))
    for target in targets:
        shapes += _target(viewport, target, poses.targets[target.number], time_ms)
    for seat, hunter in enumerate(hunters):
        reach = info.config.reaches[seat] * viewport.scale
        shapes += _hunter(viewport, hunter, poses.hunters[seat], info.color(seat), reach)
    return shapes + annotation_shapes(viewport, info, poses.hunters, annotations, time_ms)


def _view(viewport: Viewport, info: MatchInfo, pose: Pose, color: Color) -> Sector:
    """R7.5: what lies within a hunter's radius and cone; what is within its reach too lies in its circle."""
    config, side = info.config, viewport.side_m
    farthest = math.hypot(side, side)
    radius = farthest if config.view_radius_m is None else min(farthest, config.view_radius_m)
    return Sector(
        *viewport.to_pixels(*pose[:2]),
        radius * viewport.scale,
        pose[2],
        math.radians(config.view_angle_deg),
        mix(color, WHITE, 0.6),
        _VIEW_OPACITY,
        0.25 * viewport.hunter_length,
        (*viewport.to_pixels(0.0, side), *viewport.to_pixels(side, 0.0)),
    )


def _target(viewport: Viewport, target: TargetState, pose: Pose, time_ms: float) -> list[Shape]:
    x, y = viewport.to_pixels(*pose[:2])
    shapes: list[Shape] = []
    age = time_ms - target.spawned_ms
    if 0.0 <= age < SPAWN_MS and target.spawned_ms > 0:
        part = age / SPAWN_MS
        radius = viewport.target_length * (1.3 - 0.7 * part)
        shapes.append(Ring(x, y, radius, 1.5, WHITE, 0.8 * part))
    shapes.append(Turtle(x, y, pose[2], viewport.target_length, TARGET, contrast=0.6))
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
