"""Films that are not played at one pace from end to end: chosen instants, and slow motion in the middle."""

from bisect import bisect_left
from dataclasses import dataclass

from catch_arena.render.motion import Cut


@dataclass(frozen=True, slots=True)
class Stills:
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
class Splice:
    """Cuts of one match, each beginning where the one before it ends: their pace may differ."""

    cuts: tuple[Cut, ...]

    @property
    def frames(self) -> int:
        """Those of all cuts."""
        return sum(map(_whole, self.cuts))

    def time_ms(self, frame: int) -> float:
        """The instant that a frame shows."""
        cut, own = self.cut_of(frame)
        return cut.time_ms(own)

    def frames_before(self, time_ms: int) -> int:
        """How many frames show earlier instants."""
        return sum(min(_whole(cut), cut.frames_before(time_ms)) for cut in self.cuts)

    def cut_of(self, frame: int) -> tuple[Cut, int]:
        """The cut that a frame belongs to, and its number there."""
        for cut in self.cuts:
            if frame < _whole(cut):
                return cut, frame
            frame -= _whole(cut)
        raise IndexError("no such frame")


def _whole(cut: Cut) -> int:
    """A cut's frames without one at its end, where the next cut begins."""
    return cut.frames_before(cut.end_ms)
