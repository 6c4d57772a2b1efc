"""Sprites: small pictures of turtles, rings and texts, premultiplied, drawn once for each angle and half pixel.

The latest sprites are kept: in a 4K video of the standard arena they take up to 200 MB.
"""

import math
from functools import lru_cache
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.render import text
from catch_arena.render.optional_imports import cv2, pygame
from catch_arena.render.shapes import INK, TURTLE_PARTS, Label, Points, Ring, Turtle, ellipse, mix

PHASES: Final = 2
"""Number of positions within a pixel, per axis, for which a sprite is drawn."""
LIGHT: Final = (0.55, 0.83)
"""Direction of shadows, x and y on the screen; the light does not turn with the turtle."""


class Sprite(NamedTuple):
    """Premultiplied picture, and the place of its origin in it [pixels]."""

    surface: "pygame.Surface"
    origin_x: int
    origin_y: int


def turtle_sprite(shape: Turtle) -> tuple[Sprite, int, int]:
    """Return a turtle's sprite, and the whole pixels x and y for its origin."""
    x, y, rest_x, rest_y = _place(shape.x, shape.y, PHASES if shape.length < 64 else 1)
    turns = max(64, min(192, 8 * round(0.3 * shape.length)))
    theta = 2.0 * math.pi * (round(shape.theta * turns / (2.0 * math.pi)) % turns) / turns
    return _turtle(shape._replace(x=rest_x, y=rest_y, theta=theta, length=round(shape.length))), x, y


def ring_sprite(shape: Ring) -> tuple[Sprite, int, int]:
    """Return a ring's sprite, and the whole pixels x and y for its origin."""
    x, y, rest_x, rest_y = _place(shape.x, shape.y)
    radius, width = round(2.0 * shape.radius) / 2.0, round(4.0 * shape.width) / 4.0
    opacity, veil = round(shape.opacity * 24) / 24, round(shape.veil * 50) / 50
    rounded = shape._replace(x=rest_x, y=rest_y, radius=radius, width=width, opacity=opacity, veil=veil)
    return _ring(rounded), x, y


def label_sprite(shape: Label) -> tuple[Sprite, int, int]:
    """Return a text's sprite, and the whole pixels for its origin; only outlined texts move, by half pixels."""
    shown = text.truncated(shape.text, shape.size, shape.weight, shape.max_width)
    width = text.text_width(shown, shape.size, shape.weight)
    left = shape.x - {"left": 0.0, "center": width / 2.0, "right": width}[shape.align]
    baseline = shape.y + text.MIDDLE * shape.size
    x, y, rest_x, rest_y = _place(left, baseline, 1 if shape.outline is None else PHASES)
    opacity = round(shape.opacity * 8) / 8
    rounded = shape._replace(x=rest_x, y=rest_y, text=shown, align="left", opacity=opacity, max_width=math.inf)
    return _label(rounded), x, y


def _place(x: float, y: float, phases: int = PHASES) -> tuple[int, int, float, float]:
    """Return a place, rounded to 1 / `phases` of a pixel: whole x, whole y, rest of x, rest of y [pixels]."""
    at_x, at_y = round(x * phases), round(y * phases)
    return at_x // phases, at_y // phases, at_x % phases / phases, at_y % phases / phases


def _sprite(pixels: NDArray[np.floating[Any]], origin_x: int, origin_y: int) -> Sprite:
    """Return premultiplied colours and coverage, 0 to 255, as a surface in the canvas's own channel order."""
    return _surface_of(np.clip(pixels + 0.5, 0, 255).astype(np.uint8), origin_x, origin_y)


def _surface_of(pixels: NDArray[np.uint8], origin_x: int, origin_y: int) -> Sprite:
    whole = np.ascontiguousarray(pixels)
    height, width = whole.shape[:2]
    # a copy: the surface of frombuffer shares an array that no other reference keeps alive
    return Sprite(pygame.image.frombuffer(whole.data, (width, height), "RGBA").copy(), origin_x, origin_y)


_CORNERS: Final = np.linspace(0.0, 2.0 * math.pi, 6, endpoint=False)
_SCUTE: Final = np.stack([-0.03 + 0.135 * np.cos(_CORNERS), 0.125 * np.sin(_CORNERS)], axis=1)
"""Hexagon in the middle of the shell; lines lead from its corners to the edge."""
_EDGE: Final = np.stack([-0.03 + 0.285 * np.cos(_CORNERS), 0.228 * np.sin(_CORNERS)], axis=1)
_SHEEN: Final = ellipse(0.0, 0.0, 0.185, 0.14)


