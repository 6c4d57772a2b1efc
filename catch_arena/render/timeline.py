"""The timeline: who caught when, and who was how far ahead, over the whole match.

Pure functions from small states to shapes.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final, NamedTuple

from catch_arena.render.hud import CARD, DIM, TRACK, Rect, font_size, legible
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import WHITE, Box, Color, Label, Path, Shape, Stroke, mix
from catch_arena.render.text import text_width, truncated

COLUMNS: Final = 220
"""However long the match, the timeline is kept and drawn in so many parts."""

_BRIGHT_LINES: Final = 8
"""So many lines of the best stand out; the others are drawn behind them, faintly."""


@dataclass(slots=True)
class Timeline:
    """Who caught when, and every contender's score: two values for each of COLUMNS parts of the match.

    A contender is a team, or where there are none a hunter.
    """

    duration_ms: int
    catches: int = 0
    catchers: list[frozenset[int]] = field(default_factory=lambda: [frozenset()] * COLUMNS)
    """The contenders that caught in each part."""
    scores: list[tuple[int, ...]] = field(default_factory=list)
    """By contender, at the end of each part that has begun."""
    last_change: int = 0
    """The part in which somebody caught last."""

    def column(self, time_ms: float) -> int:
        """The part of the match that an instant falls into."""
        return min(COLUMNS - 1, max(0, int(time_ms * COLUMNS / max(1, self.duration_ms))))

    def record(self, time_ms: float, catchers: Sequence[int], scores: Sequence[int]) -> None:
        """Advance to an instant at which there were catches of these contenders, and these are the scores."""
        column = self.column(time_ms)
        while len(self.scores) <= column:  # nothing happened in between
            self.scores.append(self.scores[-1] if self.scores else (0,) * len(scores))
        if self.scores[column] != tuple(scores):
            self.scores[column], self.last_change = tuple(scores), column
        self.catchers[column] |= frozenset(catchers)
        self.catches += len(catchers)


def lead(scores: Sequence[int]) -> tuple[int, int]:
    """Who leads, and how far behind the next is; (-1, 0) where they are level. One alone leads by its score."""
    best = max(scores, default=0)
    if list(scores).count(best) != 1 or best == 0:
        return -1, 0
    return list(scores).index(best), best - max((score for score in scores if score != best), default=0)


def over_average(scores: Sequence[int]) -> list[float]:
    """How far each is ahead of the average; one alone, of nothing."""
    average = sum(scores) / len(scores) if len(scores) > 1 else 0.0
    return [score - average for score in scores]


class _Chart(NamedTuple):
    """Where everything stands in the card."""

    text: int
    small: int
    head: float
    """The middle of the title."""
    left: float
    width: float
    lane_top: float
    lanes: int
    pitch: float
    lane: float
    top: float
    base: float
    foot: float
    """The middle of the axis' labels."""

    def x(self, time_ms: float, timeline: Timeline) -> float:
        """Where an instant is."""
        return self.left + self.width * min(1.0, time_ms / max(1, timeline.duration_ms))


def _chart(area: Rect, contenders: int, unit: float) -> _Chart:
    text, small = font_size(14 * unit, 10), font_size(12 * unit, 9)
    pad = 16 * unit
    axis = 2.6 * small
    head = area.top + max(0.95 * text, min(0.11 * area.height, 22 * unit))
    foot = area.top + area.height - max(0.85 * small, min(0.08 * area.height, 18 * unit))
    lane_top = head + 0.95 * text
    base = foot - 1.15 * small
    lanes = contenders if (base - lane_top) / 2.0 >= 1.25 * small * contenders else 1
    pitch = min(18.0 * unit, 0.5 * (base - lane_top) / lanes)
    lane = max(4.0, min(11.0 * unit, 0.7 * pitch))
    top = lane_top + (lanes - 1) * pitch + lane + max(4.0, 0.05 * area.height)
    left = area.left + pad + axis
    width = area.width - 2 * pad - axis
    return _Chart(text, small, head, left, width, lane_top, lanes, pitch, lane, top, base, foot)


def cursor_x(area: Rect, timeline: Timeline, time_ms: float, unit: float) -> float:
    """Where the present is on the timeline [pixels]."""
    return _chart(area, 1, unit).x(time_ms, timeline)


