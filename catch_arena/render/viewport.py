"""Where in a picture the arena's square lies, how large things are in it, and the colours of all but the hunters."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

from catch_arena.render.shapes import Color

GROUND: Final[Color] = (69, 86, 255)
"""turtlesim's blue."""
OUTSIDE: Final[Color] = (62, 77, 236)
TRACE: Final[Color] = (94, 113, 255)
"""What remains of a trail."""
TARGET: Final[Color] = (240, 234, 255)
TARGET_TRAIL: Final[Color] = (180, 165, 120)
"""Sand: what a moving target leaves."""

HUNTER_LENGTH_M: Final = 0.66
TARGET_LENGTH_M: Final = 0.44
PREY_LENGTH_M: Final = 0.55
MARGIN: Final = 0.03
"""Room outside the walls, as a part of the side: a turtle at a wall is seen whole."""


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

    def to_pixels(self, x: float, y: float) -> tuple[float, float]:
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
    def prey_length(self) -> float:
        """Pixels."""
        return self.hunter_length * PREY_LENGTH_M / HUNTER_LENGTH_M

    @cached_property
    def trail_width(self) -> float:
        """Pixels."""
        return max(1.6, 0.1 * self.hunter_length)

    @cached_property
    def target_trail_width(self) -> float:
        """Pixels."""
        return max(1.2, 0.06 * self.hunter_length)
