"""Names, colours and rings of the agents in a match that is shown, and the contenders of its ranking."""

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
"""Eight colours that stay apart from each other, the ground and the trails of targets, also for colour-blind users.

A test measures this.
"""
_COLOR_NAMES: Final = ("amber", "mint", "pink", "lime", "red", "sky", "green", "purple")
_TEAM_COLORS: Final = (0, 1, 7, 6, 2, 5, 4, 3)
"""Colours of teams, in this order: the first four stay apart in all shades of their members."""
_SHADES: Final = (("", WHITE, 0.0), ("light ", WHITE, 0.42), ("dark ", INK, 0.3))
"""Shades for more than eight colours: prefix of the name, colour that is mixed in, and its part."""
_MEMBER_SHADES: Final = ((INK, 0.0), (INK, 0.15), (WHITE, 0.2), (INK, 0.28))
"""Colour and part that are mixed into a team's colour, by member; they repeat, since members have numbers too."""


@dataclass(frozen=True, slots=True)
class Contender:
    """Competitor in the ranking: a team, or a hunter if there are no teams."""

    name: str
    color: Color
    seats: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class MatchInfo:
    """Facts that do not change during a match: its arena, and the names and colours of its agents.

    Agents are the hunters by seat, then the prey by index.
    """

    config: ArenaConfig
    names: tuple[str, ...]
    """Names by agent."""
    title: str
    duration_ms: int
    """Duration of the match, which is the length of the timeline [ms]."""
    contenders: tuple[Contender, ...]
    colors: tuple[Color, ...]
    """Colours by agent."""
    rings: tuple[int, ...]
    """Number of arcs of each hunter's circle, by seat; it distinguishes the seats of one agent."""
    contender_by_seat: tuple[int, ...]

    @classmethod
    def of(
        cls, config: ArenaConfig, names: Sequence[str] | None = None, title: str = "", duration_ms: int | None = None
    ) -> "MatchInfo":
        """Return the facts of one match; without `names`, agents have their names in PettingZoo."""
        agents = config.hunter_names + config.prey_names
        called = agents if names is None else tuple(names)
        if len(called) != len(agents):
            prey = f" and {config.prey} prey" if config.prey else ""
            raise ConfigError(f"names must have one for each of {config.hunters} hunters{prey}, got {len(called)}")
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
        """Return the facts of a recorded match; `title` replaces its own title."""
        return cls.of(replay.config, replay.names, replay.title if title is None else title, replay.duration_ms)

    @property
    def has_teams(self) -> bool:
        """R11.1: true if the match has teams."""
        return self.config.teams is not None

    def color(self, agent: int) -> Color:
        """Return an agent's colour."""
        return self.colors[agent]

    def number(self, agent: int) -> str:
        """Return the shortest label of an agent: a hunter's seat, or P and a prey's index."""
        hunters = self.config.hunters
        return str(agent) if agent < hunters else f"P{agent - hunters}"

    def called(self, agent: int) -> str:
        """Return the name shown for an agent: a prey's own name, or the name of a hunter's contender."""
        hunts = agent < self.config.hunters
        return self.contenders[self.contender_by_seat[agent]].name if hunts else self.names[agent]

    def prey(self, name: str) -> int:
        """Return the number of the agent that PettingZoo calls `prey_{index}`."""
        return self.config.hunters + int(name.removeprefix("prey_"))


def _hunter_colors(config: ArenaConfig) -> list[Color]:
    """Return the hunters' colours by seat.

    Without teams these are eight, then the same eight lighter, then darker, and again; else shades of a team's colour.
    """
    if config.teams is None:
        return [_color(seat) for seat in range(config.hunters)]
    colors = [WHITE] * config.hunters
    for team, seats in enumerate(config.teams):
        for member, seat in enumerate(seats):
            colors[seat] = mix(_color(_team_number(team)), *_MEMBER_SHADES[member % len(_MEMBER_SHADES)])
    return colors


def _team_number(team: int) -> int:
    """Return the number of a team's colour."""
    rounds, place = divmod(team, len(_TEAM_COLORS))
    return rounds * len(_TEAM_COLORS) + _TEAM_COLORS[place]


def _color(number: int) -> Color:
    _, shade, part = _SHADES[number // len(HUNTER_COLORS) % len(_SHADES)]
    return mix(HUNTER_COLORS[number % len(HUNTER_COLORS)], shade, part)


def _color_name(number: int) -> str:
    return _SHADES[number // len(HUNTER_COLORS) % len(_SHADES)][0] + _COLOR_NAMES[number % len(HUNTER_COLORS)]


def _contenders(config: ArenaConfig, names: Sequence[str]) -> tuple[Contender, ...]:
    """Return the contenders, by seat or by team.

    A team has the name of its only agent, or of its colour if it has several agents or another team has the same one.
    """
    if config.teams is None:
        return tuple(Contender(name, _color(seat), (seat,)) for seat, name in enumerate(names))
    agents = [{names[seat] for seat in seats} for seats in config.teams]
    contenders = []
    for team, seats in enumerate(config.teams):
        number, alone = _team_number(team), len(agents[team]) == 1 and agents.count(agents[team]) == 1
        contenders.append(Contender(names[seats[0]] if alone else _color_name(number), _color(number), seats))
    return tuple(contenders)
