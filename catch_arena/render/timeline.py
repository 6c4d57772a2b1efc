"""Timeline of the whole match: the catches of each contender, and each one's lead over the average.

Pure functions from small states to shapes.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

from catch_arena.render.hud import CARD, DIM, TRACK, Rect, font_size, legible
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import WHITE, Box, Color, Label, Path, Shape, Stroke, mix
from catch_arena.render.text import text_width, truncated

COLUMNS: Final = 220
"""Number of parts in which the timeline is kept and drawn, whatever the match's length."""

_BRIGHT_LINES: Final = 8
"""Number of contenders, the best ones, whose lines stand out; the others are drawn below them, faintly."""


@dataclass(slots=True)
class Timeline:
    """Catchers and scores of a match, as two values for each of COLUMNS parts of it.

    A contender is a team, or a hunter if there are no teams.
    """

    duration_ms: int
    catches: int = 0
    catchers: list[frozenset[int]] = field(default_factory=lambda: [frozenset()] * COLUMNS)
    """Contenders that caught, for each part."""
    scores: list[tuple[int, ...]] = field(default_factory=list)
    """Scores by contender, at the end of each part that has begun."""
    last_change: int = 0
    """Part in which the scores changed last."""

    def column(self, time_ms: float) -> int:
        """Return the part of the match that an instant falls into."""
        return min(COLUMNS - 1, max(0, int(time_ms * COLUMNS / max(1, self.duration_ms))))

    def record(self, time_ms: float, catchers: Sequence[int], scores: Sequence[int]) -> None:
        """Advance to an instant, with the contenders of its catches, and with the scores after it."""
        column = self.column(time_ms)
        while len(self.scores) <= column:  # parts without events keep the scores
            self.scores.append(self.scores[-1] if self.scores else (0,) * len(scores))
        if self.scores[column] != tuple(scores):
            self.scores[column], self.last_change = tuple(scores), column
        self.catchers[column] |= frozenset(catchers)
        self.catches += len(catchers)


def lead(scores: Sequence[int]) -> tuple[int | None, int]:
    """Return the leader and its lead over the next, or (None, 0) for a tie. A single contender leads by its score."""
    best = max(scores, default=0)
    if list(scores).count(best) != 1 or best == 0:
        return None, 0
    return list(scores).index(best), best - max((score for score in scores if score != best), default=0)


def over_average(scores: Sequence[int]) -> list[float]:
    """Return each score's lead over the average; a single score is returned as it is."""
    average = sum(scores) / len(scores) if len(scores) > 1 else 0.0
    return [score - average for score in scores]


