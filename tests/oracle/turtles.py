"""The oracle's turtles: what hunters and targets are, and how they lie to each other (A.7, geometry)."""

import math
import struct
from collections.abc import Sequence

from oracle.arithmetic import sincos


def distance(x: float, y: float, x_other: float, y_other: float) -> float:
    """A.7, geometry: d [m]."""
    dx = x_other - x
    dy = y_other - y
    return math.sqrt(dx * dx + dy * dy)


def micrometres(d: float) -> int:
    """R5.3: a distance [m] in whole micrometres."""
    return math.floor(1000000.0 * d + 0.5)


def reach_in_micrometres(reach_m: float) -> int:
    """R5.3: the reach that a distance must stay below."""
    return max(1, math.floor(1000000.0 * reach_m + 0.5))


def by_seat(value: float | Sequence[float], count: int) -> list[float]:
    """R2.7: a number for all hunters, or one for each seat."""
    return [value] * count if isinstance(value, int | float) else list(value)


def nearness(x: float, y: float, x_other: float, y_other: float) -> int:
    """A.7, geometry: near, by which what is seen is ordered."""
    dx = x_other - x
    dy = y_other - y
    (bits,) = struct.unpack("<I", struct.pack("<f", dx * dx + dy * dy))
    return (int(bits) + 32) // 64


class Turtle:
    """A body that chapter 2 moves: a pose, a command, and whether the last step met a wall."""

    def __init__(self, x: float, y: float, theta: float) -> None:
        self.x = x
        self.y = y
        self.theta = theta
        self.v = 0.0
        self.w = 0.0
        self.at_wall = False


class Hunter(Turtle):
    """One hunter: besides, its controller's memory and its score."""

    def __init__(self, seat: int, x: float, y: float, theta: float) -> None:
        super().__init__(x, y, theta)
        self.seat = seat
        self.distance_integral = 0.0
        self.bearing_integral = 0.0
        self.active = 0
        self.score = 0
        self.withdrawn = False

    def stand_still(self) -> None:
        """Hold: no velocity, no integrals, no active target (A.7)."""
        self.v = self.w = 0.0
        self.distance_integral = self.bearing_integral = 0.0
        self.active = 0


class Target(Turtle):
    """One alive target."""

    def __init__(self, number: int, x: float, y: float, theta: float, appeared: int) -> None:
        super().__init__(x, y, theta)
        self.number = number
        self.appeared = appeared


class Prey:
    """One agent that plays targets (chapter 12)."""

    def __init__(self, index: int, target: Target) -> None:
        self.index = index
        self.target: Target | None = target
        """Target that it plays; None while it is out."""
        self.times_caught = 0
        self.caught_at: int | None = None
        """While it is out, the time of the state on which it was caught [ms]."""
        self.withdrawn = False


def in_own_frame(observer: Turtle, x: float, y: float) -> tuple[float, float]:
    """A.7, geometry: (forward, left) of a point [m]."""
    sine, cosine = sincos(observer.theta)
    dx = x - observer.x
    dy = y - observer.y
    return cosine * dx + sine * dy, cosine * dy - sine * dx


def relative_heading(observer: Turtle, other: Turtle) -> tuple[float, float]:
    """A.7, observation: cosine and sine of another's heading relative to the observer's."""
    sine, cosine = sincos(observer.theta)
    its_sine, its_cosine = sincos(other.theta)
    return its_cosine * cosine + its_sine * sine, its_sine * cosine - its_cosine * sine
