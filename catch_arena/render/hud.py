"""Layout of a frame, and the shapes around its arena: the header, the clock and the scores.

Pure functions from small states to shapes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Literal, NamedTuple

from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import WHITE, Box, Color, Label, Shape, mix
from catch_arena.render.text import text_width
from catch_arena.world import World

FrameShape = Literal["landscape", "portrait", "square"]
"""Shape of a frame: by its width and height."""
Layout = Literal["broadcast", "arena"]
"""Layout of a frame: `broadcast` has standings and a timeline next to the arena, `arena` has one line over it."""

PANEL: Final[Color] = (12, 16, 42)
CARD: Final[Color] = (22, 29, 64)
TRACK: Final[Color] = (40, 47, 86)
DIM: Final[Color] = (150, 158, 204)
BRIGHT: Final[Color] = (240, 243, 255)

ROW: Final = 50.0
"""Greatest height of a line of the standings, in units."""
CLOSE_ROW: Final = 36.0
"""Height to which a line may shrink to leave room for the event feed, in units."""
_LONGEST_SEED: Final = 10**6
"""Least seed that is too long for a header; seeds of tournaments are."""
FEED_ROW: Final = 26.0
"""Height of a line of the event feed, in units."""
MOST_FEED_LINES: Final = 4
"""Greatest number of lines in the event feed."""
LEAST_FEED_WIDTH: Final = 200
"""Least width of the event feed [pixels]; a narrower line cannot be read."""
TEAMS: Final = 132.0
"""Greatest height of the teams' scores, in units."""
MOST_TEAMS: Final = 8
"""Greatest number of teams with a card of scores; more would be too small, and only the standings show scores."""
CAPTION: Final = 0.062
"""Height of a caption and the room around it, as a part of the arena's shorter side."""
WIDE: Final = 1.25
"""Least ratio of the longer side to the shorter one in a landscape or portrait frame; others are square."""
ARENA_PART: Final = 0.62
"""Part of a landscape frame's width that the arena takes."""
TIMELINE: Final = 170.0
"""Least height that the timeline keeps if the standings or the feed could take more, in units."""


class Rect(NamedTuple):
    """Rectangle in whole pixels."""

    left: int
    top: int
    width: int
    height: int

    def split(self, height: int, gap: int) -> tuple["Rect", "Rect"]:
        """Return the upper part of this height, and the rest below a gap."""
        rest = self._replace(top=self.top + height + gap, height=self.height - height - gap)
        return self._replace(height=height), rest


EMPTY_RECT: Final = Rect(0, 0, 0, 0)


@dataclass(frozen=True, slots=True)
class Arrangement:
    """Areas of a frame's parts; a part that is left out has no area."""

    arena: Rect
    header: Rect
    unit: float
    """Pixels of the frame per pixel of a 1280 x 720 one; texts and gaps scale with it."""
    teams: Rect = EMPTY_RECT
    standings: Rect = EMPTY_RECT
    feed: Rect = EMPTY_RECT
    timeline: Rect = EMPTY_RECT


class AgentScore(NamedTuple):
    """Score and state of one agent."""

    agent: int
    """Seat of a hunter; prey are numbered after the hunters."""
    score: int
    """Catches of a hunter, or the number of times that prey was caught."""
    withdrawn: bool = False
    hunted: bool = False
    """True for prey."""
    out: bool = False
    """R12.3: true for prey that was caught and has not returned."""

    @property
    def faded(self) -> bool:
        """True if the agent takes no part at present."""
        return self.withdrawn or self.out


def standings_of(world: World) -> tuple[AgentScore, ...]:
    """Return the scores of all agents of a world, hunters by seat and then prey by index."""
    hunters = [AgentScore(seat, hunter.score, hunter.withdrawn) for seat, hunter in enumerate(world.hunters)]
    prey = [
        AgentScore(agent, state.times_caught, state.withdrawn, hunted=True, out=state.target is None)
        for agent, state in enumerate(world.prey, start=len(hunters))
    ]
    return (*hunters, *prey)


