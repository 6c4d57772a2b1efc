"""The key card lists every key."""

import pytest

from catch_arena.live import overlays
from catch_arena.render.shapes import Box, Label
from catch_arena.render.viewport import Viewport

AREAS = [(320, 240), (720, 720), (2160, 2160)]


def within(shapes, area) -> bool:
    boxes = [shape for shape in shapes if isinstance(shape, Box)]
    labels = [shape for shape in shapes if isinstance(shape, Label)]
    return all(
        box.left >= 0 and box.top >= 0 and box.left + box.width <= area[0] and box.top + box.height <= area[1]
        for box in boxes
    ) and all(0 <= label.x <= area[0] and 0 <= label.y <= area[1] for label in labels)


@pytest.mark.parametrize("area", AREAS)
def test_every_key_is_on_the_card(area):
    rows = (*overlays.DRIVING, *overlays.WINDOW)
    shapes = overlays.keys_overlay(Viewport(*area, 11.0), rows, "press any key to begin")
    texts = [shape.text for shape in shapes if isinstance(shape, Label)]
    assert texts == [text for row in rows for text in row] + ["press any key to begin"]
    keys = [key for names, _ in rows for key in names.split(", ")]
    assert {"W", "A", "S", "D", "space", "P", "N", ".", "R", "Ctrl-S", "H", "Esc"} <= set(keys)
    assert len(set(keys)) == len(keys)  # one key, one meaning
    assert within(shapes, area)