class _Scale(NamedTuple):
    """The chart's heights, from the scores so far."""

    zero: float
    pixels: float
    """A catch ahead of the average."""

    def y(self, value: float) -> float:
        """Where a line stands that is so far ahead [pixels]."""
        return self.zero - value * self.pixels


def _scale(chart: _Chart, timeline: Timeline, alone: bool) -> _Scale:
    values = [value for scores in set(timeline.scores) for value in over_average(scores)] or [0.0]
    most, least = max(2.0, *values), 0.0 if alone else min(-2.0, *values)
    pixels = (chart.base - chart.top) / (most - least)
    return _Scale(chart.base + least * pixels, pixels)


def timeline_shapes(area: Rect, info: MatchInfo, timeline: Timeline, unit: float) -> list[Shape]:
    """What has been: catches as ticks in their colours; below, how far each contender was ahead of the average.

    The topmost line is the leader's, and the area under it, down to the second, is the lead.
    """
    chart = _chart(area, len(info.contenders), unit)
    shapes: list[Shape] = [Box(*area, CARD, 12 * unit), *_title(area, chart, info, timeline, unit)]
    step = chart.width / COLUMNS
    for row in range(chart.lanes):
        row_top = chart.lane_top + row * chart.pitch
        shapes.append(Box(chart.left, row_top, chart.width, chart.lane, TRACK, chart.lane / 2))
        if chart.lanes > 1:
            position = (chart.left - 0.5 * chart.small, row_top + chart.lane / 2)
            color = legible(info.contenders[row].color)
            shapes.append(Label(*position, _lane_name(info, row), chart.small, color, 700, "right"))
    tick = max(step, min(3.0 * unit, 3.0), 1.5)
    for part, catchers in enumerate(timeline.catchers):
        for contender in sorted(catchers):
            row_top = chart.lane_top + (contender * chart.pitch if chart.lanes > 1 else 0.0)
            x = chart.left + (part + 0.5) * step - tick / 2
            shapes.append(Box(x, row_top, tick, chart.lane, legible(info.contenders[contender].color)))
    if chart.base - chart.top >= 8:
        shapes += _score_lines(chart, info, timeline, unit)
    for at_s in tick_seconds(timeline.duration_ms / 1000.0, chart.width / (5.2 * chart.small)):
        x = min(chart.x(1000.0 * at_s, timeline), chart.left + chart.width - 1.2 * chart.small)
        shapes.append(Label(x, chart.foot, axis_time(at_s), chart.small, DIM, 500, "center"))
    return shapes


def _lane_name(info: MatchInfo, contender: int) -> str:
    """A hunter's number; a team's colour tells it."""
    return "" if info.has_teams else str(contender)


def _title(area: Rect, chart: _Chart, info: MatchInfo, timeline: Timeline, unit: float) -> list[Shape]:
    left, right = area.left + 16 * unit, chart.left + chart.width
    many = "1 catch" if timeline.catches == 1 else f"{timeline.catches} catches"
    leader, by = lead(timeline.scores[-1]) if timeline.scores else (-1, 0)
    alone = len(info.contenders) == 1
    title = "Catches" if alone else "Catches and lead"
    room = right - left - text_width(many, chart.text, 500) - chart.text
    shapes: list[Shape] = [
        Label(left, chart.head, title, chart.text, DIM, 500, max_width=room),
        Label(right, chart.head, many, chart.text, DIM, 500, "right"),
    ]
    if leader >= 0 and not alone:
        left += text_width(title, chart.text, 500) + chart.text
        room -= text_width(title, chart.text, 500) + chart.text
        said = f"  +{by}"
        name_room = room - text_width(said, chart.text, 700)
        if name_room > 3 * chart.text:
            name = info.contenders[leader].name
            width = text_width(truncated(name, chart.text, 700, name_room), chart.text, 700)
            color = legible(info.contenders[leader].color)
            shapes += [
                Label(left, chart.head, name, chart.text, color, 700, max_width=name_room),
                Label(left + width, chart.head, said, chart.text, color, 700),
            ]
    return shapes


