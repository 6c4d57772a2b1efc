"""A small world, the shapes that show it, and where shapes reach."""

import itertools

from catch_arena.config import ArenaConfig
from catch_arena.explanation.contests import contests_of
from catch_arena.render import hud, scene, text
from catch_arena.render.annotations import Annotation, annotations_of
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import Box, Label, Path, Polygon, Turtle
from catch_arena.render.viewport import Viewport
from catch_arena.replay.motion import poses_of
from catch_arena.verdicts import Ruling
from catch_arena.world import HunterState, TargetState, World


def a_world(*rulings: Ruling, places=((1.0, 2.0), (9.0, 3.0)), step: int = 5) -> World:
    hunters = tuple(HunterState(f"hunter_{i}", x, y, 0.5, 1.0, 0.0, 3 - i, team=i) for i, (x, y) in enumerate(places))
    targets = (
        TargetState("target_turtle_7", 7, 1.1, 2.1, 0.0, 0),
        TargetState("target_turtle_9", 9, 5.0, 5.0, 1.0, 480),
    )
    return World(100 * step, step, 11.088889122009277, hunters, targets, rulings, 9)


def annotated(before: World, after: World, **settings) -> tuple[Annotation, ...]:
    """Annotations of a step of an arena with these settings."""
    config = ArenaConfig(hunters=len(after.hunters), **settings)
    return annotations_of(before, after, contests_of(config, after))


def shapes_of(
    world: World, annotations=(), time_ms: float = 500.0, size=(720, 720), view_of=None, beliefs=(), **settings
) -> list:
    info = MatchInfo.of(ArenaConfig(hunters=len(world.hunters), **settings))
    viewport = Viewport(*size, world.side_m)
    return scene.arena_shapes(viewport, info, world, poses_of(world), annotations, time_ms, view_of, beliefs)


def kinds(shapes, kind) -> list:
    return [shape for shape in shapes if isinstance(shape, kind)]


SIZES = [
    (320, 320),
    (321, 480),
    (500, 500),
    (640, 360),
    (720, 1280),
    (960, 720),
    (1280, 720),
    (3840, 2160),
    (3840, 320),
    (320, 2160),
]


def an_info(hunters: int) -> MatchInfo:
    names = [f"contested_by_arrival_time_v{seat}" for seat in range(hunters)]
    return MatchInfo.of(ArenaConfig(hunters=hunters), names, "Round 3   match 12 of 64", 60_000)


def extent(shape) -> tuple[float, float, float, float]:
    """Left, top, right, bottom."""
    match shape:
        case Box():
            return shape.left, shape.top, shape.left + shape.width, shape.top + shape.height
        case Label():
            shown = text.truncated(shape.text, shape.size, shape.weight, shape.max_width)
            width = text.text_width(shown, shape.size, shape.weight)
            left = shape.x - {"left": 0.0, "center": width / 2, "right": width}[shape.align]
            return left, shape.y - 0.4 * shape.size, left + width, shape.y + 0.4 * shape.size
        case Turtle():
            half = shape.length / 2
            return shape.x - half, shape.y - 0.8 * half, shape.x + half, shape.y + 0.8 * half
        case Polygon() | Path():
            x, y = zip(*shape.points, strict=True)
            return min(x), min(y), max(x), max(y)
    raise TypeError(shape)


def assert_inside(shapes, area: hud.Rect) -> None:
    for shape in shapes:
        left, top, right, bottom = extent(shape)
        assert left >= area.left - 2, shape
        assert top >= area.top - 2, shape
        assert right <= area.left + area.width + 2, shape
        assert bottom <= area.top + area.height + 2, shape


def assert_texts_apart(shapes) -> None:
    placed = [(shape, extent(shape)) for shape in shapes if isinstance(shape, Label)]
    placed = [(shape, box) for shape, box in placed if box[2] > box[0]]
    for (one, a), (other, b) in itertools.combinations(placed, 2):
        assert a[2] <= b[0] + 0.5 or b[2] <= a[0] + 0.5 or a[3] <= b[1] + 0.5 or b[3] <= a[1] + 0.5, (one, other)
