"""Card of the teams' scores, large: a column for each team, and below them each one's share of all catches.

Pure functions from small states to shapes.
"""

from collections.abc import Sequence
from typing import Final, Literal

from catch_arena.explanation.highlights import lead
from catch_arena.render.hud import BRIGHT, CARD, DIM, TRACK, Rect, font_size, legible
from catch_arena.render.match_info import Contender, MatchInfo
from catch_arena.render.shapes import Box, Label, Shape
from catch_arena.render.text import text_width, truncated

_MOST_IN_A_ROW: Final = 4
_LEAST_BAR: Final = 4.0
"""Least height of the bar of shares [pixels]."""


def team_scores_shapes(area: Rect, info: MatchInfo, scores: Sequence[int], unit: float) -> list[Shape]:
    """Return the card of a match of teams; with two teams it shows the leader and its lead."""
    pad = 0.12 * min(area.height, 132 * unit) + 2
    left, width = area.left + pad, area.width - 2 * pad
    shapes: list[Shape] = [Box(*area, CARD, 12 * unit)]
    thick = max(_LEAST_BAR, 0.07 * area.height)
    bar = area.top + area.height - pad - thick
    shapes += _share_shapes((left, bar, width, thick), info.contenders, scores)
    rows = 1 if len(info.contenders) <= _MOST_IN_A_ROW else 2
    columns = -(-len(info.contenders) // rows)
    high = (bar - 0.5 * pad - area.top - 0.6 * pad) / rows
    for place, (contender, score) in enumerate(zip(info.contenders, scores, strict=True)):
        row, column = divmod(place, columns)
        box = left + column * width / columns, area.top + 0.6 * pad + row * high, width / columns, high
        shapes += _team(box, contender, score, last=len(info.contenders) == 2 and column == 1)
    if len(info.contenders) == 2:
        room = width - 2.0 * text_width(str(max(scores)), _score_size(high), 800)
        shapes += _between(area, info.contenders, scores, room - pad)
    return shapes


def _score_size(height: float) -> int:
    return font_size(0.62 * height, 14)


def _team(area: tuple[float, float, float, float], contender: Contender, score: int, *, last: bool) -> list[Shape]:
    """Return a team's name over its score; `last` aligns it to the right."""
    left, top, width, height = area
    small, big = font_size(0.2 * height, 9), _score_size(height)
    x = left + width if last else left
    align: Literal["left", "right"] = "right" if last else "left"
    name = contender.name.upper()
    if 0.48 * height < 0.4 * (small + big):  # no room for both
        big = min(big, font_size(height, 9), max(7, int(1.3 * width / len(str(score)))))
        return [Label(x, top + 0.5 * height, str(score), big, legible(contender.color), 800, align)]
    return [
        Label(x, top + 0.2 * height, name, small, legible(contender.color), 700, align, max_width=0.94 * width),
        Label(x, top + 0.68 * height, str(score), big, BRIGHT, 800, align, max_width=0.94 * width),
    ]


def _between(area: Rect, contenders: Sequence[Contender], scores: Sequence[int], room: float) -> list[Shape]:
    """Return the word «catches» and the leader's name and lead, if they fit in `room`."""
    middle = area.left + area.width / 2.0
    small, size = font_size(0.12 * area.height, 9), font_size(0.155 * area.height, 10)
    if text_width("catches", small, 500) > room or 0.18 * area.height < 0.4 * (small + size):
        return []
    shapes: list[Shape] = [Label(middle, area.top + 0.4 * area.height, "catches", small, DIM, 500, "center")]
    leader, margin = lead(scores)
    if leader is not None:
        lead_text = f" +{margin}"
        name_room = room - text_width(lead_text, size, 700)
        text = (
            truncated(contenders[leader].name, size, 700, name_room) + lead_text
            if name_room > 2 * size
            else lead_text.strip()
        )
        color = legible(contenders[leader].color)
        shapes.append(Label(middle, area.top + 0.58 * area.height, text, size, color, 700, "center"))
    return shapes


def _share_shapes(
    area: tuple[float, float, float, float], contenders: Sequence[Contender], scores: Sequence[int]
) -> list[Shape]:
    left, top, width, height = area
    if not sum(scores):
        return [Box(left, top, width, height, TRACK, height / 2)]
    shapes: list[Shape] = []
    gap = 0.3 * height
    for contender, score in zip(contenders, scores, strict=True):
        long = width * score / sum(scores)
        if long > gap:
            shapes.append(Box(left, top, long - gap, height, legible(contender.color), min(height, long - gap) / 2))
        left += long
    return shapes
