"""Place of the arena's square in a picture, sizes of things in it, and the colours of all but the hunters."""

from typing import Final

from catch_arena.render.shapes import Color

GROUND: Final[Color] = (69, 86, 255)
"""Blue of turtlesim's ground."""
OUTSIDE: Final[Color] = (62, 77, 236)
TARGET: Final[Color] = (240, 234, 255)
TARGET_TRAIL: Final[Color] = (180, 165, 120)
"""Sand colour of a moving target's trail."""

HUNTER_LENGTH_M: Final = 0.66
TARGET_LENGTH_M: Final = 0.44
PREY_LENGTH_M: Final = 0.55
MARGIN: Final = 0.03
"""Room outside the walls, as a part of the side: a turtle at a wall is seen whole."""


class Viewport:
    """Place of the arena's square in a picture: as large as fits, in the middle, with a margin.

    Lengths and widths are in pixels.
    """

    def __init__(self, width: int, height: int, side_m: float) -> None:
        self.width, self.height, self.side_m = width, height, side_m
        shorter = min(width, height)
        self.scale = shorter / (side_m * (1.0 + 2.0 * MARGIN))
        """Pixels per metre."""
        half = side_m * self.scale / 2.0
        self._left, self._bottom = width / 2.0 - half, height / 2.0 + half
        self.hunter_length = max(HUNTER_LENGTH_M * self.scale, 20.0, shorter / 26.0)
        """Length of a hunter: HUNTER_LENGTH_M to scale, unless that would be too small to see."""
        self.target_length = self.hunter_length * TARGET_LENGTH_M / HUNTER_LENGTH_M
        self.prey_length = self.hunter_length * PREY_LENGTH_M / HUNTER_LENGTH_M
        self.trail_width = max(1.6, 0.1 * self.hunter_length)
        self.target_trail_width = max(1.2, 0.06 * self.hunter_length)

    def to_pixels(self, x: float, y: float) -> tuple[float, float]:
        """Return a point of the world [m] in pixels."""
        return self._left + x * self.scale, self._bottom - y * self.scale
