"""Shapes that describe a frame, in pixels with y down, which raster.py draws; and the outlines of a turtle."""

import math
from functools import lru_cache
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

Color = tuple[int, int, int]
"""Red, green, blue."""

WHITE: Final[Color] = (255, 255, 255)
INK: Final[Color] = (14, 18, 44)


class Ring(NamedTuple):
    """Line of a circle [pixels], with a veil of the same colour inside; `glow` softens the line outwards."""

    x: float
    y: float
    radius: float
    width: float
    color: Color
    opacity: float = 1.0
    veil: float = 0.0
    glow: bool = False
    pieces: int = 1
    """Number of arcs that make up the line."""


class Sector(NamedTuple):
    """A part of a disc [pixels], translucent, with a soft edge, and nothing of it outside a rectangle."""

    x: float
    y: float
    radius: float
    theta: float
    """Direction of its middle, counter-clockwise on the screen [rad]."""
    angle: float
    """Width of the sector, up to 2 pi [rad]."""
    color: Color
    opacity: float
    soft: float
    """Distance over which its edge fades [pixels]."""
    within: tuple[float, float, float, float]
    """Rectangle that cuts it off: left, top, right, bottom [pixels]."""


class Path(NamedTuple):
    """A line through points, with round ends, opaque."""

    points: tuple[tuple[float, float], ...]
    width: float
    color: Color


class Polygon(NamedTuple):
    """A filled area, opaque."""

    points: tuple[tuple[float, float], ...]
    color: Color


class Box(NamedTuple):
    """A filled rectangle with round corners, opaque."""

    left: float
    top: float
    width: float
    height: float
    color: Color
    radius: float = 0.0


class Turtle(NamedTuple):
    """A turtle from above; `theta` is counter-clockwise on the screen."""

    x: float
    y: float
    theta: float
    length: float
    color: Color
    faded: bool = False
    contrast: float = 1.0
    """Darkness of its darker parts, in [0, 1]."""


class Label(NamedTuple):
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


Shape = Ring | Sector | Path | Polygon | Box | Turtle | Label


@lru_cache(maxsize=4096)
def mix(color: Color, added: Color, part: float) -> Color:
    """Return a colour mixed with a part in [0, 1] of `added`."""
    red, green, blue = (round(a + (b - a) * part) for a, b in zip(color, added, strict=True))
    return red, green, blue


Points = NDArray[np.float64]
"""Points of shape (N, 2), in lengths of the turtle, which faces right; y up."""


def ellipse(x: float, y: float, a: float, b: float, degrees: float = 0.0) -> Points:
    """Return an ellipse as points (40, 2), by its centre, half its length, half its width, and its angle."""
    around = np.linspace(0.0, 2.0 * math.pi, 40, endpoint=False)
    along, across = a * np.cos(around), b * np.sin(around)
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.stack([x + cosine * along - sine * across, y + sine * along + cosine * across], axis=1)


def _parts() -> list[tuple[Points, float, float]]:
    limbs = [
        (x, side * y, a, b, side * turn)
        for x, y, a, b, turn in ((0.17, 0.27, 0.18, 0.075, 52.0), (-0.29, 0.21, 0.13, 0.065, 140.0))
        for side in (1.0, -1.0)
    ]
    limbs.append((0.40, 0.0, 0.125, 0.095, 0.0))  # the head
    rim = (0.42, 0.0)
    parts = [(ellipse(x, y, a + 0.022, b + 0.022, turn), *rim) for x, y, a, b, turn in limbs]
    parts.append((np.array([(-0.33, 0.05), (-0.5, 0.0), (-0.33, -0.05)]), *rim))
    parts += [(ellipse(x, y, a - 0.004, b - 0.004, turn), 0.80, 0.05) for x, y, a, b, turn in limbs]
    parts += [(ellipse(0.445, side * 0.052, 0.026, 0.026), 0.0, 0.04) for side in (1.0, -1.0)]
    parts.append((ellipse(-0.03, 0.0, 0.335, 0.275), *rim))
    parts.append((ellipse(-0.03, 0.0, 0.285, 0.228), 0.96, 0.02))
    return parts


TURTLE_PARTS: Final = _parts()
"""Parts of a turtle, the lowest first: outline, the part of its own colour, the part of white."""
