"""What a bag tells of turtlesim: where the turtles were, which were alive, and who was asked for."""

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from catch_arena.messages import Pose, TurtleArray

Place = tuple[float, float]
"""x, y [m]."""


class Placed(NamedTuple):
    """A pose at a time."""

    time_ms: float
    pose: Pose


class Listed(NamedTuple):
    """A list of alive targets, as it was published."""

    time_ms: float
    turtles: TurtleArray


@dataclass(slots=True)
class Track:
    """One turtle's poses, at least one, in the order of time."""

    placed: list[Placed] = field(default_factory=list)

    def last(self, time_ms: float) -> Pose:
        """The last pose that was told until then; the first one before that."""
        return self.placed[max(0, self._after(time_ms) - 1)].pose

    def at(self, time_ms: float) -> Pose:
        """Where it was then: on the straight way between two poses, and at rest before the first and after the last."""
        after = self._after(time_ms)
        if after in {0, len(self.placed)}:
            return self.placed[max(0, after - 1)].pose
        (begin, start), (end, stop) = self.placed[after - 1 : after + 1]
        part = (time_ms - begin) / (end - begin)
        turn = math.remainder(stop.theta - start.theta, math.tau)
        return Pose(
            start.x + (stop.x - start.x) * part,
            start.y + (stop.y - start.y) * part,
            math.remainder(start.theta + turn * part, math.tau),
            stop.linear_velocity,
            stop.angular_velocity,
        )

    @property
    def begin_ms(self) -> float:
        """When it was first heard of."""
        return self.placed[0].time_ms

    @property
    def end_ms(self) -> float:
        """When it was last heard of."""
        return self.placed[-1].time_ms

    def _after(self, time_ms: float) -> int:
        """How many poses had been told then."""
        return bisect_right(self.placed, time_ms, key=lambda one: one.time_ms)


@dataclass(slots=True)
class RecordedRequest:
    """A catch, or a call of catch_turtle: what was asked for, and how things stood when it was."""

    time_ms: float
    name: str
    hunter: str | None
    """Who asked; None where the bag does not tell."""
    success: bool | None
    """The answer; None where there is none."""
    hunters: Mapping[str, Place]
    """The last poses that had been told."""
    targets: Mapping[str, Place]
    """Those that were alive, as far as was told."""


@dataclass(frozen=True, slots=True)
class BagContents:
    """What was read of a bag; times are milliseconds since its first message."""

    hunters: Mapping[str, Track]
    """By name, in the order of seats."""
    targets: Mapping[str, Track]
    """Of the targets whose poses were recorded."""
    lists: Sequence[Listed]
    asked: Sequence[RecordedRequest]
    """Catches that the lists tell, or the calls of the service where these were recorded."""
    end_ms: float
    left_out: int
    """Messages that could not be used: not readable, not finite, or outside turtlesim's window."""
