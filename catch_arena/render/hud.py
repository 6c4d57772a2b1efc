"""What stands around the arena: where each part goes, who the match is between, and the clock.

Pure functions from small states to shapes.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Literal, NamedTuple

from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import WHITE, Box, Color, Label, Shape, mix
from catch_arena.render.text import printable, text_width
from catch_arena.world import World

Layout = Literal["broadcast", "arena"]
"""With a panel of standings and a timeline beside the arena, or with one line over it."""

PANEL: Final[Color] = (12, 16, 42)
CARD: Final[Color] = (22, 29, 64)
TRACK: Final[Color] = (40, 47, 86)
DIM: Final[Color] = (150, 158, 204)
BRIGHT: Final[Color] = (240, 243, 255)

ROW: Final = 50.0
"""The most that a line of the standings takes, in units."""
CLOSE_ROW: Final = 36.0
"""What it takes at most where the event feed would have no room otherwise."""
FEED_ROW: Final = 26.0
"""What a line of the event feed takes, in units."""
MOST_FEED_LINES: Final = 4
"""Lines."""
LEAST_FEED_WIDTH: Final = 200
"""Pixels: narrower than that, a line cannot be read."""
TEAMS: Final = 132.0
"""The most that the teams' scores take, in units."""
MOST_TEAMS: Final = 8
"""With more, each score would be too small; the standings tell them."""
TIMELINE: Final = 170.0
"""The least that the timeline keeps where the standings or the feed could take more, in units."""


class Rect(NamedTuple):
    """Whole pixels."""

    left: int
    top: int
    width: int
    height: int


EMPTY_RECT: Final = Rect(0, 0, 0, 0)


@dataclass(frozen=True, slots=True)
class Arrangement:
    """Where everything stands in a frame; what has no area is left out."""

    arena: Rect
    header: Rect
    unit: float
    """Pixels of the frame for a pixel of a 1280 x 720 one: texts and gaps follow it."""
    teams: Rect = EMPTY_RECT
    standings: Rect = EMPTY_RECT
    feed: Rect = EMPTY_RECT
    timeline: Rect = EMPTY_RECT


class AgentScore(NamedTuple):
    """What one agent has."""

    agent: int
    """A hunter's seat, or that of a prey behind them."""
    score: int
    """Catches; of prey, how often it was caught."""
    withdrawn: bool = False
    hunted: bool = False
    """It is prey."""
    out: bool = False
    """R12.3: prey that was caught and has not returned."""

    @property
    def faded(self) -> bool:
        """It takes no part just now."""
        return self.withdrawn or self.out


def standings_of(world: World, time_ms: float = math.inf) -> tuple[AgentScore, ...]:
    """What all agents of a world have, hunters by seat and then prey by index.

    Args:
        world: how a step ended.
        time_ms: an instant of that step: prey that returns at its end is still out then.
    """
    in_play = {target.name for target in world.targets if target.spawned_ms <= time_ms}
    hunters = [AgentScore(seat, hunter.score, hunter.withdrawn) for seat, hunter in enumerate(world.hunters)]
    prey = [
        AgentScore(agent, one.times_caught, one.withdrawn, hunted=True, out=one.target not in in_play)
        for agent, one in enumerate(world.prey, start=len(hunters))
    ]
    return (*hunters, *prey)


