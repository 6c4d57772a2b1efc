"""Which instant of a match each frame of a video shows, a clip at one pace, clips of several, single instants; and in
which step it lies.
"""

import math
from bisect import bisect_left
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

from catch_arena.replay.motion import Poses, StepMotion, step_motion
from catch_arena.world import World


class FrameTiming(Protocol):
    """Which instants of a match the frames of a video show; none lies before the one of the frame before."""

    @property
    def frames(self) -> int:
        """How many."""

    def time_ms(self, frame: int) -> float:
        """The instant that a frame shows."""

    def frames_before(self, time_ms: int) -> int:
        """How many frames show earlier instants."""


@dataclass(frozen=True, slots=True)
class Clip:
    """A part of a match at one pace."""

    start_ms: int
    end_ms: int
    fps: int
    speed: Fraction = Fraction(1)
    """Seconds of the match in a second of the video: below 1 is slow motion."""

    @property
    def frames(self) -> int:
        """As many as the part lasts, rounded half up, at least 1."""
        return max(1, math.floor((self.end_ms - self.start_ms) / self._pace + Fraction(1, 2)))

    @property
    def _pace(self) -> Fraction:
        """Milliseconds of the match from frame to frame."""
        return 1000 * self.speed / self.fps

    def time_ms(self, frame: int) -> float:
        """The instant that a frame shows."""
        return float(self.start_ms + frame * self._pace)

    def frames_before(self, time_ms: int) -> int:
        """How many frames show earlier instants."""
        return min(self.frames, max(0, math.ceil((time_ms - self.start_ms) / self._pace)))


@dataclass(frozen=True, slots=True)
class Snapshots:
    """One frame for each of these instants."""

    times_ms: tuple[float, ...]
    """In order."""

    @property
    def frames(self) -> int:
        """One each."""
        return len(self.times_ms)

    def time_ms(self, frame: int) -> float:
        """The instant that a frame shows."""
        return self.times_ms[frame]

    def frames_before(self, time_ms: int) -> int:
        """How many frames show earlier instants."""
        return bisect_left(self.times_ms, time_ms)


@dataclass(frozen=True, slots=True)
class ClipSequence:
    """Clips of one match, each beginning where the one before it ends: their pace may differ."""

    clips: tuple[Clip, ...]

    @property
    def frames(self) -> int:
        """Those of all clips."""
        return sum(map(_frames_of, self.clips))

    def time_ms(self, frame: int) -> float:
        """The instant that a frame shows."""
        clip, own = self.clip_of(frame)
        return clip.time_ms(own)

    def frames_before(self, time_ms: int) -> int:
        """How many frames show earlier instants."""
        return sum(min(_frames_of(clip), clip.frames_before(time_ms)) for clip in self.clips)

    def clip_of(self, frame: int) -> tuple[Clip, int]:
        """The clip that a frame belongs to, and its number there."""
        for clip in self.clips:
            if frame < _frames_of(clip):
                return clip, frame
            frame -= _frames_of(clip)
        raise IndexError("no such frame")


def _frames_of(clip: Clip) -> int:
    """A clip's frames without one at its end, where the next clip begins."""
    return clip.frames_before(clip.end_ms)


@dataclass(frozen=True, slots=True)
class FrameSpan:
    """One step's motion and the frames in it: none where steps are shorter than frames, or before the clip."""

    motion: StepMotion
    frames: range
    next_tick: Poses | None


def frame_spans(worlds: Iterable[World], timing: FrameTiming) -> Iterator[FrameSpan]:
    """The steps of a match up to the last frame, each with its frames: those that show [t, t + period).

    Memory does not grow with the match: two steps are known at a time. A match without steps is one motion that leads
    nowhere.
    """
    motions = _motions(worlds)
    motion: StepMotion | None = next(motions)
    shown = 0
    while motion is not None and shown < timing.frames:
        following = next(motions, None)
        end = timing.frames if following is None else timing.frames_before(motion.after.time_ms)
        yield FrameSpan(
            motion, range(shown, end), None if following is None else following.poses[min(1, len(following.poses) - 1)]
        )
        shown, motion = end, following


def _motions(worlds: Iterable[World]) -> Iterator[StepMotion]:
    stream = iter(worlds)
    first = before = next(stream)
    for after in stream:
        yield step_motion(before, after)
        before = after
    if before is first:
        yield step_motion(first, first)
