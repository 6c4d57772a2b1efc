"""Texts over the arena: a card with the keys, and a pointer to the person's agent."""

from collections.abc import Sequence
from typing import Final

from catch_arena.render import hud
from catch_arena.render.shapes import INK, WHITE, Box, Color, Label, Polygon, Shape
from catch_arena.render.text import text_width
from catch_arena.render.viewport import Viewport

_KEY: Final[Color] = (58, 67, 118)

DRIVING: Final = (
    (("up", "W"), "ahead"),
    (("left", "A"), "turn left"),
    (("right", "D"), "turn right"),
    (("down", "S"), "back, if hunters may reverse"),
    (("gamepad",), "the stick also drives"),
)
WINDOW: Final = (
    (("space", "P"), "pause, continue"),
    (("N", "."), "one step, while paused"),
    (("+", "-"), "faster, slower"),
    (("V",), "view of a hunter; next hunter"),
    (("R",), "restart the match"),
    (("Ctrl-S",), "save the replay"),
    (("H",), "show these keys"),
    (("Esc",), "quit"),
)


def keys_overlay(viewport: Viewport, rows: Sequence[tuple[tuple[str, ...], str]], below: str) -> list[Shape]:
    """Return a card in the middle of the arena: rows of keys with their meaning, and a line below them."""
    width, height, title = viewport.width, viewport.height, "Keys"
    unit = min(width / 560.0, height / 560.0)
    size, big = hud.font_size(17 * unit, 10), hud.font_size(26 * unit, 13)
    pad = 1.6 * size
    line = min(2.0 * size, (height - 4.0 - 2.0 * pad - 2.4 * big) / (len(rows) + 1.2))
    keys = max(sum(_key_width(key, size) + 0.4 * size for key in names) for names, _ in rows)
    texts = max(text_width(meaning, size, 500) for _, meaning in rows)
    text_right = max(keys + 2.0 * size + texts, text_width(below, size, 500))
    wide = min(width - 4.0, text_right + 2.0 * pad)
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
            key = _key_width(name, size)
            shapes += [
                Box(x, y - 0.75 * size, key, 1.5 * size, _KEY, 0.3 * size),
                Label(x + key / 2.0, y, name, size, hud.BRIGHT, 600, "center"),
            ]
            x += key + 0.4 * size
        x = left + pad + keys + size
        shapes.append(Label(x, y, meaning, size, hud.BRIGHT, 500, max_width=left + wide - pad - x))
        y += line
    shapes.append(Label(left + pad, y + 0.35 * line, below, size, hud.DIM, 500, max_width=wide - 2.0 * pad))
    return shapes


def _key_width(name: str, size: int) -> float:
    return max(1.6 * size, text_width(name, size, 600) + 0.9 * size)


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