def arrange(size: tuple[int, int], layout: Layout, agents: int, teams: int = 0) -> Arrangement:
    """Where everything stands in a frame: the panel at the right of a wide one, below in a tall one, else around.

    Args:
        size: (width, height) of the frame.
        layout: with or without a panel.
        agents: how many lines the standings have.
        teams: how many columns the card of the teams' scores has, 0 for no such card.
    """
    width, height = size
    if layout == "arena":
        strip = max(22, round(0.056 * min(width, height)))
        return Arrangement(Rect(0, strip, width, height - strip), Rect(0, 0, width, strip), strip / 40.0)
    if width >= 1.25 * height:
        side = min(height, round(0.64 * width))
        unit = min(height / 720.0, (width - side) / 560.0)
        gap, top = round(20 * unit), round(48 * unit)
        header = Rect(side + gap, gap, width - side - 2 * gap, top)
        below = gap + top + round(14 * unit)
        cards = _cards(header._replace(top=below, height=height - below - gap), unit, agents, teams)
        return Arrangement(Rect(0, 0, side, height), header, unit, *cards)
    if height >= 1.25 * width:
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
    scores, beside = _with_teams(beside, unit, teams)
    standings, feed = _with_feed(beside, unit, agents, 0)
    timeline = Rect(gap, height - bottom + gap, width - 2 * gap, bottom - 2 * gap)
    return Arrangement(arena, Rect(gap, gap // 2, width - 2 * gap, top - gap), unit, scores, standings, feed, timeline)


def _cards(panel: Rect, unit: float, agents: int, teams: int) -> tuple[Rect, Rect, Rect, Rect]:
    """Teams' scores, standings, event feed and timeline: one below the other, or the last beside the others in a wide
    panel.
    """
    gap = round(14 * unit)
    if panel.width > 1.6 * panel.height:
        half = (panel.width - gap) // 2
        right = Rect(panel.left + half + gap, panel.top, panel.width - half - gap, panel.height)
        scores, left = _with_teams(panel._replace(width=half), unit, teams)
        return scores, *_with_feed(left, unit, agents, 0), right
    scores, panel = _with_teams(panel, unit, teams)
    least = min(round(0.36 * panel.height), round(TIMELINE * unit))
    standings, feed = _with_feed(panel, unit, agents, least + gap)
    last = feed if feed.height else standings
    top = last.top + last.height + gap
    height = min(panel.top + panel.height - top, round(0.95 * panel.width))
    return scores, standings, feed, Rect(panel.left, top, panel.width, height)


def _with_teams(panel: Rect, unit: float, teams: int) -> tuple[Rect, Rect]:
    """The card of the teams' scores, and what is left below it."""
    if not 0 < teams <= MOST_TEAMS:
        return EMPTY_RECT, panel
    height, gap = min(round(TEAMS * unit), round(0.3 * panel.height)), round(14 * unit)
    below = panel._replace(top=panel.top + height + gap, height=panel.height - height - gap)
    return panel._replace(height=height), below


def _with_feed(area: Rect, unit: float, agents: int, reserved: int) -> tuple[Rect, Rect]:
    """The standings, and below them the feed if two lines of it fit; so many pixels below belong to others."""
    gap = round(14 * unit)
    wanted = round((MOST_FEED_LINES * FEED_ROW + 16) * unit) + gap + reserved
    roomy, close = (round((agents * row + 16) * unit) for row in (ROW, CLOSE_ROW))
    height = min(max(close, min(roomy, area.height - wanted)), area.height - reserved)
    left = area.height - height - reserved - gap
    rows = min(MOST_FEED_LINES, int((left - 16 * unit) / (FEED_ROW * unit)))
    if rows < 2 or area.width < LEAST_FEED_WIDTH or agents == 1:  # one alone has nobody to be near
        return area._replace(height=height), EMPTY_RECT
    feed = Rect(area.left, area.top + height + gap, area.width, round(rows * FEED_ROW * unit + 16 * unit))
    return area._replace(height=height), feed


def clock(time_ms: float) -> str:
    """The match's time as it is shown: tenths of a second that have passed in full, minutes from three minutes on."""
    tenths = int(time_ms) // 100
    if tenths < 1800:
        return f"{tenths / 10:.1f}"
    return f"{tenths // 600}:{tenths % 600 / 10:04.1f}"


def ranked(standings: Sequence[AgentScore]) -> list[AgentScore]:
    """Hunters, and below them prey (R12.5), the best first; equal scores in the order of seats."""
    return sorted(standings, key=lambda one: (one.hunted, one.score if one.hunted else -one.score, one.agent))


def header_shapes(area: Rect, info: MatchInfo, seed: int | None, time_text: str, unit: float) -> list[Shape]:
    """The title, what match this is, and the clock."""
    big, small = font_size(34 * unit, 15), font_size(15 * unit, 10)
    right = area.left + area.width
    about = "   ".join(part for part in (info.title, "" if seed is None else f"seed {seed}") if part)
    clock_room = len(time_text) * 0.68 * big + 1.6 * small
    middle = area.top + area.height * (0.36 if about else 0.5)
    shapes: list[Shape] = [
        Label(
            area.left,
            middle,
            "CATCH ARENA",
            font_size(28 * unit, 13),
            BRIGHT,
            700,
            max_width=area.width - clock_room - 8,
        ),
        Label(right - 1.2 * small, middle, time_text, big, BRIGHT, 700, "right"),
        Label(right, middle + 0.36 * (big - small), "s" if ":" not in time_text else "", small, DIM, 500, "right"),
    ]
    if about:
        shapes.append(
            Label(
                area.left, area.top + area.height * 0.86, about, small, DIM, 500, max_width=area.width - clock_room - 8
            )
        )
    return shapes


def split_strip(area: Rect, time_text: str) -> tuple[Rect, Rect]:
    """The line over the arena: the part for the scores, and the clock's at its right end."""
    room = round((len(time_text) + 1.5) * 0.62 * font_size(0.58 * area.height, 12))
    return area._replace(width=area.width - room), area._replace(left=area.left + area.width - room, width=room)


def strip_clock_shapes(area: Rect, time_text: str) -> list[Shape]:
    """The clock in the line over the arena."""
    size = font_size(0.58 * area.height, 12)
    return [
        Label(area.left + area.width - 0.5 * size, area.top + area.height / 2.0, time_text, size, BRIGHT, 700, "right")
    ]


def chip_width(info: MatchInfo, size: float) -> float:
    """Of the chips that bear a match's numbers beside text of that size."""
    return (0.6 * max(len(info.number(agent)) for agent in (info.config.hunters - 1, len(info.names) - 1)) + 0.7) * size


def chip(x: float, middle: float, info: MatchInfo, agent: int, size: float, *, faded: bool = False) -> list[Shape]:
    """An agent's number on its colour; `x` is its left end."""
    color = mix(info.color(agent), PANEL, 0.6 if faded else 0.0)
    width = chip_width(info, size)
    return [
        Box(x, middle - 0.56 * size, width, 1.12 * size, color, 0.3 * size),
        Label(
            x + width / 2.0, middle, info.number(agent), font_size(0.82 * size, 9), readable_on(color), 800, "center"
        ),
    ]


def chip_shapes(area: Rect, info: MatchInfo, scores: Sequence[int], standings: Sequence[AgentScore]) -> list[Shape]:
    """The scores in the line over the arena: every agent's by seat, or those of teams and then of prey.

    Without names where there is no room for all; of agents only the best, where there is no room even then.
    """
    size = font_size(0.58 * area.height, 12)
    small, middle, room = font_size(0.8 * size, 10), area.top + area.height / 2.0, area.width - 0.5 * size
    x = area.left + 0.5 * size
    shapes: list[Shape] = []
    shown: Sequence[AgentScore]
    if info.has_teams:
        wide = (0.66 * max(2, *(len(str(score)) for score in scores)) + 0.6) * size
        names = _name_widths([one.name for one in info.contenders], size, wide + 0.9 * size, room)
        for contender, score, name in zip(info.contenders, scores, names, strict=True):
            if x + wide > area.left + room:
                break
            shapes += [
                Box(x, middle - 0.62 * size, wide, 1.24 * size, contender.color, 0.3 * size),
                Label(x + wide / 2.0, middle, str(score), size, readable_on(contender.color), 800, "center"),
            ]
            if name:
                label = Label(x + wide + 0.3 * size, middle, contender.name, small, legible(contender.color), 600)
                shapes.append(label)
            x += wide + name + 0.9 * size
        names, digits = [0.0] * len(info.names), 0
        shown = [one for one in standings if one.hunted]
    else:
        digits = max(len(str(one.score)) for one in standings)
        step = chip_width(info, size) + (0.9 + 0.66 * digits) * size
        coming = 0.66 * max(0, 2 - digits) * size  # names do not vanish with the tenth catch
        names = _name_widths(info.names, size, step + coming, room)
        fits = max(1, int(room // step))
        shown = sorted(standings) if fits >= len(standings) else ranked(standings)[:fits]
    for one in shown:
        step = chip_width(info, size) + (0.9 + 0.66 * max(digits, len(str(one.score)))) * size
        if info.has_teams and x + step > area.left + room:
            break
        shapes += chip(x, middle, info, one.agent, size, faded=one.faded)
        beside = x + chip_width(info, size) + 0.3 * size
        if names[one.agent]:
            shapes.append(Label(beside, middle, info.names[one.agent], small, DIM, 600))
        shapes.append(Label(beside + names[one.agent], middle, str(one.score), size, BRIGHT, 700))
        x += step + names[one.agent]
    return shapes


def _name_widths(names: Sequence[str], size: int, step: float, room: float) -> list[float]:
    """How much room each name takes besides its step; none where there is no room for all."""
    widths = [0.3 * size + text_width(printable(name), font_size(0.8 * size, 10), 600) for name in names]
    return widths if sum(widths) + len(widths) * step <= room else [0.0] * len(widths)


@lru_cache(maxsize=256)
def legible(color: Color) -> Color:
    """A hunter's colour, lightened as far as texts and lines on a dark card need it."""
    part = next(part / 10.0 for part in range(11) if _luminance(mix(color, WHITE, part / 10.0)) >= 105.0)
    return mix(color, WHITE, part)


def readable_on(color: Color) -> Color:
    """Dark or bright, whichever stands out from that colour."""
    return PANEL if _luminance(color) > 120 else BRIGHT


def _luminance(color: Color) -> float:
    return 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]


def font_size(pixels: float, least: int) -> int:
    """A text's size: whole pixels, and enough of them to be read."""
    return max(least, round(pixels))
