"""The 256 colours that stand for all those of a video."""

import numpy as np
from numpy.typing import NDArray

from catch_arena.render.optional_imports import cv2

Pixels = NDArray[np.uint8]
Codes = NDArray[np.uint16]
"""Colours in 16 bits: 5 of red, 6 of green, 5 of blue."""

_CODES = 1 << 16
_SAMPLE = 30_000
_COLORS = 255
"""One of the 256 is left for what FFmpeg lets shine through."""


class ColorHistogram:
    """How often each colour was seen; memory does not grow with the frames."""

    def __init__(self) -> None:
        self._seen = np.zeros(_CODES)
        self._sums = np.zeros((3, _CODES))

    def count(self, pixels: Pixels) -> Codes:
        """Count a quarter of a frame's pixels; the codes of all of them, (height, width)."""
        codes = np.ascontiguousarray(cv2.cvtColor(pixels, cv2.COLOR_RGBA2BGR565).view(np.uint16)[..., 0])
        some = codes[::2, ::2].ravel()
        self._seen += np.bincount(some, minlength=_CODES)
        for channel in range(3):
            self._sums[channel] += np.bincount(some, pixels[::2, ::2, channel].ravel(), minlength=_CODES)
        return codes

    def palette(self) -> tuple[Pixels, Pixels]:
        """The palette, (256, 4) as alpha, red, green, blue; and each code's index in it, (65536,)."""
        known = np.flatnonzero(self._seen)
        often = self._seen[known]
        colors = (self._sums[:, known] / often).T.astype(np.float32)
        centers = colors.copy() if len(known) <= _COLORS else _means(colors, np.sqrt(often))
        nearest = _nearest(colors, centers)
        for index in range(len(centers)):  # the most frequent colour of each group stands for it: large areas are exact
            group = np.flatnonzero(nearest == index)
            if len(group):
                centers[index] = colors[group[often[group].argmax()]]
        palette = np.zeros((256, 4), dtype=np.uint8)
        palette[:, 0] = 255
        palette[: len(centers), 1:] = np.rint(centers)
        every = np.arange(_CODES)
        # a code that was not counted is the colour that its bits stand for
        bits = np.stack([(every >> 11) * 255 / 31, (every >> 5 & 63) * 255 / 63, (every & 31) * 255 / 31], axis=1)
        bits[known] = colors
        return palette, _nearest(bits.astype(np.float32), centers)


def _means(colors: NDArray[np.float32], weights: NDArray[np.float64]) -> NDArray[np.float32]:
    """As many colours as there is room for, to which those given are near.

    Weights are the roots of how often each was seen: without the root the ground would take most of the palette.
    """
    sample = np.random.default_rng(0).choice(len(colors), _SAMPLE, p=weights / weights.sum())
    enough = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 8, 1.0)
    cv2.setRNGSeed(0)
    nothing = np.empty(0, dtype=np.int32)
    _, _, centers = cv2.kmeans(colors[sample], _COLORS, nothing, enough, 1, cv2.KMEANS_RANDOM_CENTERS)
    return np.asarray(centers, dtype=np.float32)


def _nearest(colors: NDArray[np.float32], centers: NDArray[np.float32]) -> Pixels:
    """The index of the centre that is nearest to each colour."""
    indices = [
        ((part[:, None] - centers[None]) ** 2).sum(axis=2).argmin(axis=1)
        for part in np.array_split(colors, 1 + len(colors) // 1024)
    ]
    return np.concatenate(indices).astype(np.uint8)
