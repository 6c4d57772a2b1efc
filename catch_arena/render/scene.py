"""Shapes of a frame of the arena.

Pure functions of the world, of all poses at an instant, and of the latest rulings.
World units are metres, y up; shapes are in pixels, y down. raster.py turns shapes into pixels.
"""

import math
from collections.abc import Sequence
from typing import Final

from catch_arena.render.annotations import Annotation, annotation_shapes
from catch_arena.render.blurred_view import Belief
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import WHITE, Box, Color, Path, Polygon, Ring, Sector, Shape, Turtle, mix
from catch_arena.render.viewport import GROUND, TARGET, TARGET_TRAIL, Viewport
from catch_arena.replay.motion import Pose2D, Poses
from catch_arena.world import HunterState, TargetState, World

WALL: Final[Color] = (112, 127, 255)
GRID: Final[Color] = (78, 95, 255)
GRID_STEPS_M: Final = tuple(step * 10.0**power for power in range(4) for step in (1.0, 2.0, 5.0))
GRID_GAP: Final = 24
"""Least distance between two lines of the grid [pixels]; the smallest of the steps that gives it is used."""
SPAWN_MS: Final = 450.0
"""Time for which the ring around a new target is seen [ms]."""
PREY_PIECES: Final = 8
"""Number of arcs of a prey's ring, more than one agent has seats in a match."""
_VIEW_OPACITY: Final = 0.25
_BELIEF_OPACITY: Final = 0.8


def ground_shapes(viewport: Viewport) -> list[Shape]:
    """Return the shapes of the ground, which never change: the square within its walls, and a grid of whole metres."""
    left, bottom = viewport.to_pixels(0.0, 0.0)
    side = viewport.side_m * viewport.scale
    top = bottom - side
    shapes: list[Shape] = [Box(left, top, side, side, GROUND)]
    spacing = next((step for step in GRID_STEPS_M if step * viewport.scale >= GRID_GAP), viewport.side_m)
    for line in range(1, math.ceil(viewport.side_m / spacing)):
        x, y = viewport.to_pixels(line * spacing, line * spacing)
        shapes += [Path(((x, top), (x, bottom)), 1.0, GRID), Path(((left, y), (left + side, y)), 1.0, GRID)]
    corners = ((left, bottom), (left + side, bottom), (left + side, top), (left, top))
    return [*shapes, Path((*corners, corners[0]), 1.0, WALL)]


def trail_shape(viewport: Viewport, way: Sequence[Pose2D], agent_color: Color | None) -> Path:
    """Return a piece of an agent's way in its colour, or of the way of a target that no agent plays."""
    points = tuple(viewport.to_pixels(pose[0], pose[1]) for pose in way)
    if agent_color is None:
        return Path(points, viewport.target_trail_width, TARGET_TRAIL)
    return Path(points, viewport.trail_width, agent_color)


def arena_shapes(
    viewport: Viewport,
    info: MatchInfo,
    world: World,
    poses: Poses,
    annotations: Sequence[Annotation],
    time_ms: float,
    view_of: int | None = None,
    beliefs: Sequence[Belief] = (),
) -> list[Shape]:
    """Return the shapes of everything that moves, appears or disappears, the lowest first.

    The world is that at the end of a step, and the poses are those at an instant of it. `view_of` is the seat whose
    view and beliefs are shown, None for no view.
    """
    shapes: list[Shape] = []
    if view_of is not None and not world.hunters[view_of].withdrawn:
        if info.config.partial_view:
            shapes.append(_view(viewport, info, poses.hunters[view_of], info.colors[view_of]))
        shapes += [_belief(viewport, belief, info.colors[view_of]) for belief in beliefs]
    places = dict(enumerate(poses.hunters))
    withdrawn = {prey.target for prey in world.prey if prey.withdrawn}
    for target in world.targets:
        if target.spawned_ms <= time_ms:
            pose = poses.targets[target.number]
            if target.prey is not None:
                places[info.prey(target.prey)] = pose
            shapes += _target(viewport, target, pose, time_ms, faded=target.name in withdrawn)
    for seat, hunter in enumerate(world.hunters):
        reach = info.config.reaches[seat] * viewport.scale
        shapes += _hunter(viewport, hunter, poses.hunters[seat], info.colors[seat], reach, info.rings[seat])
    return shapes + annotation_shapes(viewport, info, places, annotations, time_ms)


def _view(viewport: Viewport, info: MatchInfo, pose: Pose2D, color: Color) -> Sector:
    """R7.5: return the area within a hunter's view radius and cone; its circle shows the reach, which it sees too."""
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


def _belief(viewport: Viewport, belief: Belief, color: Color) -> Ring:
    """R7.6: return a ring at the believed place of a hunter or target."""
    length = viewport.target_length if belief.is_target else viewport.hunter_length
    place = viewport.to_pixels(belief.x, belief.y)
    return Ring(*place, 0.32 * length, max(1.0, 0.045 * length), mix(color, WHITE, 0.5), _BELIEF_OPACITY, veil=0.15)


def _target(viewport: Viewport, target: TargetState, pose: Pose2D, time_ms: float, *, faded: bool) -> list[Shape]:
    """Return the shapes of a target, with a ring around it if it has just appeared.

    A target that an agent plays is larger and darker than others, in a ring of pieces that is no reach.
    """
    x, y = viewport.to_pixels(*pose[:2])
    shapes: list[Shape] = []
    age = time_ms - target.spawned_ms
    if 0.0 <= age < SPAWN_MS and target.spawned_ms > 0:
        part = age / SPAWN_MS
        shapes.append(Ring(x, y, viewport.target_length * (1.3 - 0.7 * part), 1.5, WHITE, 0.8 * part))
    if target.prey is None:
        return [*shapes, Turtle(x, y, pose[2], viewport.target_length, TARGET, contrast=0.6)]
    length = viewport.prey_length
    if not faded:
        shapes.append(Ring(x, y, 0.62 * length, max(1.5, 0.05 * length), WHITE, 0.9, pieces=PREY_PIECES))
    return [*shapes, Turtle(x, y, pose[2], length, TARGET, faded=faded)]


def _hunter(
    viewport: Viewport, hunter: HunterState, pose: Pose2D, color: Color, reach: float, pieces: int
) -> list[Shape]:
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
    width = 1.3 if pieces == 1 else 2.0
    circle = Ring(x, y, reach, width, mix(color, WHITE, 0.55), 0.85, veil=0.14, pieces=pieces)
    return [circle, Polygon(tip, mix(color, WHITE, 0.45)), body]
