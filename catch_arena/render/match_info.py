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
_PALETTE: Final = tuple(
    (shade + name, mix(color, added, part))
    for shade, added, part in (("", WHITE, 0.0), ("light ", WHITE, 0.42), ("dark ", INK, 0.3))
    for name, color in zip(_COLOR_NAMES, HUNTER_COLORS, strict=True)
)
"""Names and colours by number: the eight, then the same lighter, then darker; after that they repeat."""
_MEMBER_SHADES: Final = ((INK, 0.0), (INK, 0.15), (WHITE, 0.2), (INK, 0.28))
"""Colour and part that are mixed into the colour of a team or an agent, by its hunters; they repeat, since hunters have
numbers too.
"""


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
    event: str
    """Heading of the title at a video's beginning, such as a tournament's name and date; empty for none."""
    duration_ms: int
    """Duration of the match, which is the length of the timeline [ms]."""
    contenders: tuple[Contender, ...]
    colors: tuple[Color, ...]
    """Colours by agent."""
    rings: tuple[int, ...]
    """Number of arcs of each hunter's circle, by seat; it distinguishes the seats of one agent."""

    @classmethod
    def of(
        cls,
        config: ArenaConfig,
        names: Sequence[str] | None = None,
        title: str = "",
        duration_ms: int | None = None,
        colors: Sequence[int] = (),
        event: str = "",
    ) -> "MatchInfo":
        """Return the facts of one match.

        By default agents have their names in PettingZoo, and the duration is the time limit. `colors` are numbers of
        the hunters' colours by seat, as `Replay.colors`; by default colours go by seat.
        """
        agents = config.hunter_names + config.prey_names
        called = agents if names is None else tuple(names)
        if len(called) != len(agents):
            prey = f" and {config.prey} prey" if config.prey else ""
            raise ConfigError(f"names must have one for each of {config.hunters} hunters{prey}, got {len(called)}")
        hunters, numbers = called[: config.hunters], _color_numbers(config, colors)
        return cls(
            config,
            called,
            title,
            event,
            config.time_limit_ms if duration_ms is None else duration_ms,
            _contenders(config, hunters, numbers),
            (*_hunter_colors(numbers), *(TARGET,) * config.prey),
            tuple(hunters[:seat].count(name) + 1 for seat, name in enumerate(hunters)),
        )

    @classmethod
    def of_replay(cls, replay: Replay, title: str | None = None, event: str = "") -> "MatchInfo":
        """Return the facts of a recorded match; `title` replaces its own title."""
        title = replay.title if title is None else title
        return cls.of(replay.config, replay.names, title, replay.duration_ms, replay.colors, event)

    @property
    def has_teams(self) -> bool:
        """R11.1: true if the match has teams."""
        return self.config.teams is not None

    def number(self, agent: int) -> str:
        """Return the shortest label of an agent: a hunter's seat, or P and a prey's index."""
        hunters = self.config.hunters
        return str(agent) if agent < hunters else f"P{agent - hunters}"

    def label(self, agent: int) -> str:
        """Return an agent's name, with its number if it is empty or another agent has the same name."""
        name = self.names[agent]
        return name if name and self.names.count(name) == 1 else f"{name} {self.number(agent)}".strip()

    def called(self, agent: int) -> str:
        """Return the name shown for an agent: a prey's own name, or the name of a hunter's contender."""
        hunts = agent < self.config.hunters
        return self.contenders[self.config.team_by_seat[agent]].name if hunts else self.names[agent]

    def prey(self, name: str) -> int:
        """Return the number of the agent that PettingZoo calls `prey_{index}`."""
        return self.config.hunters + int(name.removeprefix("prey_"))


def agent_color(config: ArenaConfig, number: int) -> Color:
    """Return the colour of an agent of a tournament, or of its teams, in all videos and pages of the tournament."""
    return _named_color(number if config.teams is None else _team_number(number))[1]


def _color_numbers(config: ArenaConfig, given: Sequence[int]) -> tuple[int, ...]:
    """Return the number of each hunter's colour: that of its agent or seat, or that of its team (R11.1)."""
    if config.teams is None:
        return tuple(given or range(config.hunters))
    agents = [{given[seat] for seat in seats} for seats in config.teams] if given else []
    by_agent = len(set().union(*agents)) == len(config.teams) == sum(map(len, agents))
    return tuple(_team_number(given[seat] if by_agent else team) for seat, team in enumerate(config.team_by_seat))


def _hunter_colors(numbers: Sequence[int]) -> tuple[Color, ...]:
    """Return the hunters' colours by seat; several hunters of one agent or team have shades of its colour."""
    shades = [_MEMBER_SHADES[numbers[:seat].count(number) % len(_MEMBER_SHADES)] for seat, number in enumerate(numbers)]
    return tuple(mix(_named_color(number)[1], *shade) for number, shade in zip(numbers, shades, strict=True))


def _team_number(team: int) -> int:
    """Return the number of a team's colour."""
    place = team % len(_TEAM_COLORS)
    return team - place + _TEAM_COLORS[place]


def _named_color(number: int) -> tuple[str, Color]:
    """Return the name of a colour, and the colour, by its number."""
    return _PALETTE[number % len(_PALETTE)]


def _contenders(config: ArenaConfig, names: Sequence[str], numbers: Sequence[int]) -> tuple[Contender, ...]:
    """Return the contenders, by seat or by team.

    A team has the name of its only agent, or of its colour if it has several agents or another team has the same one.
    """
    if config.teams is None:
        colors = _hunter_colors(numbers)
        return tuple(Contender(name or str(seat), colors[seat], (seat,)) for seat, name in enumerate(names))
    agents = [{names[seat] for seat in seats} for seats in config.teams]
    contenders = []
    for team, seats in enumerate(config.teams):
        name, color = _named_color(numbers[seats[0]])
        alone = len(agents[team]) == 1 and agents.count(agents[team]) == 1
        contenders.append(Contender(names[seats[0]] if alone else name, color, seats))
    return tuple(contenders)
