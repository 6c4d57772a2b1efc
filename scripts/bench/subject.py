"""Measured subjects: something with a step, and the timing of its turns."""

import resource
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple


@dataclass
class Subject:
    """Object with a step that is measured, made for one process."""

    step: Callable[[], object]
    agents: int = 1
    """Number of agents in one environment."""
    envs: int = 1
    floats: int = 0
    """Numbers in an agent's observation."""
    steps_per_call: int = 1
    threads: int = 1
    value: Callable[[], float] | None = None
    """Function that measures something other than time, such as bytes; None measures time."""

    def turn(self, seconds: float) -> tuple[float, float]:
        """Call the step for about `seconds` of CPU time; return the times of one step [s]: CPU time and wall time.

        CPU time is that of all threads and processes. Clocks are read rarely for a short step.
        """
        if self.value:
            return self.value(), 0.0
        calls, repeats, wall, cpu = 0, 1, time.perf_counter(), cpu_seconds()
        while (spent := cpu_seconds() - cpu) < seconds:
            for _ in range(repeats):
                self.step()
            calls += repeats
            if spent < 0.02 * seconds:
                repeats *= 2
        steps = calls * self.steps_per_call * self.envs
        return spent / steps, (time.perf_counter() - wall) / steps


def cpu_seconds() -> float:
    """Return the CPU time of this process and of its ended child processes [s]."""
    used = (resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in used)


class Row(NamedTuple):
    """Row of the results: a group, the printed unit, and a function that makes the subject."""

    group: str
    """Word that selects the row with `--only`."""
    unit: str
    """Key of `UNITS`."""
    make: Callable[[], Subject]


UNITS = {
    "ns per agent-step": 1e9,
    "us per step": 1e6,
    "us per reset": 1e6,
    "ms per frame": 1e3,
    "CPU-s": 1.0,
    "s": 1.0,
    "bytes per arena": 1.0,
}
"""Factor from seconds, or bytes, to each unit."""
