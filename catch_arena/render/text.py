"""Text as coverage: the font that opencv 5 carries, or pygame's own with opencv 4; never one of the system's."""

import math
import re
import unicodedata
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.render.optional_imports import cv2, pygame
from catch_arena.text import composed

Coverage = NDArray[np.uint8]
"""(height, width), 0 to 255."""

ELLIPSIS: Final = "…"
LONGEST: Final = 200
"""Characters: what is longer is cut before it is measured."""
BASELINE: Final = 1.1
"""From the top of a text's coverage [sizes]."""
MIDDLE: Final = 0.36
"""From the baseline up to the middle of the capitals [sizes]."""

_RIGHT_TO_LEFT: Final = re.compile(
    "[\u0590-\u08ff\ufb1d-\ufdff\ufe70-\ufefc]+(?: +[\u0590-\u08ff\ufb1d-\ufdff\ufe70-\ufefc]+)*"
)

_FACE: Any = cv2.FontFace("sans") if hasattr(cv2, "FontFace") else None


def printable(text: str) -> str:
    """One line of it, in the order in which it is seen.

    Tabs, line ends and control characters become spaces, invisible marks go, and what is written from right to left
    (Hebrew, Arabic) is turned round, since the font's letters are set from left to right. A letter that the font does
    not have is drawn as a question mark.
    """
    signs = (
        sign if sign.isprintable() else " " for sign in composed(text[:LONGEST]) if unicodedata.category(sign) != "Cf"
    )
    return _RIGHT_TO_LEFT.sub(lambda run: run[0][::-1], "".join(signs))


@lru_cache(maxsize=2048)
def text_width(text: str, size: int, weight: int) -> int:
    """How far a text reaches [pixels]."""
    text = printable(text)
    if not text:
        return 0
    if _FACE is None:
        return int(_bundled_font(size).size(text)[0])
    return int(cv2.getTextSize((0, 0), text, (0, 0), _FACE, size, weight)[2])


@lru_cache(maxsize=512)
def truncated(text: str, size: int, weight: int, max_width: float) -> str:
    """The text, or as much of it as fits with an ellipsis, or nothing where not even that fits."""
    text = printable(text)
    if text_width(text, size, weight) <= max_width:
        return text
    short, long = 0, len(text)
    while short < long:  # the longest beginning that fits
        middle = (short + long + 1) // 2
        if text_width(text[:middle].rstrip() + ELLIPSIS, size, weight) <= max_width:
            short = middle
        else:
            long = middle - 1
    return text[:short].rstrip() + ELLIPSIS if short else ""


def coverage(text: str, size: int, weight: int) -> Coverage:
    """The text in one line, `size` pixels of room at each side, its baseline BASELINE sizes from the top."""
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
    # None is the one in pygame's own folder; pygame makes its capitals half as high as it is asked to, the other 0.7
    return pygame.font.Font(None, round(1.42 * size))
