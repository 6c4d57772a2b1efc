"""Texts over the arena: a card with the keys, and a pointer to the person's agent."""

from collections.abc import Sequence
from typing import Final

from catch_arena.render import hud
from catch_arena.render.shapes import INK, WHITE, Box, Color, Label, Polygon, Shape
from catch_arena.render.text import text_width
from catch_arena.render.viewport import Viewport

DRIVING: Final = (
    ("W, up", "ahead"),
    ("A, left", "turn left"),
    ("D, right", "turn right"),
    ("S, down", "back, if hunters may reverse"),
    ("gamepad", "the stick also drives"),
)
WINDOW: Final = (
    ("P, space", "pause, continue"),
    ("N, .", "one step, while paused"),
    ("+, -", "faster, slower"),
    ("V", "view of a hunter; next hunter"),
    ("R", "restart the match"),
    ("Ctrl-S", "save the replay"),
    ("H", "show these keys"),
    ("Esc", "quit"),
)


def keys_overlay(viewport: Viewport, rows: Sequence[tuple[str, str]], below: str) -> list[Shape]:
    """Return a card in the middle of the arena: rows of keys with their meaning, and a line below them."""
    width, height = viewport.width, viewport.height
    size = hud.font_size(17 * min(width, height) / 560.0, 10)
    line = min(2.0 * size, (height - 4.0) / (len(rows) + 3.0))
    keys, meanings = (max(text_width(row[part], size, 600) for row in rows) for part in (0, 1))
    wide, high = min(width - 4.0, keys + meanings + 4.0 * size), line * (len(rows) + 3.0)
    left, y = (width - wide) / 2.0 + 1.5 * size, (height - high) / 2.0 + line
    shapes: list[Shape] = [Box(left - 1.5 * size, y - line, wide, high, hud.PANEL, 0.8 * size)]
    room = wide - 3.0 * size
    for names, meaning in rows:
        shapes += [
            Label(left, y, names, size, hud.BRIGHT, 700),
            Label(left + keys + size, y, meaning, size, hud.BRIGHT, 500, max_width=room - keys - size),
        ]
        y += line
    return [*shapes, Label(left, y + 0.5 * line, below, size, hud.DIM, 500, max_width=room)]


def seat_pointer(viewport: Viewport, position: tuple[float, float], color: Color) -> list[Shape]:
    """Return a word and an arrow that point to the person's agent at its place [m]."""
    x, y = viewport.to_pixels(*position)
    length = viewport.hunter_length
    side = 1.0 if y < viewport.height - 2.2 * length else -1.0
    tip, base = y + side * 0.85 * length, y + side * 1.25 * length
    size = hud.font_size(0.5 * length, 12)
    return [
        Polygon(((x, tip), (x - 0.26 * length, base), (x + 0.26 * length, base)), color),
        Label(x, base + side * 0.75 * size, "you", size, WHITE, 800, "center", outline=INK),
    ]
