"""Timeline of the whole match: the catches of each contender, and each one's lead over the average.

Pure functions from small states to shapes.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from catch_arena.explanation.highlights import lead
from catch_arena.render.hud import CARD, DIM, TRACK, Rect, font_size, legible
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import WHITE, Box, Label, Path, Shape, mix
from catch_arena.render.text import text_width
from catch_arena.text import counted

COLUMNS: Final = 220
"""Number of parts in which the timeline is kept and drawn, whatever the match's length."""

_MOST_LINES: Final = 8
"""Greatest number of contenders, the best ones, that have a line."""


class Timeline:
    """Catchers and scores of a match, as two values for each of COLUMNS parts of it, and the shapes of their card.

    A contender is a team, or a hunter if there are no teams.
    """

    def __init__(self, area: Rect, info: MatchInfo, unit: float) -> None:
        self.catches = 0
        """Number of catches so far; `past_shapes` changes only with it."""
        self._catchers: list[frozenset[int]] = [frozenset()] * COLUMNS
        """Contenders that caught, for each part."""
        self._scores: list[tuple[int, ...]] = [(0,) * len(info.contenders)]
        """Scores by contender, at the end of each part that has begun."""
        self._last_change = 0
        """Part in which the scores changed last."""
        self._area, self._info, self._unit = area, info, unit
        self._text, self._small = font_size(14 * unit, 10), font_size(12 * unit, 9)
        self._colors = [legible(contender.color) for contender in info.contenders]
        self._thick = max(1.0, 2.2 * unit)
        """Width of a contender's line [pixels]."""
        self._alone = len(info.contenders) == 1
        axis = 2.6 * self._small
        self._left, self._width = area.left + 16 * unit + axis, area.width - 32 * unit - axis
        self._step = self._width / COLUMNS
        self._head = area.top + max(0.95 * self._text, min(0.11 * area.height, 22 * unit))
        """Vertical place of the middle of the title [pixels]."""
        self._foot = area.top + area.height - max(0.85 * self._small, min(0.08 * area.height, 18 * unit))
        """Vertical place of the middle of the axis' labels [pixels]."""
        self._lane_top = self._head + 0.95 * self._text
        self._base = self._foot - 1.15 * self._small
        room = self._base - self._lane_top
        self._lanes = len(info.contenders) if room / 2.0 >= 1.25 * self._small * len(info.contenders) else 1
        self._pitch = min(18.0 * unit, 0.5 * room / self._lanes)
        self._lane = max(4.0, min(11.0 * unit, 0.7 * self._pitch))
        self._top = self._lane_top + (self._lanes - 1) * self._pitch + self._lane + max(4.0, 0.05 * area.height)
        self._has_lines = self._base - self._top >= 8
        self._scale()

    def record(self, time_ms: float, catchers: Sequence[int], scores: Sequence[int]) -> None:
        """Advance to an instant, with the contenders of its catches, and with the scores after it."""
        column = min(COLUMNS - 1, max(0, int(time_ms * COLUMNS / max(1, self._info.duration_ms))))
        while len(self._scores) <= column:  # parts without events keep the scores
            self._scores.append(self._scores[-1])
        if self._scores[column] != tuple(scores):
            self._scores[column], self._last_change = tuple(scores), column
            self._scale()
        self._catchers[column] |= frozenset(catchers)
        self.catches += len(catchers)

    def _scale(self) -> None:
        """Compute the scale of the leads from all scores so far."""
        values = [value for scores in set(self._scores) for value in over_average(scores)]
        highest, lowest = max(2.0, *values), 0.0 if self._alone else min(-2.0, *values)
        self._pixels = (self._base - self._top) / (highest - lowest)
        """Height of a lead of one catch over the average [pixels]."""
        self._zero = self._base + lowest * self._pixels

    def x(self, time_ms: float) -> float:
        """Return the horizontal place of an instant [pixels]."""
        return self._left + self._width * min(1.0, time_ms / max(1, self._info.duration_ms))

    def past_shapes(self) -> list[Shape]:
        """Return the past: catches as ticks in their colours; below, each contender's lead over the average.

        The topmost line is the leader's, and the area under it, down to the second, is the lead.
        """
        shapes: list[Shape] = [Box(*self._area, CARD, 12 * self._unit), *self._title_shapes(), *self._lane_shapes()]
        if self._has_lines:
            shapes += self._history_shapes()
        for at_s in tick_seconds(self._info.duration_ms / 1000.0, self._width / (5.2 * self._small)):
            x = min(self.x(1000.0 * at_s), self._left + self._width - 1.2 * self._small)
            text = f"{at_s:g} s" if at_s < 600 else f"{at_s / 60:.0f} min"
            shapes.append(Label(x, self._foot, text, self._small, DIM, 500, "center"))
        return shapes

    def present_shapes(self, time_ms: float) -> list[Shape]:
        """Return the present as a line across; the contenders' lines lead to it and end in dots."""
        x = self.x(time_ms)
        present = Path(((x, self._lane_top - 2.0), (x, self._base)), max(1.0, 1.6 * self._unit), WHITE)
        if not self._has_lines:
            return [present]
        start = self._left + self._last_change * self._step
        heights = [self._y(value) for value in over_average(self._scores[-1])]
        best, dot = self._best(), max(3.0, 7.0 * self._unit)
        shapes = self._lead_area(self._scores[-1], start, x)
        for contender in best:
            points = (min(start, x), heights[contender]), (x, heights[contender])
            shapes.append(Path(points, self._thick, self._colors[contender]))
        shapes.append(present)
        for contender in best:
            y = heights[contender] - dot / 2
            shapes.append(Box(x - dot / 2, y, dot, dot, self._colors[contender], dot / 2))
        return shapes

    def _y(self, value: float) -> float:
        """Return the vertical place of a lead over the average [pixels]."""
        return self._zero - value * self._pixels

    def _lane_shapes(self) -> list[Shape]:
        """Return the catches over time: a lane for each contender, or one lane for all."""
        shapes: list[Shape] = []
        for row in range(self._lanes):
            top = self._lane_top + row * self._pitch
            shapes.append(Box(self._left, top, self._width, self._lane, TRACK, self._lane / 2))
            if self._lanes > 1:
                name = "" if self._info.has_teams else str(row)  # a team's colour is enough
                position = (self._left - 0.5 * self._small, top + self._lane / 2)
                shapes.append(Label(*position, name, self._small, self._colors[row], 700, "right"))
        tick = max(self._step, min(3.0 * self._unit, 3.0), 1.5)
        for part, catchers in enumerate(self._catchers):
            for contender in sorted(catchers):
                top = self._lane_top + (contender * self._pitch if self._lanes > 1 else 0.0)
                x = self._left + (part + 0.5) * self._step - tick / 2
                shapes.append(Box(x, top, tick, self._lane, self._colors[contender]))
        return shapes

    def _title_shapes(self) -> list[Shape]:
        """Return the title, the leader with its lead, and the number of catches."""
        left, right = self._area.left + 16 * self._unit, self._left + self._width
        catches = counted(self.catches, "catch", "catches")
        leader, margin = lead(self._scores[-1])
        title = "Catches" if self._alone else "Catches and lead"
        room = right - left - text_width(catches, self._text, 500) - self._text
        shapes: list[Shape] = [
            Label(left, self._head, title, self._text, DIM, 500, max_width=room),
            Label(right, self._head, catches, self._text, DIM, 500, "right"),
        ]
        used = text_width(title, self._text, 500) + self._text
        if leader is not None and not self._alone and room - used > 5 * self._text:
            text, left = f"+{margin}  {self._info.contenders[leader].name}", left + used
            shapes.append(Label(left, self._head, text, self._text, self._colors[leader], 700, max_width=room - used))
        return shapes

    def _history_shapes(self) -> list[Shape]:
        """Return each contender's lead over the average, up to the last catch."""
        color = mix(CARD, DIM, 0.4)
        shapes: list[Shape] = [Path(((self._left, self._zero), (self._left + self._width, self._zero)), 1.0, color)]
        scores = self._scores
        changes = [0, *(k for k in range(1, len(scores)) if scores[k] != scores[k - 1])]
        heights = [[self._y(value) for value in over_average(scores[column])] for column in changes]
        for start, end in pairwise(changes):
            shapes += self._lead_area(scores[start], self._left + start * self._step, self._left + end * self._step)
        for contender in self._best():
            points = [(self._left, heights[0][contender])]
            for start, column in zip(changes[1:], heights[1:], strict=True):
                x = self._left + start * self._step
                points += [(x, points[-1][1]), (x, column[contender])]
            shapes.append(Path(tuple(points), self._thick, self._colors[contender]))
        return shapes

    def _lead_area(self, scores: Sequence[int], left: float, right: float) -> list[Shape]:
        """Return the area under the leader's line, down to the second's; no shapes for a tie."""
        leader, margin = lead(scores)
        left, right = round(left), round(right)  # whole pixels: no seams between one area and the next
        if leader is None or right <= left:
            return []
        top = self._y(over_average(scores)[leader])
        return [Box(left, top, right - left, margin * self._pixels, mix(self._colors[leader], CARD, 0.7))]

    def _best(self) -> list[int]:
        """Return the contenders that have a line, the best last, whose line is on top."""
        scores = self._scores[-1]
        return sorted(range(len(scores)), key=lambda contender: (scores[contender], -contender))[-_MOST_LINES:]


def over_average(scores: Sequence[int]) -> list[float]:
    """Return each score's lead over the average; a single score is returned as it is."""
    average = sum(scores) / len(scores) if len(scores) > 1 else 0.0
    return [score - average for score in scores]


def tick_seconds(duration_s: float, max_ticks: float) -> list[float]:
    """Return round times from 0 to the end [s], at most `max_ticks` of them, or 2 if that is smaller."""
    for step in (step * 10.0**power for power in range(-1, 8) for step in (1.0, 2.0, 3.0, 6.0)):
        if duration_s / step + 1 <= max(2.0, max_ticks):
            return [step * count for count in range(math.floor(duration_s / step + 1e-9) + 1)]
    return [0.0]
