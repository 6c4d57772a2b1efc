"""Cards over the arena: the title at a match's beginning, and the podium at its end. Pure functions to shapes."""

from collections.abc import Sequence
from typing import Final

from catch_arena.config import ArbitrationPolicy
from catch_arena.explanation.highlights import lead
from catch_arena.render import hud
from catch_arena.render.match_info import Contender, MatchInfo
from catch_arena.render.shapes import WHITE, Box, Color, Label, Shape, Turtle, mix
from catch_arena.render.text import text_width
from catch_arena.text import counted

TITLE_MS: Final = 2000
"""Time for which the title is shown [ms of the video]."""
PODIUM_MS: Final = 4000
"""Time for which the podium is shown [ms of the video]."""
FADE_MS: Final = 300
"""Time in which a card appears or disappears [ms of the video]."""
DIMMED: Final = 0.1
"""Brightness of the arena under a card."""
GOLD: Final[Color] = (255, 206, 84)
"""Colour of headings."""
_MOST_ROWS: Final = 8
_GETS_IT: Final[dict[ArbitrationPolicy, str]] = {
    "nearest": "the nearest gets it",
    "first_come": "the first in the queue gets it",
    "capstone": "both get it",
}
"""Rule for contests, by policy."""
HEIGHTS: Final = (1.0, 0.72, 0.5)
"""Heights of the podium's steps, the first place's first, relative to that."""
PLACES: Final = ((0.0,), (-0.5, 0.5), (0.0, -1.0, 1.0))
"""Places of one, two or three contenders, the best first, in steps to the right of the middle."""


def title_shapes(area: tuple[int, int], info: MatchInfo) -> list[Shape]:
    """Return the title over an arena of (width, height): the tournament or scenario, and who plays."""
    width, height = area
    unit = min(width, height) / 720.0
    middle, room = width / 2.0, 0.88 * width
    big, size, small = (hud.font_size(pixels * unit, 11) for pixels in (54, 30, 24))
    rows = [(info.label(agent), info.colors[agent]) for agent in range(info.config.hunters)]
    if info.has_teams:
        rows = [(_members(info, contender), contender.color) for contender in info.contenders]
    prey = range(info.config.hunters, len(info.names))
    rows += [(f"{info.label(agent)}, prey", info.colors[agent]) for agent in prey]
    left_out = len(rows) - _MOST_ROWS if len(rows) > _MOST_ROWS + 1 else 0
    rows = rows[: len(rows) - left_out]
    line, left_out_room = 1.6 * size, 1.6 * size * bool(left_out)
    top = height / 2.0 - 0.5 * (len(rows) * line + left_out_room + 2.6 * big + 2.8 * small)
    shapes: list[Shape] = [
        Label(middle, top, info.event or "CATCH ARENA", big, GOLD, 800, "center", max_width=room),
        Label(middle, top + 0.95 * big, info.title, small, WHITE, 600, "center", max_width=room),
    ]
    for row, text in enumerate(goal(info)):
        below = top + 0.95 * big + (1.5 + 1.3 * row) * small
        shapes.append(Label(middle, below, text, small, hud.DIM, 600, "center", max_width=room))
    y = top + 2.3 * big + 2.8 * small
    widest = min(room - 1.4 * size, max(text_width(text, size, 700) for text, _ in rows))
    start = middle - 0.5 * (widest + 1.4 * size) + 0.6 * size
    for text, color in rows:
        shapes += [
            Turtle(start, y, 0.0, 1.7 * size, color),
            Label(start + 1.4 * size, y, text, size, WHITE, 700, max_width=widest),
        ]
        y += line
    if left_out:
        shapes.append(Label(start + 1.4 * size, y, f"and {left_out} more", small, hud.DIM, 600))
    return shapes


def goal(info: MatchInfo) -> list[str]:
    """Return the goal of a match, and the rule for contests, in two lines."""
    what = "prey" if info.config.prey and not info.config.spawning else "white turtles"
    seconds = f"{info.duration_ms / 1000:g} s"
    if len(info.contenders) == 1:
        return [f"Catch as many {what} as possible in {seconds}."]
    return [f"Most {what} caught in {seconds} wins.", f"Of two at the same time, {_GETS_IT[info.config.policy]}."]


def _members(info: MatchInfo, team: Contender) -> str:
    names = list(dict.fromkeys(info.names[seat] for seat in team.seats))
    return f"{team.name}: {', '.join(names)}" if names != [team.name] else team.name


def podium_shapes(
    area: tuple[int, int], info: MatchInfo, scores: Sequence[int], prey: Sequence[hud.AgentScore]
) -> list[Shape]:
    """Return the podium over an arena of (width, height): the first three contenders, their scores, and the margin.

    The scores are by contender.
    """
    width, height = area
    unit = min(width, height) / 720.0
    middle, room = width / 2.0, 0.94 * width
    big, size, small = (hud.font_size(pixels * unit, least) for pixels, least in ((46, 14), (27, 10), (20, 10)))
    top = 0.5 * height - 265 * unit
    shapes: list[Shape] = [Label(middle, top, result(info, scores), big, GOLD, 800, "center", max_width=room)]
    order = sorted(range(len(scores)), key=lambda contender: -scores[contender])[: len(HEIGHTS)]
    foot, wide = 0.5 * height + 215 * unit, 190 * unit
    for place, contender in enumerate(order):
        rank = 1 + sum(score > scores[contender] for score in scores)
        tall = HEIGHTS[rank - 1] * 200 * unit
        x, top = middle + PLACES[len(order) - 1][place] * 210 * unit, foot - tall
        name, color = info.contenders[contender].name, info.contenders[contender].color
        shapes += [
            Box(x - wide / 2.0, top, wide, tall, mix(color, hud.PANEL, 0.35), 10 * unit),
            Label(x, top + 34 * unit, str(rank), big, WHITE, 800, "center"),
            Turtle(x, top - 52 * unit, 1.57, 92 * unit, color),
            Label(x, top - 122 * unit, str(scores[contender]), big, WHITE, 800, "center"),
            Label(x, foot + 26 * unit, name, size, WHITE, 700, "center", max_width=1.06 * wide),
        ]
    if prey:
        texts = [f"{info.label(score.agent)}: caught {times(score.score)}" for score in prey[:2]]
        more = f", and {len(prey) - 2} more" if len(prey) > 2 else ""
        line = ", ".join(texts) + more
        shapes.append(Label(middle, foot + 70 * unit, line, small, WHITE, 600, "center", max_width=room))
    return shapes


def times(count: int) -> str:
    """Return a number of times in words."""
    return "once" if count == 1 else f"{count} times"


def result(info: MatchInfo, scores: Sequence[int]) -> str:
    """Return a match's result in words: the winner and its margin, or those that share the first place."""
    if len(scores) == 1:
        return f"{info.contenders[0].name}: {counted(scores[0], 'catch', 'catches')}"
    winner, margin = lead(scores)
    if winner is not None:
        name = info.contenders[winner].name
        return f"{name} {'win' if name == 'you' else 'wins'} by {margin}"
    first = [info.contenders[index].name for index, score in enumerate(scores) if score == max(scores)]
    return f"{' and '.join(first)} share the first place" if len(first) == 2 else f"{len(first)} share the first place"