@lru_cache(maxsize=1024)
def _turtle_inks(x: float, y: float, theta: float, length: int) -> NDArray[np.uint8]:
    """Return a turtle before it has a colour: (side, side, 4), 0 to 255.

    The channels are the part of its own colour, the part of white, coverage, and the coverage of its visible shadow.
    """
    fine = 8 if length <= 64 else 4
    half = math.ceil(0.62 * length) + 2
    side = 2 * half
    picture = np.zeros((side * fine, side * fine, 3), dtype=np.uint8)
    unit = float(length * fine)
    turn = unit * np.array([[math.cos(theta), -math.sin(theta)], [-math.sin(theta), -math.cos(theta)]])
    middle = np.array([(half + x) * fine, (half + y) * fine])

    def placed(points: Points) -> NDArray[np.int32]:
        return np.asarray(np.rint(points @ turn.T + middle), dtype=np.int32)

    for points, own, white in TURTLE_PARTS:
        cv2.fillPoly(picture, [placed(points)], (255.0 * own, 255.0 * white, 255.0))
    sheen = _SHEEN * unit + placed(np.array([[-0.03, 0.0]])) - np.array(LIGHT) * 0.075 * unit
    cv2.fillPoly(picture, [np.rint(sheen).astype(np.int32)], (255.0 * 0.86, 255.0 * 0.14, 255.0))
    thick, line = max(1, round(0.022 * unit)), (255.0 * 0.62, 0.0, 255.0)
    inner, outer = placed(_SCUTE), placed(_EDGE)
    cv2.polylines(picture, [inner, *np.stack([inner, outer], axis=1)], True, line, thick)
    small = cv2.resize(picture, (side, side), interpolation=cv2.INTER_AREA)
    fall = np.array([[1.0, 0.0, 0.085 * length * LIGHT[0]], [0.0, 1.0, 0.085 * length * LIGHT[1]]])
    body = small[..., 2].astype(np.float32)
    shadow = cv2.warpAffine(cv2.GaussianBlur(body, (0, 0), max(0.6, 0.035 * length)), fall, (side, side))
    under = 0.42 * shadow * (1.0 - body / 255.0)
    return np.dstack([small, np.rint(under).astype(np.uint8)])


@lru_cache(maxsize=2048)
def _turtle(shape: Turtle) -> Sprite:
    """Return the sprite of a turtle; one matrix colours every channel, a sum of the inks."""
    inks = _turtle_inks(shape.x, shape.y, shape.theta, round(shape.length))
    tint = mix(shape.color, INK, 0.5) if shape.faded else shape.color
    kept = 0.55 if shape.faded else 1.0
    # less contrast lightens the parts that are neither its own colour nor white
    lit = [own * (1.0 - shape.contrast) / 255.0 for own in tint]
    matrix = [
        (own * shape.contrast / 255.0, 1.0 - light, light, ink / 255.0)
        for own, light, ink in zip(tint, lit, INK, strict=True)
    ]
    matrix.append((0.0, 0.0, 1.0, 1.0))
    half = inks.shape[0] // 2
    pixels = cv2.transform(inks, kept * np.array(matrix))
    return _surface_of(np.asarray(pixels, dtype=np.uint8), half, half)


_LEAST_GAP: Final = 1.5
_WIDEST_GAP: Final = 3.0
"""Bounds of half the gap between two pieces of a ring: the least in pixels, the widest in widths of the line."""


@lru_cache(maxsize=512)
def _ring(shape: Ring) -> Sprite:
    x, y, radius, width, color, opacity, veil, glow, pieces = shape
    reach = radius + (2.5 * width if glow else 0.5 * width) + 2.0
    half = math.ceil(reach)
    position = np.arange(2 * half, dtype=np.float32) + 0.5 - half
    right, down = position[None, :] - x, position[:, None] - y
    distance = np.hypot(right, down)
    off = np.abs(distance - radius)
    cover = np.clip(0.5 + width / 2.0 - off, 0.0, 1.0) * opacity
    if pieces > 1:
        piece = 2.0 * math.pi / pieces
        from_gap = np.abs(np.remainder(np.arctan2(-down, right), piece) - 0.5 * piece) * radius
        gap = max(_LEAST_GAP, min(0.15 * piece * radius, _WIDEST_GAP * width))
        cover *= np.clip(0.5 + from_gap - gap, 0.0, 1.0)
    if glow:
        cover = np.maximum(cover, 0.55 * opacity * np.exp(-((off / (1.1 * width + 0.5)) ** 2)))
    cover = np.maximum(cover, veil * np.clip(radius - distance + 0.5, 0.0, 1.0))
    return _sprite(cover[..., None] * np.array([*color, 255.0]), half, half)


@lru_cache(maxsize=384)
def _label(shape: Label) -> Sprite:
    size = shape.size
    fill = np.array([*shape.color, 255.0], dtype=np.float32)
    baseline = round(text.BASELINE * size)
    if shape.outline is None:
        ink = text.coverage(shape.text, size, shape.weight).astype(np.float32) / 255.0
        return _sprite(ink[..., None] * fill * shape.opacity, size, baseline)
    fine = 4
    large = text.coverage(shape.text, size * fine, shape.weight)
    rows, columns = -(-large.shape[0] // fine) + 2, -(-large.shape[1] // fine) + 2
    room = np.zeros((rows * fine, columns * fine), dtype=np.uint8)
    down = baseline * fine - round(text.BASELINE * size * fine)
    top, left = max(0, down + round(fine * shape.y)), round(fine * shape.x)
    room[top : top + large.shape[0], left : left + large.shape[1]] = large
    thick = max(1.0, 0.11 * size) * fine
    brush = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * round(thick) + 1, 2 * round(thick) + 1))
    around = cv2.dilate(room, brush)
    ink, edge = (
        cv2.resize(layer, (columns, rows), interpolation=cv2.INTER_AREA).astype(np.float32)[..., None] / 255.0
        for layer in (room, around)
    )
    rim = np.array([*shape.outline, 255.0], dtype=np.float32)
    return _sprite((ink * fill + np.maximum(edge - ink, 0.0) * 0.92 * rim) * shape.opacity, size, baseline)