class _Chart:
    """Layout of a timeline in its card, and its shapes."""

    def __init__(self, area: Rect, info: MatchInfo, timeline: Timeline, unit: float) -> None:
        self.area, self.info, self.timeline, self.unit = area, info, timeline, unit
        self.text, self.small = font_size(14 * unit, 10), font_size(12 * unit, 9)
        self.colors = [legible(contender.color) for contender in info.contenders]
        self.alone = len(info.contenders) == 1
        self.left, self.width = _span(area, unit)
        self.step = self.width / COLUMNS
        self.head = area.top + max(0.95 * self.text, min(0.11 * area.height, 22 * unit))
        """Vertical place of the middle of the title [pixels]."""
        self.foot = area.top + area.height - max(0.85 * self.small, min(0.08 * area.height, 18 * unit))
        """Vertical place of the middle of the axis' labels [pixels]."""
        self.lane_top = self.head + 0.95 * self.text
        self.base = self.foot - 1.15 * self.small
        room = self.base - self.lane_top
        self.lanes = len(info.contenders) if room / 2.0 >= 1.25 * self.small * len(info.contenders) else 1
        self.pitch = min(18.0 * unit, 0.5 * room / self.lanes)
        self.lane = max(4.0, min(11.0 * unit, 0.7 * self.pitch))
        self.top = self.lane_top + (self.lanes - 1) * self.pitch + self.lane + max(4.0, 0.05 * area.height)
        self.has_lines = self.base - self.top >= 8
        values = [value for scores in set(timeline.scores) for value in over_average(scores)] or [0.0]
        highest, lowest = max(2.0, *values), 0.0 if self.alone else min(-2.0, *values)
        self.pixels = (self.base - self.top) / (highest - lowest)
        """Height of a lead of one catch over the average [pixels]."""
        self.zero = self.base + lowest * self.pixels

    def x(self, time_ms: float) -> float:
        """Return the horizontal place of an instant [pixels]."""
        return self.left + self.width * min(1.0, time_ms / max(1, self.timeline.duration_ms))

    def y(self, value: float) -> float:
        """Return the vertical place of a lead over the average [pixels]."""
        return self.zero - value * self.pixels

    def lane_shapes(self) -> list[Shape]:
        """Return the catches over time: a lane for each contender, or one lane for all."""
        shapes: list[Shape] = []
        for row in range(self.lanes):
            top = self.lane_top + row * self.pitch
            shapes.append(Box(self.left, top, self.width, self.lane, TRACK, self.lane / 2))
            if self.lanes > 1:
                name = "" if self.info.has_teams else str(row)  # a team's colour is enough
                position = (self.left - 0.5 * self.small, top + self.lane / 2)
                shapes.append(Label(*position, name, self.small, self.colors[row], 700, "right"))
        tick = max(self.step, min(3.0 * self.unit, 3.0), 1.5)
        for part, catchers in enumerate(self.timeline.catchers):
            for contender in sorted(catchers):
                top = self.lane_top + (contender * self.pitch if self.lanes > 1 else 0.0)
                x = self.left + (part + 0.5) * self.step - tick / 2
                shapes.append(Box(x, top, tick, self.lane, self.colors[contender]))
        return shapes

    def title_shapes(self) -> list[Shape]:
        """Return the title, the leader with its lead, and the number of catches."""
        left, right = self.area.left + 16 * self.unit, self.left + self.width
        catches = "1 catch" if self.timeline.catches == 1 else f"{self.timeline.catches} catches"
        leader, margin = lead(self.timeline.scores[-1]) if self.timeline.scores else (None, 0)
        title = "Catches" if self.alone else "Catches and lead"
        room = right - left - text_width(catches, self.text, 500) - self.text
        shapes: list[Shape] = [
            Label(left, self.head, title, self.text, DIM, 500, max_width=room),
            Label(right, self.head, catches, self.text, DIM, 500, "right"),
        ]
        lead_text = f"  +{margin}"
        used = text_width(title, self.text, 500) + self.text
        name_room = room - used - text_width(lead_text, self.text, 700)
        if leader is not None and not self.alone and name_room > 3 * self.text:
            name, color = self.info.contenders[leader].name, self.colors[leader]
            width = text_width(truncated(name, self.text, 700, name_room), self.text, 700)
            shapes += [
                Label(left + used, self.head, name, self.text, color, 700, max_width=name_room),
                Label(left + used + width, self.head, lead_text, self.text, color, 700),
            ]
        return shapes

    def history_shapes(self) -> list[Shape]:
        """Return each contender's lead over the average, up to the last catch."""
        color = mix(CARD, DIM, 0.4)
        shapes: list[Shape] = [Stroke(self.left, self.zero, self.left + self.width, self.zero, 1.0, color)]
        scores = self.timeline.scores
        if not scores:
            return shapes
        changes = [0, *(k for k in range(1, len(scores)) if scores[k] != scores[k - 1])]
        heights = [[self.y(value) for value in over_average(scores[column])] for column in changes]
        for start, end in pairwise(changes):
            shapes += self.lead_area(scores[start], self.left + start * self.step, self.left + end * self.step)
        for contender, color, thick in self.line_styles():
            points = [(self.left, heights[0][contender])]
            for start, column in zip(changes[1:], heights[1:], strict=True):
                x = self.left + start * self.step
                points += [(x, points[-1][1]), (x, column[contender])]
            shapes.append(Path(tuple(points), thick, color))
        return shapes

    def lead_area(self, scores: Sequence[int], left: float, right: float) -> list[Shape]:
        """Return the area under the leader's line, down to the second's; no shapes for a tie."""
        leader, margin = lead(scores)
        left, right = round(left), round(right)  # whole pixels: no seams between one area and the next
        if leader is None or right <= left:
            return []
        top = self.y(over_average(scores)[leader])
        return [Box(left, top, right - left, margin * self.pixels, mix(self.colors[leader], CARD, 0.7))]

    def line_styles(self) -> list[tuple[int, Color, float]]:
        """Return contender, colour and width of each line, the lowest first."""
        scores = self.timeline.scores[-1]
        order = sorted(range(len(scores)), key=lambda contender: (scores[contender], -contender))
        faint, bright = order[:-_BRIGHT_LINES], order[-_BRIGHT_LINES:]
        return [
            (contender, mix(self.colors[contender], CARD, 0.65), max(1.0, 1.2 * self.unit)) for contender in faint
        ] + [(contender, self.colors[contender], max(1.0, 2.2 * self.unit)) for contender in bright]


