"""Instants of a match that the frames of a video show, and the step of each."""

import math
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain, pairwise, starmap

from catch_arena.replay.motion import Poses, StepMotion, step_motion
from catch_arena.world import World


@dataclass(frozen=True, slots=True)
class Clip:
    """Part of a match at one pace."""

    start_ms: int
    end_ms: int
    fps: int
    speed: Fraction = Fraction(1)
    """Seconds of the match in a second of the video: below 1 is slow motion."""

    @property
    def frames(self) -> int:
        """Number of frames for the part's duration, rounded half up, at least 1."""
        return max(1, math.floor((self.end_ms - self.start_ms) / self._pace + Fraction(1, 2)))

    @property
    def times_ms(self) -> list[float]:
        """Instant of each frame [ms]."""
        return [float(self.start_ms + frame * self._pace) for frame in range(self.frames)]

    @property
    def _pace(self) -> Fraction:
        """Time of the match from frame to frame [ms]."""
        return 1000 * self.speed / self.fps


def frame_spans(
    worlds: Iterable[World], times_ms: Sequence[float]
) -> Iterator[tuple[StepMotion, Sequence[float], Poses | None]]:
    """Yield the steps of a match up to the last frame: motion, instants of its frames, and poses at the tick after it.

    The instants are in order, in [t, t + period), and none before the first frame. Memory does not grow with the match:
    two steps are known at a time. A match without steps gives one motion from its state to itself.
    """
    stream = iter(worlds)
    first = next(stream)
    second = next(stream, first)  # a match without steps has a motion too
    motions = starmap(step_motion, pairwise(chain((first, second), stream)))
    motion: StepMotion | None = next(motions)
    shown = 0
    while motion is not None and shown < len(times_ms):
        following = next(motions, None)
        end = len(times_ms) if following is None else bisect_left(times_ms, motion.after.time_ms)
        next_tick = None if following is None else following.poses[min(1, len(following.poses) - 1)]
        yield motion, times_ms[shown:end], next_tick
        shown, motion = end, following
