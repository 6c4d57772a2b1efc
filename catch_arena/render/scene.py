"""What a frame of the arena shows, as shapes.

Pure functions of the world, of the hunters' poses at an instant, and of what was ruled lately.
World units are metres, y up; shapes are in pixels, y down. raster.py turns shapes into pixels.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Final, Literal

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.verdicts import Verdict
from catch_arena.world import HunterState, TargetState, World

Color = tuple[int, int, int]
"""Red, green, blue."""
Pose = tuple[float, float, float]
"""x [m], y [m], theta [rad]."""

GROUND: Final[Color] = (69, 86, 255)
"""turtlesim's blue."""
WALL: Final[Color] = (112, 127, 255)
GRID: Final[Color] = (78, 95, 255)
OUTSIDE: Final[Color] = (62, 77, 236)
TRACE: Final[Color] = (94, 113, 255)
"""What remains of a trail."""
TARGET: Final[Color] = (240, 234, 255)
WHITE: Final[Color] = (255, 255, 255)
INK: Final[Color] = (14, 18, 44)

HUNTER_COLORS: Final[tuple[Color, ...]] = (
    (255, 170, 36),
    (61, 242, 192),
    (255, 100, 180),
    (200, 255, 90),
    (200, 40, 40),
    (90, 195, 250),
    (40, 140, 80),
    (130, 40, 120),
)
"""Eight that stay apart, from each other and from the ground, for the colour-blind too; a test measures it."""

HUNTER_LENGTH_M: Final = 0.66
TARGET_LENGTH_M: Final = 0.44
MARGIN: Final = 0.03
"""Room outside the walls, as a part of the side: a turtle at a wall is seen whole."""

CATCH_MS: Final = 900.0
"""How long a catch is seen."""
LOST_MS: Final = 700.0
"""How long a lost contest, or a catch that a service refused, is seen."""
SPAWN_MS: Final = 450.0


@dataclass(frozen=True, slots=True)
class Ring:
    """A circle's line [pixels], and a veil of the same colour inside; `glow` softens it outwards."""

    x: float
    y: float
    radius: float
    width: float
    color: Color
    opacity: float = 1.0
    veil: float = 0.0
    glow: bool = False


@dataclass(frozen=True, slots=True)
class Stroke:
    """A straight line with round ends, opaque."""

    x0: float
    y0: float
    x1: float
    y1: float
    width: float
    color: Color


@dataclass(frozen=True, slots=True)
class Polygon:
    """A filled area, opaque."""

    points: tuple[tuple[float, float], ...]
    color: Color


@dataclass(frozen=True, slots=True)
class Box:
    """A filled rectangle with round corners, opaque."""

    left: float
    top: float
    width: float
    height: float
    color: Color
    radius: float = 0.0


@dataclass(frozen=True, slots=True)
class Turtle:
    """A turtle from above; `theta` is counter-clockwise on the screen."""

    x: float
    y: float
    theta: float
    length: float
    color: Color
    faded: bool = False
    contrast: float = 1.0
    """How dark its darker parts are."""


@dataclass(frozen=True, slots=True)
class Label:
    """One line of text; `y` is the middle of its capitals. Text wider than `max_width` ends in an ellipsis."""

    x: float
    y: float
    text: str
    size: int
    color: Color
    weight: int = 600
    align: Literal["left", "center", "right"] = "left"
    outline: Color | None = None
    opacity: float = 1.0
    max_width: float = math.inf


Shape = Ring | Stroke | Polygon | Box | Turtle | Label


@dataclass(frozen=True, slots=True)
class Look:
    """What does not change during a match: its arena, and how each seat is called and coloured."""

    config: ArenaConfig
    names: tuple[str, ...]
    """By seat."""
    title: str = ""
    duration_ms: int = 0
    """Of the match: the length of the timeline."""

    @classmethod
    def of(
        cls, config: ArenaConfig, names: Sequence[str] | None = None, title: str = "", duration_ms: int | None = None
    ) -> "Look":
        """The look of one match; agents without names are called as PettingZoo calls them."""
        called = config.hunter_names if names is None else tuple(names)
        if len(called) != config.hunters:
            raise ConfigError(f"names must be one for each of {config.hunters} hunters, got {len(called)}")
        return cls(config, called, title, config.time_limit_ms if duration_ms is None else duration_ms)

    def color(self, seat: int) -> Color:
        """A seat's colour: eight, then the same eight lighter, then darker, and again."""
        color = HUNTER_COLORS[seat % len(HUNTER_COLORS)]
        shade = seat // len(HUNTER_COLORS) % 3
        return (color, mix(color, WHITE, 0.42), mix(color, INK, 0.3))[shade]


