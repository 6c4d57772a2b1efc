"""What a bag tells of turtlesim: where the turtles were, which were alive, and who was asked for."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from catch_arena.messages import Pose, TurtleArray


class Placed(NamedTuple):
    """A pose at a time."""

    time_ms: float
    pose: Pose


class Listed(NamedTuple):
    """A list of alive targets, as it was published."""

    time_ms: float
    turtles: TurtleArray


@dataclass(frozen=True, slots=True)
class Asked:
    """A call of catch_turtle."""

    time_ms: float
    name: str
    hunter: str | None
    """Who asked; None where the recording does not tell."""
    success: bool | None
    """The answer; None where there is none."""


@dataclass(slots=True)
class Track:
    """One turtle's poses in the order of time."""

    placed: list[Placed] = field(default_factory=list)

    def last(self, time_ms: float) -> Pose | None:
        """The last pose that was told until then."""
        at = bisect_right(self.placed, time_ms, key=_time)
        return self.placed[at - 1].pose if at else None

    def at(self, time_ms: float) -> Pose:
        """Where it was then: on the straight way between two poses, and at rest before the first and after the last."""
        at = bisect_right(self.placed, time_ms, key=_time)
        if at in {0, len(self.placed)}:
            return self.placed[max(0, at - 1)].pose
        (begin, start), (end, stop) = self.placed[at - 1 : at + 1]
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


@dataclass(frozen=True, slots=True)
class Recording:
    """A bag's story; times are milliseconds since its first message."""

    hunters: dict[str, Track]
    """By name, in the order of seats."""
    targets: dict[str, Track]
    """Of the targets whose poses were recorded."""
    lists: Sequence[Listed]
    asked: Sequence[Asked]
    end_ms: float
    left_out: int = 0
    """Messages that could not be: not finite, or far outside the arena."""

    def listed(self, time_ms: float) -> TurtleArray:
        """The last list that was told before then."""
        at = bisect_right(self.lists, time_ms, key=_time)
        while at and self.lists[at - 1].time_ms >= time_ms:
            at -= 1
        return self.lists[at - 1].turtles if at else TurtleArray(())


def _time(one: Placed | Listed) -> float:
    return one.time_ms