def _span(area: Rect, unit: float) -> tuple[float, float]:
    """Return the left end of the match's time in the card, and its width [pixels]."""
    axis = 2.6 * font_size(12 * unit, 9)
    return area.left + 16 * unit + axis, area.width - 32 * unit - axis


def cursor_x(area: Rect, timeline: Timeline, time_ms: float, unit: float) -> float:
    """Return the horizontal place of the present on the timeline [pixels]."""
    left, width = _span(area, unit)
    return left + width * min(1.0, time_ms / max(1, timeline.duration_ms))


def timeline_shapes(area: Rect, info: MatchInfo, timeline: Timeline, unit: float) -> list[Shape]:
    """Return the past: catches as ticks in their colours; below, each contender's lead over the average.

    The topmost line is the leader's, and the area under it, down to the second, is the lead.
    """
    chart = _Chart(area, info, timeline, unit)
    shapes: list[Shape] = [Box(*area, CARD, 12 * unit), *chart.title_shapes(), *chart.lane_shapes()]
    if chart.has_lines:
        shapes += chart.history_shapes()
    for at_s in tick_seconds(timeline.duration_ms / 1000.0, chart.width / (5.2 * chart.small)):
        x = min(chart.x(1000.0 * at_s), chart.left + chart.width - 1.2 * chart.small)
        shapes.append(Label(x, chart.foot, axis_time(at_s), chart.small, DIM, 500, "center"))
    return shapes


def present_shapes(area: Rect, info: MatchInfo, timeline: Timeline, time_ms: float, unit: float) -> list[Shape]:
    """Return the present as a line across; the contenders' lines lead to it and end in dots."""
    chart = _Chart(area, info, timeline, unit)
    x = chart.x(time_ms)
    present = Stroke(x, chart.lane_top - 2.0, x, chart.base, max(1.0, 1.6 * unit), WHITE)
    if not (chart.has_lines and timeline.scores):
        return [present]
    start = chart.left + timeline.last_change * chart.step
    heights = [chart.y(value) for value in over_average(timeline.scores[-1])]
    lines, dot = chart.line_styles(), max(3.0, 7.0 * unit)
    shapes = chart.lead_area(timeline.scores[-1], start, x)
    shapes += [
        Stroke(min(start, x), heights[contender], x, heights[contender], thick, color)
        for contender, color, thick in lines
    ]
    shapes.append(present)
    for contender, color, _ in lines[-_BRIGHT_LINES:]:
        shapes.append(Box(x - dot / 2, heights[contender] - dot / 2, dot, dot, color, dot / 2))
    return shapes


def tick_seconds(duration_s: float, max_ticks: float) -> list[float]:
    """Return round times from 0 to the end [s], at most `max_ticks` of them, or 2 if that is smaller."""
    for step in (step * 10.0**power for power in range(-1, 8) for step in (1.0, 2.0, 3.0, 6.0)):
        if duration_s / step + 1 <= max(2.0, max_ticks):
            return [step * count for count in range(math.floor(duration_s / step + 1e-9) + 1)]
    return [0.0]


def axis_time(at_s: float) -> str:
    """Return a round time as text for the timeline's axis."""
    return f"{at_s:g} s" if at_s < 600 else f"{at_s / 60:.0f} min"
