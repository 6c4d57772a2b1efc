"""Drawing of shapes as pixels: pygame and cv2 share one RGBX buffer; no display is opened."""

from collections.abc import Iterable
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.render import scene, shapes
from catch_arena.render.hud import Rect
from catch_arena.render.optional_imports import cv2, pygame
from catch_arena.render.sprites import label_sprite, ring_sprite, turtle_sprite
from catch_arena.render.viewport import OUTSIDE, Viewport
from catch_arena.replay.motion import Pose2D

Pixels = NDArray[np.uint8]

_SHIFT: Final = 4
"""Fractional bits of coordinates for cv2: sixteenths of a pixel."""
_WIDEST_RING: Final = 600.0
FADE_MS: Final = 200
"""Time of the match in which a trail fades by one step [ms]."""
_FADE: Final = 0.06
"""Part of its difference from the ground that a trail loses in a step: half of it in 2.2 s."""


class Canvas:
    """Buffer, or a part of one, on which shapes are drawn; anything outside is cut off."""

    def __init__(self, buffer: Pixels, surface: "pygame.Surface") -> None:
        self.pixels = buffer
        """Pixels of shape (height, width, 4): red, green, blue and an unused byte."""
        self._surface = surface

    @classmethod
    def blank(cls, width: int, height: int, color: shapes.Color) -> "Canvas":
        """Return a canvas on a new buffer of one colour."""
        buffer = np.full((height, width, 4), 255, dtype=np.uint8)
        canvas = cls(buffer, pygame.image.frombuffer(buffer.data, (width, height), "RGBX"))
        canvas.clear(Rect(0, 0, width, height), color)
        return canvas

    def clear(self, area: Rect, color: shapes.Color) -> None:
        """Fill a rectangle with one colour."""
        self._surface.fill(color, area)

    def part(self, area: Rect) -> "Canvas":
        """Return a canvas that shares the pixels of a rectangle."""
        left, top, width, height = area
        return Canvas(self.pixels[top : top + height, left : left + width], self._surface.subsurface(area))

    def draw(self, drawn: Iterable[shapes.Shape]) -> None:
        """Draw shapes, the first one lowest."""
        for shape in drawn:
            match shape:
                case shapes.Turtle():
                    self._blit(*turtle_sprite(shape))
                case shapes.Label():
                    if shape.text:
                        self._blit(*label_sprite(shape))
                case shapes.Ring():
                    self._ring(shape)
                case shapes.Sector():
                    self._sector(shape)
                case shapes.Path():
                    self._path(shape)
                case shapes.Polygon():
                    points = np.array(shape.points, dtype=np.float64)
                    self._fill(points, shape.color)
                case shapes.Box():
                    outline = _outline(shape.width, shape.height, shape.radius)
                    self._fill(outline + np.array((shape.left, shape.top)), shape.color)

    def _blit(self, sprite: Any, x: int, y: int) -> None:
        position = (x - sprite.origin_x, y - sprite.origin_y)
        self._surface.blit(sprite.surface, position, special_flags=pygame.BLEND_PREMULTIPLIED)

    def _ring(self, shape: shapes.Ring) -> None:
        if shape.radius <= _WIDEST_RING:
            self._blit(*ring_sprite(shape))
        elif shape.radius < 4 * max(self.pixels.shape):  # wider than that, its line is out of sight
            centre = (round(shape.x * 16 - 8), round(shape.y * 16 - 8))
            radius, width = round(shape.radius * 16), round(max(1, shape.width))
            cv2.circle(self.pixels, centre, radius, (*shape.color, 255), width, cv2.LINE_AA, _SHIFT)

    def _sector(self, shape: shapes.Sector) -> None:
        height, width = self.pixels.shape[:2]
        left, top, right, bottom = shape.within
        far = shape.radius + shape.soft
        x0, x1 = (round(min(max(x, left, 0.0), right, width)) for x in (shape.x - far, shape.x + far))
        y0, y1 = (round(min(max(y, top, 0.0), bottom, height)) for y in (shape.y - far, shape.y + far))
        if x0 >= x1 or y0 >= y1:
            return
        around = np.linspace(-0.5, 0.5, 97) * shape.angle + shape.theta
        points = shape.radius * np.stack([np.cos(around), -np.sin(around)], axis=1) + (shape.x, shape.y)
        if shape.angle < 2.0 * np.pi:
            points = np.vstack([points, (shape.x, shape.y)])
        mask = np.zeros((y1 - y0, x1 - x0), dtype=np.uint8)
        cv2.fillPoly(mask, [_sixteenths(points - (x0, y0))], 255, cv2.LINE_AA, _SHIFT)
        size = 2 * round(shape.soft) + 1
        mask = cv2.blur(mask, (size, size), borderType=cv2.BORDER_REPLICATE)
        part = self.pixels[y0:y1, x0:x1]
        cover = cv2.convertScaleAbs(mask, alpha=shape.opacity)
        tint = cv2.merge([cv2.convertScaleAbs(cover, alpha=channel / 255.0) for channel in (*shape.color, 255)])
        kept = cv2.multiply(part, cv2.merge([cv2.bitwise_not(cover)] * 4), scale=1.0 / 255.0)
        cv2.add(kept, tint, dst=part)

    def _path(self, shape: shapes.Path) -> None:
        points = _sixteenths(np.array(shape.points, dtype=np.float64))
        thick = max(1, round(shape.width))
        cv2.polylines(self.pixels, [points], False, (*shape.color, 255), thick, cv2.LINE_AA, _SHIFT)

    def _fill(self, points: NDArray[np.float64], color: shapes.Color) -> None:
        cv2.fillPoly(self.pixels, [_sixteenths(points)], (*color, 255), cv2.LINE_AA, _SHIFT)


