"""Frames look like the golden frames that a person has checked (`make golden`)."""

import cv2
import numpy as np
import pytest
from render.golden import FOLDER, GOLDEN_FRAMES, frame_of

from catch_arena.render import text

HAS_OWN_FONT = text._FACE is not None


def difference(frame: np.ndarray, name: str) -> tuple[float, float]:
    """In levels: the mean, and the one that a thousandth of the pixels exceed."""
    kept = cv2.cvtColor(cv2.imread(str(FOLDER / f"{name}.png")), cv2.COLOR_BGR2RGB)
    assert kept.shape == frame.shape
    off = np.abs(frame.astype(int) - kept).max(axis=2)
    return float(off.mean()), float(np.quantile(off, 0.999))


@pytest.mark.parametrize("golden", GOLDEN_FRAMES, ids=lambda golden: golden.name)
def test_a_frame_looks_as_it_did(golden):
    """With room for another version's way to round, and for the other font, if this is opencv 4."""
    mean, most = difference(frame_of(golden), golden.name)
    assert mean < (1.0 if HAS_OWN_FONT else 3.0)
    assert most < (80.0 if HAS_OWN_FONT else 200.0)


def test_the_comparison_tells_a_tenth_of_a_second_from_the_next():
    mean, most = difference(frame_of(GOLDEN_FRAMES[1], later_ms=100), GOLDEN_FRAMES[1].name)
    assert mean > 1.0 or most > 80.0
