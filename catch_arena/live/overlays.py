"""What is written over the arena: the keys, the result, and short notes. Pure functions to shapes."""

from collections.abc import Sequence
from typing import Final

from catch_arena.render import hud
from catch_arena.render.match_info import MatchInfo
from catch_arena.render.shapes import INK, WHITE, Box, Color, Label, Polygon, Shape
from catch_arena.render.text import text_width
from catch_arena.render.viewport import Viewport

_KEY: Final[Color] = (58, 67, 118)

DRIVING: Final = (
    (("↑", "W"), "ahead"),
    (("←", "A"), "turn left"),
    (("→", "D"), "turn right"),
    (("↓", "S"), "back, where hunters may"),
    (("gamepad",), "the stick drives too"),
)
WINDOW: Final = (
    (("space", "P"), "pause, and go on"),
    (("N", "."), "one step, while it is paused"),
    (("+", "-"), "faster, slower"),
    (("V",), "what a hunter sees; the next"),
    (("R",), "the same match again"),
    (("Ctrl-S",), "save the replay"),
    (("H",), "these keys"),
    (("Esc",), "end"),
)
_YOU: Final = "you"
_ARROWS: Final = {"↑": (0, -1), "↓": (0, 1), "←": (-1, 0), "→": (1, 0)}

Rows = Sequence[tuple[tuple[str, ...], str]]


def keys_overlay(area: tuple[int, int], title: str, rows: Rows, below: str) -> list[Shape]:
    """A table of keys in the middle of an area of (width, height)."""
    width, height = area
    unit = min(width / 560.0, height / 560.0)
    size, big = hud.font_size(17 * unit, 10), hud.font_size(26 * unit, 13)
    pad = 1.6 * size
    line = min(2.0 * size, (height - 4.0 - 2.0 * pad - 2.4 * big) / (len(rows) + 1.2))
    keys = max(sum(_key_width(key, size) + 0.4 * size for key in row[0]) for row in rows)
    words = max(text_width(row[1], size, 500) for row in rows)
    wide = min(width - 4.0, max(keys + words + 2.0 * size, text_width(title, big, 800)) + 2.0 * pad)
    high = len(rows) * line + 2.0 * pad + 2.4 * big + 1.2 * line
    left, top = (width - wide) / 2.0, max(2.0, (height - high) / 2.0)
    shapes: list[Shape] = [
        Box(left, top, wide, high, hud.PANEL, 14 * unit),
        Label(left + pad, top + pad + 0.5 * big, title, big, hud.BRIGHT, 800, max_width=wide - 2.0 * pad),
    ]
    y = top + pad + 1.9 * big + 0.5 * line
    for names, meaning in rows:
        x = left + pad
        for name in names:
            shapes += _key(x, y, name, size)
            x += _key_width(name, size) + 0.4 * size
        x = left + pad + keys + size
        shapes.append(Label(x, y, meaning, size, hud.BRIGHT, 500, max_width=left + wide - pad - x))
        y += line
    shapes.append(Label(left + pad, y + 0.35 * line, below, size, hud.DIM, 500, max_width=wide - 2.0 * pad))
    return shapes


