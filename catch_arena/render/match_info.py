"""Who plays in a match that is shown: names, colours and rings of the agents, and who is ranked against whom."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError
from catch_arena.render.shapes import INK, WHITE, Color, mix
from catch_arena.render.viewport import TARGET
from catch_arena.replay import Replay

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
_COLOR_NAMES: Final = ("amber", "mint", "pink", "lime", "red", "sky", "green", "purple")
_TEAM_COLORS: Final = (0, 1, 7, 6, 2, 5, 4, 3)
"""Which of them teams have, in this order: the first four keep apart in all shades of their members."""
_SHADES: Final = (("", WHITE, 0.0), ("light ", WHITE, 0.42), ("dark ", INK, 0.3))
"""Where there are more than eight: their names, and what is mixed in."""
_MEMBER_SHADES: Final = ((INK, 0.0), (INK, 0.15), (WHITE, 0.2), (INK, 0.28))
"""What is mixed into a team's colour, for one member after the other, and over again: they have numbers too."""


@dataclass(frozen=True, slots=True)
class Contender:
    """Who is ranked against others: a team, or where there are none a hunter."""

    name: str
    color: Color
    seats: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class MatchInfo:
    """What does not change during a match: its arena, and how each agent is called and coloured.

    Agents are the hunters by seat, and behind them the prey by index.
    """

    config: ArenaConfig
    names: tuple[str, ...]
    """By agent."""
    title: str
    duration_ms: int
    """Of the match: the length of the timeline."""
    contenders: tuple[Contender, ...]
    colors: tuple[Color, ...]
    """By agent."""
    rings: tuple[int, ...]
    """By seat: of how many pieces a hunter's circle is. Agents that sit in several seats are told apart by it."""
    contender_by_seat: tuple[int, ...]

    @classmethod
    def of(
        cls, config: ArenaConfig, names: Sequence[str] | None = None, title: str = "", duration_ms: int | None = None
    ) -> "MatchInfo":
        """Those of one match; agents without names are called as PettingZoo calls them."""
        agents = config.hunter_names + config.prey_names
        called = agents if names is None else tuple(names)
        if len(called) != len(agents):
            prey = f" and {config.prey} prey" if config.prey else ""
            raise ConfigError(f"names must be one for each of {config.hunters} hunters{prey}, got {len(called)}")
        hunters = called[: config.hunters]
        return cls(
            config,
            called,
            title,
            config.time_limit_ms if duration_ms is None else duration_ms,
            _contenders(config, hunters),
            (*_hunter_colors(config), *(TARGET,) * config.prey),
            tuple(hunters[:seat].count(name) + 1 for seat, name in enumerate(hunters)),
            config.team_by_seat,
        )

    @classmethod
    def of_replay(cls, replay: Replay, title: str | None = None) -> "MatchInfo":
        """Those of a recorded match; a title in place of its own."""
        lasted_ms = replay.steps * replay.config.control_period_ms
        return cls.of(replay.config, replay.names, replay.title if title is None else title, lasted_ms)

    @property
    def has_teams(self) -> bool:
        """R11.1."""
        return self.config.teams is not None

    def color(self, agent: int) -> Color:
        """An agent's colour."""
        return self.colors[agent]

    def number(self, agent: int) -> str:
        """What stands for an agent where there is little room: a hunter's seat, or P and a prey's index."""
        hunters = self.config.hunters
        return str(agent) if agent < hunters else f"P{agent - hunters}"

    def called(self, agent: int) -> str:
        """What an agent is called: prey by its own name, a hunter by its contender's."""
        hunts = agent < self.config.hunters
        return self.contenders[self.contender_by_seat[agent]].name if hunts else self.names[agent]

    def prey(self, name: str) -> int:
        """The agent that PettingZoo calls `prey_{index}`."""
        return self.config.hunters + int(name.removeprefix("prey_"))


def _hunter_colors(config: ArenaConfig) -> list[Color]:
    """Without teams eight, then the same eight lighter, then darker, and again; else shades of each team's colour."""
    if config.teams is None:
        return [_color(seat) for seat in range(config.hunters)]
    colors = [WHITE] * config.hunters
    for team, seats in enumerate(config.teams):
        for member, seat in enumerate(seats):
            colors[seat] = mix(_color(_team_number(team)), *_MEMBER_SHADES[member % len(_MEMBER_SHADES)])
    return colors


def _team_number(team: int) -> int:
    """Which of the colours a team has."""
    rounds, place = divmod(team, len(_TEAM_COLORS))
    return rounds * len(_TEAM_COLORS) + _TEAM_COLORS[place]


def _color(number: int) -> Color:
    _, other, part = _SHADES[number // len(HUNTER_COLORS) % len(_SHADES)]
    return mix(HUNTER_COLORS[number % len(HUNTER_COLORS)], other, part)


def _color_name(number: int) -> str:
    return _SHADES[number // len(HUNTER_COLORS) % len(_SHADES)][0] + _COLOR_NAMES[number % len(HUNTER_COLORS)]


def _contenders(config: ArenaConfig, names: Sequence[str]) -> tuple[Contender, ...]:
    """A team is called as its only agent is; by its colour where it has several, or another team has the same."""
    if config.teams is None:
        return tuple(Contender(name, _color(seat), (seat,)) for seat, name in enumerate(names))
    agents = [{names[seat] for seat in seats} for seats in config.teams]
    contenders = []
    for team, seats in enumerate(config.teams):
        number, alone = _team_number(team), len(agents[team]) == 1 and agents.count(agents[team]) == 1
        contenders.append(Contender(names[seats[0]] if alone else _color_name(number), _color(number), seats))
    return tuple(contenders)
