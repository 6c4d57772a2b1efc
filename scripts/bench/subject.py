"""One thing with a step to be measured, and how a turn of it is timed."""

import resource
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple


class Turn(NamedTuple):
    """One turn of a subject: seconds of a step, of all threads and processes, and on the clock."""

    cpu_s: float
    wall_s: float


@dataclass
class Subject:
    """Something with a step, made for one process."""

    step: Callable[[], object]
    agents: int = 1
    """In one environment."""
    envs: int = 1
    floats: int = 0
    """Numbers that an agent sees."""
    steps_per_call: int = 1
    threads: int = 1
    value: Callable[[], float] | None = None
    """Measures something else than time, such as bytes."""

    def turn(self, seconds: float) -> Turn:
        """Call the step for about that many CPU-seconds. Clocks are read rarely if a step is short."""
        if self.value:
            return Turn(self.value(), 0.0)
        calls, chunk, wall, cpu = 0, 1, time.perf_counter(), cpu_seconds()
        while (spent := cpu_seconds() - cpu) < seconds:
            for _ in range(chunk):
                self.step()
            calls += chunk
            if spent < 0.02 * seconds:
                chunk *= 2
        steps = calls * self.steps_per_call * self.envs
        return Turn(spent / steps, (time.perf_counter() - wall) / steps)


def cpu_seconds() -> float:
    """Return the CPU time of this process, and of those that it has waited for."""
    used = (resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in used)


class Row(NamedTuple):
    """What is measured under one name: how it is made, and the unit in which it is printed."""

    group: str
    """The word for `--only`."""
    unit: str
    """A key of `UNITS`."""
    make: Callable[[], Subject]


UNITS = {
    "ns an agent-step": 1e9,
    "us a step": 1e6,
    "us a reset": 1e6,
    "ms a frame": 1e3,
    "CPU-s": 1.0,
    "bytes an arena": 1.0,
}
"""What one second, or one byte, is in each."""