def _sixteenths(points: NDArray[np.float64]) -> NDArray[np.int32]:
    """Return points in sixteenths of a pixel; cv2 counts from pixels' centres, shapes count from their edges."""
    return np.asarray(np.rint(points * 16.0 - 8.0), dtype=np.int32)


_QUARTER: Final = np.linspace(0.0, np.pi / 2.0, 9)


@lru_cache(maxsize=1024)
def _outline(width: float, height: float, radius: float) -> NDArray[np.float64]:
    """Return a box's outline, drawn in by half a pixel, since cv2 fills half a pixel beyond the points."""
    left, top, right, bottom = 0.5, 0.5, width - 0.5, height - 0.5
    radius = min(radius, (right - left) / 2.0, (bottom - top) / 2.0)
    if radius <= 0.3:
        return np.array([(left, top), (right, top), (right, bottom), (left, bottom)])
    across, up = radius * np.cos(_QUARTER), radius * np.sin(_QUARTER)
    x = np.concatenate([right - radius + across, left + radius - up, left + radius - across, right - radius + up])
    y = np.concatenate([bottom - radius + up, bottom - radius + across, top + radius - up, top + radius - across])
    return np.stack([x, y], axis=1)


class Ground:
    """Floor of the arena with its trails, which fade to nothing."""

    def __init__(self, viewport: Viewport) -> None:
        self._viewport = viewport
        clean = Canvas.blank(viewport.width, viewport.height, OUTSIDE)
        clean.draw(scene.ground_shapes(viewport))
        self._clean = clean.pixels
        self._floor = Canvas.blank(viewport.width, viewport.height, OUTSIDE)
        self.pixels = self._floor.pixels
        """Pixels of the floor, of shape (height, width, 4)."""
        # reused, since allocating a megabyte for every fade costs more than the fade
        self._above, self._below = np.empty_like(self._clean), np.empty_like(self._clean)
        self._time_ms = 0.0
        self.reset()

    def reset(self, time_ms: float = 0.0) -> None:
        """Remove all trails."""
        self.pixels[:] = self._clean
        self._time_ms = time_ms

    def draw_trail(self, way: list[Pose2D], agent_color: shapes.Color | None) -> None:
        """Draw a piece of an agent's way in its colour, or of the way of a target that no agent plays."""
        if any(pose[:2] != way[0][:2] for pose in way):
            self._floor.draw((scene.trail_shape(self._viewport, way, agent_color),))

    def fade(self, time_ms: float) -> None:
        """Fade the trails up to an instant, in at most 150 steps: after long waits there is nothing left to fade."""
        times = int(time_ms // FADE_MS) - int(self._time_ms // FADE_MS)
        floor, above, below = self.pixels, self._above, self._below
        for _ in range(min(times, 150)):
            cv2.subtract(floor, self._clean, above)
            cv2.subtract(self._clean, floor, below)
            # rounding 0.49 + part * difference keeps 0 at 0 and makes the least difference 1
            cv2.convertScaleAbs(above, above, _FADE, 0.49)
            cv2.convertScaleAbs(below, below, _FADE, 0.49)
            cv2.subtract(floor, above, floor)
            cv2.add(floor, below, floor)
        self._time_ms = time_ms
