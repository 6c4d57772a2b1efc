"""Directions and places in the frames of hunters, prey and the world; functions of a `Number` also take arrays."""

from typing import Any, TypeVar

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


def place_after(target: Any, lead_s: Number) -> tuple[Number, Number]:
    """Return the place (forward, left) [m] of a target that drives straight on for some time [s].

    The target is a `SeenTarget`, or the targets of a `BatchView`.
    """
    forward: Number = target.forward + target.linear_velocity * target.heading_cos * lead_s
    left: Number = target.left + target.linear_velocity * target.heading_sin * lead_s
    return forward, left


def is_nearer(rival: Any, forward: Number, left: Number) -> Any:
    """Return whether a rival is nearer than the hunter to a place (forward, left) of the hunter's own frame [m].

    The rival is a `SeenHunter`, or the rivals of a `BatchView` with arrays of a shape that fits the places.
    """
    dx, dy = forward - rival.forward, left - rival.left
    return dx * dx + dy * dy < forward * forward + left * left
