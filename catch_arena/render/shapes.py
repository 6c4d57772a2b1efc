"""The words in which a frame is described: shapes in pixels, y down. raster.py turns them into pixels."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Literal

Color = tuple[int, int, int]
"""Red, green, blue."""

WHITE: Final[Color] = (255, 255, 255)
INK: Final[Color] = (14, 18, 44)


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
class Path:
    """A line through points, opaque."""

    points: tuple[tuple[float, float], ...]
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


Shape = Ring | Stroke | Path | Polygon | Box | Turtle | Label


@lru_cache(maxsize=4096)
def mix(one: Color, other: Color, part: float) -> Color:
    """`one` with a part in [0, 1] of `other`."""
    red, green, blue = (round(a + (b - a) * part) for a, b in zip(one, other, strict=True))
    return red, green, blue