def result_overlay(
    area: tuple[int, int], info: MatchInfo, ranking: Sequence[tuple[int, hud.AgentScore]], below: str
) -> list[Shape]:
    """The final standings, by rank, as many as there is room for.

    Args:
        area: (width, height).
        info: who plays.
        ranking: hunters or the first ones of teams, each with its team's catches, and then prey; each with its rank.
        below: a line below them.
    """
    width, height = area
    unit = min(width / 560.0, height / 560.0)
    size, big = hud.font_size(20 * unit, 11), hud.font_size(30 * unit, 14)
    line, pad = 1.8 * size, 1.6 * size
    shown = ranking[: max(1, int((0.9 * height - 2.0 * pad - 3.0 * big) // line))]
    wide, high = min(width - 4.0, 24.0 * size), len(shown) * line + 2.0 * pad + 3.0 * big
    left, top = (width - wide) / 2.0, (height - high) / 2.0
    shapes: list[Shape] = [
        Box(left, top, wide, high, hud.PANEL, 14 * unit),
        Label(
            left + pad, top + pad + 0.5 * big, _verdict(info, ranking), big, hud.BRIGHT, 800, max_width=wide - 2 * pad
        ),
    ]
    y = top + pad + 1.9 * big + 0.5 * line
    right = left + wide - pad
    for rank, one in shown:
        chip = left + pad + 2.2 * size
        name = chip + hud.chip_width(info, size) + 0.7 * size
        shapes.append(Label(left + pad + 1.2 * size, y, str(rank), size, hud.DIM, 600, "right"))
        shapes += hud.chip(chip, y, info, one.agent, size, faded=one.withdrawn)
        room = right - name - (6.4 if one.hunted else 2.4) * size
        shapes.append(Label(name, y, info.called(one.agent), size, hud.BRIGHT, 600, max_width=room))
        if one.hunted:
            shapes.append(Label(right - 2.0 * size, y, "caught", hud.font_size(0.8 * size, 9), hud.DIM, 500, "right"))
        shapes.append(Label(right, y, str(one.score), size, hud.BRIGHT, 800, "right"))
        y += line
    shapes.append(
        Label(left + pad, y + 0.3 * line, below, hud.font_size(0.8 * size, 10), hud.DIM, 500, max_width=wide - 2 * pad)
    )
    return shapes


def note_overlay(area: tuple[int, int], text: str) -> list[Shape]:
    """A line at the bottom of an area."""
    width, height = area
    size = hud.font_size(0.03 * min(width, height), 11)
    wide = min(width - 4.0, text_width(text, size, 600) + 2.0 * size)
    top = height - 2.9 * size
    return [
        Box((width - wide) / 2.0, top, wide, 2.0 * size, hud.PANEL, size),
        Label(width / 2.0, top + size, text, size, hud.BRIGHT, 600, "center", max_width=wide - size),
    ]


def seat_pointer(viewport: Viewport, position: tuple[float, float], color: Color) -> list[Shape]:
    """Which hunter is the person's: a word and an arrow over its place [m]."""
    x, y = viewport.to_pixels(*position)
    length = viewport.hunter_length
    side = 1.0 if y < viewport.height - 2.2 * length else -1.0
    tip, base = y + side * 0.85 * length, y + side * 1.25 * length
    size = hud.font_size(0.5 * length, 12)
    return [
        Polygon(((x, tip), (x - 0.26 * length, base), (x + 0.26 * length, base)), color),
        Label(x, base + side * 0.75 * size, "you", size, WHITE, 800, "center", outline=INK),
    ]


def _verdict(info: MatchInfo, ranking: Sequence[tuple[int, hud.AgentScore]]) -> str:
    for _, one in ranking:
        if one.hunted and info.names[one.agent] == _YOU:
            return f"You were caught {one.score} time{'' if one.score == 1 else 's'}"
    first = [one for rank, one in ranking if rank == 1 and not one.hunted]
    if len(first) > 1:
        return f"{len(first)} share the first rank"
    contender = info.contenders[info.contender_by_seat[first[0].agent]]
    if _YOU in (info.names[seat] for seat in contender.seats):
        return "You win" if len(contender.seats) == 1 else "Your team wins"
    return f"{contender.name} wins"


def _key_width(name: str, size: int) -> float:
    wide = 0.6 * size if name in _ARROWS else text_width(name, size, 600)
    return max(1.6 * size, wide + 0.9 * size)


def _key(x: float, middle: float, name: str, size: int) -> list[Shape]:
    """A key's cap; `x` is its left end."""
    wide = _key_width(name, size)
    cap = Box(x, middle - 0.75 * size, wide, 1.5 * size, _KEY, 0.3 * size)
    if name not in _ARROWS:
        return [cap, Label(x + wide / 2.0, middle, name, size, hud.BRIGHT, 600, "center")]
    right, down = _ARROWS[name]
    centre, half = x + wide / 2.0, 0.34 * size
    tip = (centre + right * half, middle + down * half)
    wings = [
        (centre - right * half + side * down * half, middle - down * half + side * right * half) for side in (1.0, -1.0)
    ]
    return [cap, Polygon((tip, wings[0], wings[1]), hud.BRIGHT)]
