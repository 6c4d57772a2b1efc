"""Directions in the world frame and in the frame of a hunter or prey, as numbers or as arrays."""

from typing import TypeVar

TYPE_CHECKING = False  # agents that do not use NumPy need not load it
if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Number = TypeVar("Number", float, "NDArray[np.float64]")
"""A number, or an array of numbers, in functions that compute the same for both."""


def own_frame(cosine: Number, sine: Number, dx: Number, dy: Number) -> tuple[Number, Number]:
    """Return a direction of the world frame as (forward, left) in a frame whose heading has this cosine and sine."""
    return cosine * dx + sine * dy, cosine * dy - sine * dx


def world_frame(cosine: Number, sine: Number, forward: Number, left: Number) -> tuple[Number, Number]:
    """Return a direction (forward, left) as (dx, dy) of the world frame; the inverse of `own_frame`."""
    return cosine * forward - sine * left, sine * forward + cosine * left