def _score_lines(chart: _Chart, info: MatchInfo, timeline: Timeline, unit: float) -> list[Shape]:
    scale = _scale(chart, timeline, len(info.contenders) == 1)
    shapes: list[Shape] = [_zero_line(chart, scale)]
    if not timeline.scores:
        return shapes
    step = chart.width / COLUMNS
    changes = [0, *(k for k in range(1, len(timeline.scores)) if timeline.scores[k] != timeline.scores[k - 1])]
    heights = [[scale.y(value) for value in over_average(timeline.scores[column])] for column in changes]
    for start, end in pairwise(changes):
        shapes += _lead_area(info, timeline.scores[start], scale, chart.left + start * step, chart.left + end * step)
    for contender, color, thick in _line_styles(info, timeline.scores[-1], unit):
        points = [(chart.left, heights[0][contender])]
        for start, column in zip(changes[1:], heights[1:], strict=True):
            x = chart.left + start * step
            points += [(x, points[-1][1]), (x, column[contender])]
        shapes.append(Path(tuple(points), thick, color))
    return shapes


def _lead_area(info: MatchInfo, scores: Sequence[int], scale: _Scale, left: float, right: float) -> list[Shape]:
    leader, by = lead(scores)
    left, right = round(left), round(right)  # whole pixels: no seams between one area and the next
    if leader < 0 or right <= left:
        return []
    top = scale.y(over_average(scores)[leader])
    return [Box(left, top, right - left, by * scale.pixels, mix(legible(info.contenders[leader].color), CARD, 0.7))]


def _zero_line(chart: _Chart, scale: _Scale) -> Stroke:
    return Stroke(chart.left, scale.zero, chart.left + chart.width, scale.zero, 1.0, mix(CARD, DIM, 0.4))


def _line_styles(info: MatchInfo, scores: Sequence[int], unit: float) -> list[tuple[int, Color, float]]:
    """The lines from the lowest to the topmost: contender, colour, width."""
    order = sorted(range(len(scores)), key=lambda contender: (scores[contender], -contender))
    faint = order[: max(0, len(order) - _BRIGHT_LINES)]
    return [
        (contender, mix(legible(info.contenders[contender].color), CARD, 0.65), max(1.0, 1.2 * unit))
        if contender in faint
        else (contender, legible(info.contenders[contender].color), max(1.0, 2.2 * unit))
        for contender in order
    ]


def present_shapes(area: Rect, info: MatchInfo, timeline: Timeline, time_ms: float, unit: float) -> list[Shape]:
    """What is now: the lines reach to the present, which is a line across, and end in dots."""
    chart = _chart(area, len(info.contenders), unit)
    x = chart.x(time_ms, timeline)
    shapes: list[Shape] = []
    if chart.base - chart.top >= 8 and timeline.scores:
        scale = _scale(chart, timeline, len(info.contenders) == 1)
        start = chart.left + timeline.last_change * chart.width / COLUMNS
        values = over_average(timeline.scores[-1])
        shapes += _lead_area(info, timeline.scores[-1], scale, start, x)
        lines = _line_styles(info, timeline.scores[-1], unit)
        for contender, color, thick in lines:
            y = scale.y(values[contender])
            shapes.append(Stroke(min(start, x), y, x, y, thick, color))
        shapes.append(Stroke(x, chart.lane_top - 2.0, x, chart.base, max(1.0, 1.6 * unit), WHITE))
        dot = max(3.0, 7.0 * unit)
        for contender, color, _ in lines[-_BRIGHT_LINES:]:
            shapes.append(Box(x - dot / 2, scale.y(values[contender]) - dot / 2, dot, dot, color, dot / 2))
        return shapes
    return [Stroke(x, chart.lane_top - 2.0, x, chart.base, max(1.0, 1.6 * unit), WHITE)]


def tick_seconds(duration_s: float, most: float) -> list[float]:
    """Round times from 0 to the end, at most so many."""
    for step in (step * 10.0**power for power in range(-1, 8) for step in (1.0, 2.0, 3.0, 6.0)):
        if duration_s / step + 1 <= max(2.0, most):
            return [step * count for count in range(math.floor(duration_s / step + 1e-9) + 1)]
    return [0.0]


def axis_time(at_s: float) -> str:
    """A round time, as the timeline's axis says it."""
    return f"{at_s:g} s" if at_s < 600 else f"{at_s / 60:.0f} min"