def arrange(size: tuple[int, int], layout: Layout, agents: int, teams: int = 0) -> Arrangement:
    """Return the areas of a frame's parts: the panel is at the right if wide, below if tall, else around the arena.

    `agents` is the number of lines of the standings, and `teams` that of columns in the card of the teams' scores, 0
    for no such card.
    """
    width, height = size
    if layout == "arena":
        strip = max(22, round(0.056 * min(width, height)))
        return Arrangement(Rect(0, strip, width, height - strip), Rect(0, 0, width, strip), strip / 40.0)
    shape = frame_shape(size)
    if shape == "landscape":
        side = round(ARENA_PART * width)
        unit = min(height / 720.0, (width - side) / 486.0)
        gap, top = round(20 * unit), round(max(30.0, 48 * unit))
        header = Rect(side + gap, gap, width - side - 2 * gap, top)
        below = gap + top + round(14 * unit)
        cards = _cards(header._replace(top=below, height=height - below - gap), unit, agents, teams)
        return Arrangement(Rect(0, 0, side, height), header, unit, *cards)
    if shape == "portrait":
        unit = max(0.6, min(width / 560.0, height / 1160.0))
        gap = round(16 * unit)
        top = round(56 * unit) + gap
        arena = Rect(0, top, width, min(width, height - top - round(200 * unit)))
        below = top + arena.height + gap
        cards = _cards(Rect(gap, below, width - 2 * gap, height - below - gap), unit, agents, teams)
        return Arrangement(arena, Rect(gap, gap // 2, width - 2 * gap, top - gap), unit, *cards)
    unit = max(0.55, min(width, height) / 800.0)
    gap = round(14 * unit)
    top, bottom = round(56 * unit) + gap, round(max(0.2 * height, 84.0))
    arena_width = min(round(0.66 * width), round(1.1 * (height - top - bottom)))
    arena = Rect(0, top, arena_width, height - top - bottom)
    beside = Rect(arena_width + gap, top, width - arena_width - 2 * gap, arena.height)
    timeline = Rect(gap, height - bottom + gap, width - 2 * gap, bottom - 2 * gap)
    cards = _cards(beside, unit, agents, teams, timeline)
    return Arrangement(arena, Rect(gap, gap // 2, width - 2 * gap, top - gap), unit, *cards)


def frame_shape(size: tuple[int, int]) -> FrameShape:
    """Return the shape of a frame of (width, height)."""
    width, height = size
    return "landscape" if width >= WIDE * height else "portrait" if height >= WIDE * width else "square"


def _cards(
    panel: Rect, unit: float, agents: int, teams: int, timeline: Rect | None = None
) -> tuple[Rect, Rect, Rect, Rect]:
    """Return the areas of the teams' scores, standings, event feed and timeline, which lie one below the other.

    The timeline may have a place of its own; in a wide panel it lies next to the others. The feed is left out if less
    than two of its lines fit.
    """
    gap = round(14 * unit)
    if timeline is None and panel.width > 1.6 * panel.height:
        half = (panel.width - gap) // 2
        timeline = panel._replace(left=panel.left + half + gap, width=panel.width - half - gap)
        panel = panel._replace(width=half)
    scores = feed = EMPTY_RECT
    if 0 < teams <= MOST_TEAMS:
        scores, panel = panel.split(min(round(TEAMS * unit), round(0.3 * panel.height)), gap)
    reserved = 0 if timeline else min(round(0.36 * panel.height), round(TIMELINE * unit)) + gap
    roomy, close = (round((agents * row + 16) * unit) for row in (ROW, CLOSE_ROW))
    wanted = round((MOST_FEED_LINES * FEED_ROW + 16) * unit) + gap + reserved
    standings, rest = panel.split(min(max(close, min(roomy, panel.height - wanted)), panel.height - reserved), gap)
    rows = min(MOST_FEED_LINES, int((rest.height - reserved - 16 * unit) / (FEED_ROW * unit)))
    if rows >= 2 and panel.width >= LEAST_FEED_WIDTH and agents > 1:  # a single agent has no rivals
        feed, rest = rest.split(round(rows * FEED_ROW * unit + 16 * unit), gap)
    return scores, standings, feed, timeline or rest._replace(height=min(rest.height, round(0.95 * panel.width)))


def clock(time_ms: float) -> str:
    """Return the match's time as text: full tenths of a second, with minutes from three minutes on."""
    tenths = int(time_ms) // 100
    if tenths < 1800:
        return f"{tenths / 10:.1f}"
    return f"{tenths // 600}:{tenths % 600 / 10:04.1f}"


def ranked(standings: Sequence[AgentScore]) -> list[AgentScore]:
    """Return the hunters and then the prey (R12.5), each with the best first; equal scores in the order of seats."""
    return sorted(
        standings, key=lambda entry: (entry.hunted, entry.score if entry.hunted else -entry.score, entry.agent)
    )


def header_shapes(area: Rect, info: MatchInfo, seed: int | None, time_text: str, unit: float) -> list[Shape]:
    """Return the shapes of the title, the match's title and seed, and the clock."""
    big, small = font_size(34 * unit, 15), font_size(15 * unit, 10)
    right = area.left + area.width
    short_seed = f"seed {seed}" if seed is not None and seed < _LONGEST_SEED else ""
    subtitle = "   ".join(part for part in (info.title, short_seed) if part)
    whole = f"of {info.duration_ms / 1000:g} s"
    clock_room = len(time_text) * 0.68 * big + 1.6 * small
    room = area.width - clock_room - 8
    middle, below = area.top + area.height * (0.36 if subtitle else 0.5), area.top + area.height * 0.86
    shapes: list[Shape] = [
        Label(area.left, middle, "CATCH ARENA", font_size(28 * unit, 13), BRIGHT, 700, max_width=room),
        Label(right - 1.2 * small, middle, time_text, big, BRIGHT, 700, "right"),
        Label(right, middle + 0.36 * (big - small), "s" if ":" not in time_text else "", small, DIM, 500, "right"),
        Label(right, below, whole, small, DIM, 500, "right", max_width=clock_room),
        Label(area.left, below, subtitle, small, DIM, 500, max_width=room),
    ]
    return shapes


def chip_width(info: MatchInfo, size: float) -> float:
    """Return the width of a chip with an agent's number, next to text of that size [pixels]."""
    return (0.6 * max(len(info.number(agent)) for agent in (info.config.hunters - 1, len(info.names) - 1)) + 0.7) * size


def agent_chip(x: float, middle: float, info: MatchInfo, agent: int, size: float) -> list[Shape]:
    """Return the shapes of an agent's number on its colour; `x` is the left end, and all agents' are equally wide."""
    return chip(x, middle, info.number(agent), info.colors[agent], size, chip_width(info, size))


def chip(x: float, middle: float, text: str, color: Color, size: float, width: float = 0.0) -> list[Shape]:
    """Return the shapes of a short text on a colour; `x` is the left end, and a width of 0 is that of the text."""
    width, small = width or (0.6 * len(text) + 0.7) * size, font_size(0.82 * size, 9)
    return [
        Box(x, middle - 0.56 * size, width, 1.12 * size, color, 0.3 * size),
        Label(x + width / 2.0, middle, text, small, readable_on(color), 800, "center"),
    ]


def split_strip(area: Rect, info: MatchInfo) -> tuple[Rect, Rect]:
    """Return the parts of the line over the arena: for the scores, and for the clock at the right end."""
    room = round((len(clock(info.duration_ms)) + 1.5) * 0.62 * font_size(0.58 * area.height, 12))
    return area._replace(width=area.width - room), area._replace(left=area.left + area.width - room, width=room)


def strip_clock_shapes(area: Rect, time_text: str) -> list[Shape]:
    """Return the clock in the line over the arena."""
    size = font_size(0.58 * area.height, 12)
    x, middle = area.left + area.width - 0.5 * size, area.top + area.height / 2.0
    return [Label(x, middle, time_text, size, BRIGHT, 700, "right")]


def strip_shapes(area: Rect, info: MatchInfo, scores: Sequence[int], standings: Sequence[AgentScore]) -> list[Shape]:
    """Return the scores in the line over the arena: of all agents by seat, or of the teams and then the prey.

    Names are left out if not all fit. If not all agents fit without names, the best come first.
    """
    size = font_size(0.58 * area.height, 12)
    small, middle = font_size(0.8 * size, 10), area.top + area.height / 2.0
    room = area.width - 0.5 * size
    entries = [(str(score), one.color, one.name, "") for one, score in zip(info.contenders, scores, strict=True)]
    agents = [entry for entry in standings if entry.hunted or not info.has_teams]
    if not info.has_teams:
        entries = []
        if len(agents) * (chip_width(info, size) + 2.2 * size) > room:
            agents = ranked(agents)
    for entry in agents:
        color = mix(info.colors[entry.agent], PANEL, 0.6 * entry.faded)
        entries.append((info.number(entry.agent), color, info.names[entry.agent], str(entry.score)))
    # room for two digits: names do not vanish with the tenth catch
    widths = [(0.6 * len(text) + 1.6 + 0.66 * max(2, len(score)) * bool(score)) * size for text, _, _, score in entries]
    names = [0.3 * size + text_width(name, small, 600) for _, _, name, _ in entries]
    named = sum(widths) + sum(names) <= room
    x = area.left + 0.5 * size
    shapes: list[Shape] = []
    for (text, color, name, score), width, name_width in zip(entries, widths, names, strict=True):
        if x + width > area.left + room:
            break
        shapes += chip(x, middle, text, color, size)
        beside = x + (0.6 * len(text) + 1.0) * size
        if named:
            shapes.append(Label(beside, middle, name, small, DIM, 600))
            beside += name_width
        shapes.append(Label(beside, middle, score, size, BRIGHT, 700))
        x += width + name_width * named
    return shapes


@lru_cache(maxsize=256)
def legible(color: Color) -> Color:
    """Return a hunter's colour, lightened as far as texts and lines on a dark card need."""
    part = next(part / 10.0 for part in range(11) if _luminance(mix(color, WHITE, part / 10.0)) >= 105.0)
    return mix(color, WHITE, part)


def readable_on(color: Color) -> Color:
    """Return a dark or a bright text colour, whichever stands out from `color`."""
    return PANEL if _luminance(color) > 120 else BRIGHT


def _luminance(color: Color) -> float:
    return 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]


def font_size(pixels: float, smallest: int) -> int:
    """Return a text's size in whole pixels, at least `smallest` so that it can be read."""
    return max(smallest, round(pixels))
