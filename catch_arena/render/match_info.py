"""Who plays in a match that is shown: each seat's name and colour."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.render.shapes import INK, WHITE, Color, mix

HUNTER_COLORS: Final[tuple[Color, ...]] = (
    (241, 160, 28),
    (59, 253, 189),
    (255, 80, 160),
    (215, 255, 101),
    (214, 25, 30),
    (114, 190, 255),
    (31, 130, 74),
    (119, 29, 127),
)
"""Eight that stay apart, from each other, the ground and what targets leave, for the colour-blind too; a test measures
it.
"""


@dataclass(frozen=True, slots=True)
class MatchInfo:
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
    ) -> "MatchInfo":
        """Those of one match; agents without names are called as PettingZoo calls them."""
        seat_names = config.hunter_names if names is None else tuple(names)
        if len(seat_names) != config.hunters:
            raise ConfigError(f"names must be one for each of {config.hunters} hunters, got {len(seat_names)}")
        return cls(config, seat_names, title, config.time_limit_ms if duration_ms is None else duration_ms)

    def color(self, seat: int) -> Color:
        """A seat's colour: eight, then the same eight lighter, then darker, and again."""
        color = HUNTER_COLORS[seat % len(HUNTER_COLORS)]
        shade = seat // len(HUNTER_COLORS) % 3
        return (color, mix(color, WHITE, 0.42), mix(color, INK, 0.3))[shade]