@dataclass(frozen=True)
class Viewport:
    """Where the arena's square lies in a picture of so many pixels: as large as fits, in the middle, with a margin."""

    width: int
    height: int
    side_m: float

    @cached_property
    def scale(self) -> float:
        """Pixels per metre."""
        return min(self.width, self.height) / (self.side_m * (1.0 + 2.0 * MARGIN))

    def place(self, x: float, y: float) -> tuple[float, float]:
        """A point of the world [m] in pixels."""
        left, bottom = self._corner
        return left + x * self.scale, bottom - y * self.scale

    @cached_property
    def _corner(self) -> tuple[float, float]:
        half = self.side_m * self.scale / 2.0
        return self.width / 2.0 - half, self.height / 2.0 + half

    @cached_property
    def hunter_length(self) -> float:
        """Pixels: true to HUNTER_LENGTH_M until that would be too small to see."""
        least = max(20.0, min(self.width, self.height) / 26.0)
        return max(HUNTER_LENGTH_M * self.scale, least)

    @cached_property
    def target_length(self) -> float:
        """Pixels."""
        return self.hunter_length * TARGET_LENGTH_M / HUNTER_LENGTH_M

    @cached_property
    def trail_width(self) -> float:
        """Pixels."""
        return max(1.6, 0.1 * self.hunter_length)


@dataclass(frozen=True, slots=True)
class Mark:
    """One ruling, as it is shown for a moment: where, whose, since when."""

    kind: Literal["catch", "lost", "refused"]
    time_ms: int
    """When it was judged: the boundary at which the step began (R1.4)."""
    seat: int
    x: float
    """The target's place [m], or the hunter's where there was no such target."""
    y: float

    @property
    def lasts_ms(self) -> float:
        """How long it is shown."""
        return CATCH_MS if self.kind == "catch" else LOST_MS


_KINDS: Final[dict[Verdict, Literal["catch", "lost", "refused"]]] = {
    Verdict.GRANTED: "catch",
    Verdict.LOST_CONTEST: "lost",
    Verdict.SERVICE_DOWN: "refused",
    Verdict.KILL_FAILED: "refused",
}


def marks_of(before: World, after: World) -> tuple[Mark, ...]:
    """What the step from one world to the next is to show of its rulings, which were judged on the former."""
    places = {target.name: (target.x, target.y) for target in before.targets}
    marks = []
    for ruling in after.rulings:
        kind = _KINDS.get(ruling.verdict)
        if kind is not None:
            hunter = before.hunters[ruling.hunter]
            x, y = places.get(str(ruling.target), (hunter.x, hunter.y))
            marks.append(Mark(kind, before.time_ms, ruling.hunter, x, y))
    return tuple(marks)


def still_seen(marks: Iterable[Mark], time_ms: float) -> list[Mark]:
    """The marks that are not over yet; of each hunter's refusals only the latest, which a step may repeat."""
    seen = [mark for mark in marks if time_ms - mark.time_ms < mark.lasts_ms]
    latest = {mark.seat: mark for mark in seen if mark.kind == "refused"}
    return [mark for mark in seen if mark.kind != "refused" or latest[mark.seat] is mark]


@lru_cache(maxsize=4096)
def mix(one: Color, other: Color, part: float) -> Color:
    """`one` with a part in [0, 1] of `other`."""
    red, green, blue = (round(a + (b - a) * part) for a, b in zip(one, other, strict=True))
    return red, green, blue


def ground_shapes(view: Viewport) -> list[Shape]:
    """What lies under everything and never changes: the square within its walls, and a grid of whole metres."""
    left, bottom = view.place(0.0, 0.0)
    side = view.side_m * view.scale
    top = bottom - side
    shapes: list[Shape] = [Box(left, top, side, side, GROUND)]
    spacing = next(
        step * 10.0**power for power in range(5) for step in (1.0, 2.0, 5.0) if step * 10.0**power * view.scale >= 24
    )
    for line in range(1, math.ceil(view.side_m / spacing)):
        x, y = view.place(line * spacing, line * spacing)
        shapes += [Stroke(x, top, x, bottom, 1.0, GRID), Stroke(left, y, left + side, y, 1.0, GRID)]
    corners = ((left, bottom), (left + side, bottom), (left + side, top), (left, top))
    shapes += [Stroke(*a, *b, 1.0, WALL) for a, b in zip(corners, (*corners[1:], corners[0]), strict=True)]
    return shapes


