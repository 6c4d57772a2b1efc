"""Animated standings: a line for each agent, the best first; a line that gains a position climbs to it.

Pure functions from small states to shapes.
"""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

from catch_arena.render.hud import BRIGHT, CARD, DIM, ROW, TRACK, AgentScore, Rect, font_size, legible, ranked
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import Box, Label, Shape, Turtle, mix

CLIMB_MS: Final = 400.0
"""Time that a line takes to its new position, and a bar to its new length [ms]."""


class AnimatedLine(NamedTuple):
    """Line of one agent at an instant."""

    agent_score: AgentScore
    position: float
    """Position from 0, the best; between two positions while the line moves."""
    share: float
    """Score as a part of the best one, which is the length of the bar; 0 for prey, which has none."""
    climbs: bool = False


class StandingsAnimation:
    """Animation of all agents' lines, from the standings as they change."""

    def __init__(self) -> None:
        self._goal: tuple[AnimatedLine, ...] = ()
        self._start: tuple[AnimatedLine, ...] = ()
        self._since_ms = -math.inf

    def record(self, time_ms: float, standings: Sequence[AgentScore]) -> None:
        """Set the standings from an instant on; lines whose position or bar differs begin to move."""
        now = self.lines(time_ms)
        best = max(1, *(entry.score for entry in standings if not entry.hunted)) if standings else 1
        positions = {entry.agent: position for position, entry in enumerate(ranked(standings))}
        goal = tuple(
            AnimatedLine(entry, float(positions[entry.agent]), 0.0 if entry.hunted else entry.score / best)
            for entry in sorted(standings)
        )
        if goal == self._goal:
            return
        self._start, self._goal = now or goal, goal
        self._since_ms = time_ms if now else -math.inf

    def lines(self, time_ms: float) -> tuple[AnimatedLine, ...]:
        """Return the lines by agent; it is the same tuple at all instants at which no line moves."""
        part = (time_ms - self._since_ms) / CLIMB_MS
        if part >= 1.0:
            return self._goal
        eased = part * part * (3.0 - 2.0 * part)
        return tuple(
            AnimatedLine(
                goal.agent_score,
                start.position + (goal.position - start.position) * eased,
                start.share + (goal.share - start.share) * eased,
                goal.position < start.position,
            )
            for start, goal in zip(self._start, self._goal, strict=True)
        )


def standings_shapes(
    area: Rect, info: MatchInfo, lines: Sequence[AnimatedLine], unit: float, view_of: int | None = None
) -> list[Shape]:
    """Return a line for each agent: turtle, number, name, a bar of its share of the best score, and the score.

    The line of the hunter whose view is shown says so.
    """
    pad = 8 * unit
    room = area.height - 2.0 * pad
    rows = min(len(lines), max(2, int(room // max(15.0, 19.0 * unit))))
    shown = rows if rows == len(lines) else rows - 1  # the last row says how many more
    height = min(room / rows, max(28.0, ROW * unit))
    left, top = area.left + pad, area.top + pad
    shapes: list[Shape] = [Box(area.left, area.top, area.width, rows * height + 2.0 * pad, CARD, 12 * unit)]
    best = max(line.agent_score.score for line in lines)
    for line in sorted(lines, key=lambda line: (line.climbs, -line.position)):  # climbing lines are drawn on top
        if line.position <= shown - 1:
            box = (left, top + line.position * height, area.width - 2.0 * pad, height)
            if line.climbs:
                shapes.append(Box(*box, mix(CARD, TRACK, 0.6), 0.25 * height))
            shapes += _line_shapes(box, info, line, best, unit, followed=line.agent_score.agent == view_of)
    if shown < len(lines):
        left_out, middle = f"and {len(lines) - shown} more", top + (shown + 0.5) * height
        shapes.append(Label(left + 0.3 * height, middle, left_out, font_size(0.5 * height, 10), DIM, 500))
    return shapes


def _line_shapes(
    area: tuple[float, float, float, float],
    info: MatchInfo,
    line: AnimatedLine,
    best: int,
    unit: float,
    *,
    followed: bool,
) -> list[Shape]:
    left, top, width, height = area
    entry = line.agent_score
    middle = top + height / 2.0
    size = min(font_size(0.54 * height, 10), font_size(21 * unit, 11), font_size(0.085 * width, 9))
    color = info.colors[entry.agent]
    x = left + 0.3 * size
    shapes: list[Shape] = [Turtle(x + 0.85 * size, middle, 0.0, 1.75 * size, color, faded=entry.faded)]
    x += 2.1 * size
    number_size = font_size(0.8 * size, 9)
    widest = max(len(info.number(agent)) for agent in range(len(info.names)))
    number_room = 0.62 * number_size * (widest + 0.3 * (info.config.prey > 0))  # a P is wider than a digit
    shapes.append(Label(x + number_room, middle, info.number(entry.agent), number_size, DIM, 600, "right"))
    x += number_room + 0.6 * size
    right = left + width - 0.5 * size
    bar_end = right - (0.78 * len(str(best)) + 0.6) * size
    has_bar = width >= 19 * size
    bar_start = max(x + 4.5 * size, bar_end - 0.3 * width) if has_bar else bar_end
    name = info.names[entry.agent] + ("  (out)" if entry.faded else "  (its view)" if followed else "")
    shapes.append(
        Label(x, middle, name, size, DIM if entry.faded else BRIGHT, 500, max_width=bar_start - x - 0.5 * size)
    )
    shapes.append(Label(right, middle, str(entry.score), font_size(1.1 * size, 11), BRIGHT, 800, "right"))
    if entry.hunted and has_bar:
        shapes.append(Label(bar_end, middle, "caught", font_size(0.8 * size, 9), DIM, 500, "right"))
    elif has_bar:
        thick = max(3.0, 0.48 * size)
        length = bar_end - bar_start
        shapes.append(Box(bar_start, middle - thick / 2, length, thick, TRACK, thick / 2))
        if line.share > 0.0:
            filled, shade = max(thick, length * line.share), mix(legible(color), CARD, 0.5 * entry.withdrawn)
            shapes.append(Box(bar_start, middle - thick / 2, filled, thick, shade, thick / 2))
    return shapes
