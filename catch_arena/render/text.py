"""Text as coverage, in the font of opencv 5 or, with opencv 4, of pygame; fonts of the system are never used."""

import math
import re
import unicodedata
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.render.optional_imports import cv2, pygame
from catch_arena.text import composed

ELLIPSIS: Final = "…"
LONGEST: Final = 200
"""Greatest number of characters of a text; a longer one is cut before it is measured."""
BASELINE: Final = 1.1
"""Distance of the baseline from the top of a text's coverage [sizes]."""
MIDDLE: Final = 0.36
"""Height of the middle of capitals above the baseline [sizes]."""

_RIGHT_TO_LEFT: Final = re.compile(
    "[\u0590-\u08ff\ufb1d-\ufdff\ufe70-\ufefc]+(?: +[\u0590-\u08ff\ufb1d-\ufdff\ufe70-\ufefc]+)*"
)

_FACE: Any = cv2.FontFace("sans") if hasattr(cv2, "FontFace") else None


def as_drawn(text: str) -> str:
    """Return the text in one line, in the order in which it is seen.

    Tabs, line ends and control characters become spaces, and invisible marks are removed. Text that is written from
    right to left (Hebrew, Arabic) is reversed, since letters are set from left to right. A letter that the font does
    not have is drawn as a question mark.
    """
    signs = (
        sign if sign.isprintable() else " " for sign in composed(text[:LONGEST]) if unicodedata.category(sign) != "Cf"
    )
    return _RIGHT_TO_LEFT.sub(lambda run: run[0][::-1], "".join(signs))


@lru_cache(maxsize=2048)
def text_width(text: str, size: int, weight: int) -> int:
    """Return the width of a text [pixels]."""
    text = as_drawn(text)
    if not text:
        return 0
    if _FACE is None:
        return int(_bundled_font(size).size(text)[0])
    return int(cv2.getTextSize((0, 0), text, (0, 0), _FACE, size, weight)[2])


@lru_cache(maxsize=512)
def truncated(text: str, size: int, weight: int, max_width: float) -> str:
    """Return the text, or as much of it as fits with an ellipsis, or an empty text if not even that fits."""
    text = as_drawn(text)
    if text_width(text, size, weight) <= max_width:
        return text
    for length in range(len(text) - 1, 0, -1):
        shown = text[:length].rstrip() + ELLIPSIS
        if text_width(shown, size, weight) <= max_width:
            return shown
    return ""


def wrapped(text: str, size: int, weight: int, max_width: float) -> list[str]:
    """Return a text as lines that fit; a word that is too long has a line of its own."""
    first, *words = text.split() or [""]
    lines = [first]
    for word in words:
        longer = f"{lines[-1]} {word}"
        if text_width(longer, size, weight) <= max_width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines


def coverage(text: str, size: int, weight: int) -> NDArray[np.uint8]:
    """Return a text's coverage (height, width), 0 to 255, in one line.

    There are `size` pixels of room at each side, and the baseline is at BASELINE sizes.
    """
    width, height = text_width(text, size, weight) + 2 * size, math.ceil(1.55 * size)
    baseline = round(BASELINE * size)
    ink = np.zeros((height, width), dtype=np.uint8)
    if _FACE is not None:
        cv2.putText(ink, text, (size, baseline), (255, 0, 0, 0), _FACE, size, weight)
        return ink
    font = _bundled_font(size)
    drawn = font.render(text, antialias=True, color=(255, 255, 255))
    alpha = pygame.surfarray.array_alpha(drawn).T
    top = baseline - font.get_ascent()
    rows = slice(max(0, top), min(height, top + alpha.shape[0]))
    ink[rows, size : size + alpha.shape[1]] = alpha[rows.start - top : rows.stop - top, : width - size]
    return ink


@lru_cache(maxsize=64)
def _bundled_font(size: int) -> "pygame.font.Font":
    pygame.font.init()
    # None is pygame's own font; its capitals are 0.5 of the size high, those of opencv's font 0.7
    return pygame.font.Font(None, round(1.42 * size))