def trail_shapes(view: Viewport, seat_color: Color, start: Pose, end: Pose) -> tuple[Stroke, Stroke]:
    """A piece of a hunter's way: in its colour, which fades, and in the trace's, which stays longer."""
    points = (*view.place(*start[:2]), *view.place(*end[:2]))
    width = view.trail_width
    return Stroke(*points, width, seat_color), Stroke(*points, width, TRACE)


def arena_shapes(
    view: Viewport,
    look: Look,
    *,
    hunters: Sequence[HunterState],
    poses: Sequence[Pose],
    targets: Sequence[TargetState],
    marks: Sequence[Mark],
    time_ms: float,
) -> list[Shape]:
    """Everything that moves or comes and goes, from the lowest to the topmost."""
    shapes: list[Shape] = []
    for target in targets:
        shapes += _target(view, target, time_ms)
    reach = look.config.reach_m * view.scale
    for seat, hunter in enumerate(hunters):
        shapes += _hunter(view, hunter, poses[seat], look.color(seat), reach)
    for mark in marks:
        if mark.kind == "catch":
            shapes.append(_catch_ring(view, mark, time_ms))
        elif mark.kind == "lost":
            shapes.append(_contest(view, mark, look.color(mark.seat), poses[mark.seat], time_ms))
    size = max(10, round(0.34 * view.hunter_length))
    for seat, (x, y, _) in enumerate(poses):
        shapes.append(Label(*view.place(x, y), str(seat), size, WHITE, 800, "center", outline=INK))
    for mark in marks:
        shapes.append(_word(view, mark, look.color(mark.seat), poses[mark.seat], reach=reach, time_ms=time_ms))
    return shapes


def _target(view: Viewport, target: TargetState, time_ms: float) -> list[Shape]:
    x, y = view.place(target.x, target.y)
    shapes: list[Shape] = []
    age = time_ms - target.spawned_ms
    if 0.0 <= age < SPAWN_MS and target.spawned_ms > 0:
        part = age / SPAWN_MS
        radius = view.target_length * (1.3 - 0.7 * part)
        shapes.append(Ring(x, y, radius, 1.5, WHITE, 0.8 * part))
    shapes.append(Turtle(x, y, target.theta, view.target_length, TARGET, contrast=0.6))
    return shapes


def _hunter(view: Viewport, hunter: HunterState, pose: Pose, color: Color, reach: float) -> list[Shape]:
    x, y = view.place(pose[0], pose[1])
    length = view.hunter_length
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


def _catch_ring(view: Viewport, mark: Mark, time_ms: float) -> Ring:
    part = (time_ms - mark.time_ms) / CATCH_MS
    eased = 1.0 - (1.0 - part) ** 3
    length = view.hunter_length
    x, y = view.place(mark.x, mark.y)
    radius = length * (0.3 + 0.75 * eased)
    return Ring(x, y, radius, max(1.2, 0.11 * length * (1.0 - part)), WHITE, (1.0 - part) ** 1.5, glow=True)


def _contest(view: Viewport, mark: Mark, color: Color, pose: Pose, time_ms: float) -> Stroke:
    """From the loser to the target that another was granted; it thins out, since strokes are opaque."""
    part = (time_ms - mark.time_ms) / LOST_MS
    width = max(0.8, 0.07 * view.hunter_length * (1.0 - part))
    return Stroke(*view.place(pose[0], pose[1]), *view.place(mark.x, mark.y), width, mix(color, GROUND, 0.8 * part))


def _word(view: Viewport, mark: Mark, color: Color, pose: Pose, *, reach: float, time_ms: float) -> Label:
    """+1 or ! rising over the hunter, or - sinking below it, clear of the winner's; kept inside the picture."""
    part = (time_ms - mark.time_ms) / mark.lasts_ms
    size = max(11, round((0.48 if mark.kind == "catch" else 0.42) * view.hunter_length))
    x, y = view.place(pose[0], pose[1])
    away = max(reach, 0.5 * view.hunter_length) + 0.75 * size + 0.3 * view.hunter_length * part
    side = 1.0 if mark.kind == "lost" else -1.0
    if not 0.6 * size < y + side * away < view.height - 0.6 * size:
        side = -side
    x = min(max(x, 0.8 * size), view.width - 0.8 * size)
    text = {"catch": "+1", "lost": "−", "refused": "!"}[mark.kind]
    opacity = min(1.0, 3.0 * (1.0 - part))
    words = WHITE if mark.kind == "catch" else mix(color, WHITE, 0.35)
    return Label(x, y + side * away, text, size, words, 800, "center", outline=INK, opacity=opacity)
