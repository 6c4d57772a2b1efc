"""Contents of a bag of turtlesim: the turtles' poses, and the targets that were alive.

Times are milliseconds since the bag's first message.
"""

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from catch_arena.messages import Pose, Turtle
from catch_arena.replay.motion import interpolate


@dataclass(slots=True)
class Track:
    """Poses of one turtle, at least one, in the order of time."""

    times_ms: list[float] = field(default_factory=list)
    poses: list[Pose] = field(default_factory=list)

    def last(self, time_ms: float) -> Pose:
        """Return the last pose at or before a time, or else the first one."""
        return self.poses[max(0, bisect_right(self.times_ms, time_ms) - 1)]

    def at(self, time_ms: float) -> Pose:
        """Return the pose at a time: interpolated between recorded poses, or the nearest end outside the track."""
        after = bisect_right(self.times_ms, time_ms)
        if after in {0, len(self.poses)}:
            return self.last(time_ms)
        begin_ms, end_ms = self.times_ms[after - 1 : after + 1]
        start, stop = self.poses[after - 1 : after + 1]
        part = (time_ms - begin_ms) / (end_ms - begin_ms)
        x, y, theta = interpolate(start[:3], stop[:3], part)
        return Pose(x, y, math.remainder(theta, math.tau), *stop[3:])

    @property
    def end_ms(self) -> float:
        """Time of the last pose."""
        return self.times_ms[-1]


@dataclass(frozen=True, slots=True)
class BagContents:
    """Contents of a bag."""

    hunters: Mapping[str, Track]
    """Tracks of the hunters by name, in the order of seats."""
    lists: Sequence[tuple[float, Sequence[Turtle]]]
    """Times [ms] and the targets that were alive from then on, in places clamped to the window as turtlesim does.

    A target that leaves the list was caught.
    """
    end_ms: float
    left_out: int
    """Number of messages that are damaged or have impossible values."""
