"""What a turtle looks like, as outlines: `sprites` draws them, and so does the player of a web page."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
"""(N, 2), in lengths of the turtle, which faces right; y up."""


def ellipse(x: float, y: float, a: float, b: float, degrees: float = 0.0) -> Points:
    """(40, 2): an ellipse, by its centre, half its length, half its width, and how it is turned."""
    around = np.linspace(0.0, 2.0 * math.pi, 40, endpoint=False)
    along, across = a * np.cos(around), b * np.sin(around)
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.stack([x + cosine * along - sine * across, y + sine * along + cosine * across], axis=1)


def _parts() -> list[tuple[Points, float, float]]:
    limbs = [
        (x, side * y, a, b, side * turn)
        for x, y, a, b, turn in ((0.17, 0.27, 0.18, 0.075, 52.0), (-0.29, 0.21, 0.13, 0.065, 140.0))
        for side in (1.0, -1.0)
    ]
    limbs.append((0.40, 0.0, 0.125, 0.095, 0.0))  # the head
    rim = (0.42, 0.0)
    parts = [(ellipse(x, y, a + 0.022, b + 0.022, turn), *rim) for x, y, a, b, turn in limbs]
    parts.append((np.array([(-0.33, 0.05), (-0.5, 0.0), (-0.33, -0.05)]), *rim))
    parts += [(ellipse(x, y, a - 0.004, b - 0.004, turn), 0.80, 0.05) for x, y, a, b, turn in limbs]
    parts += [(ellipse(0.445, side * 0.052, 0.026, 0.026), 0.0, 0.04) for side in (1.0, -1.0)]
    parts.append((ellipse(-0.03, 0.0, 0.335, 0.275), *rim))
    parts.append((ellipse(-0.03, 0.0, 0.285, 0.228), 0.96, 0.02))
    return parts


TURTLE_PARTS: Final = _parts()
"""Outline, the part of its own colour, the part of white; the lowest first."""
