"""Rounds of all subjects in turn, timed in CPU-seconds, and what is made of them."""

import dataclasses
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple


@dataclass(frozen=True)
class Work:
    """What one agent gets out of one step, so that rates can be read beside it."""

    observation_floats: int
    physics_ticks: str
    arbiter: bool


class Round(NamedTuple):
    """One turn of one subject."""

    calls: int
    cpu_s: float
    """Of all threads of this process."""
    wall_s: float


@dataclass
class Subject:
    """Something with a step to be measured."""

    group: str
    name: str
    step: Callable[[], object]
    agents: int
    """In one environment."""
    work: Work
    envs: int = 1
    steps_per_call: int = 1
    threads: int = 1
    rounds: list[Round] = field(default_factory=list)

    @property
    def env_steps(self) -> list[float]:
        """Environment steps per CPU-second, by round."""
        return [self._env_steps(one) / one.cpu_s for one in self.rounds]

    @property
    def env_steps_on_the_wall(self) -> list[float]:
        """Environment steps per second on the wall, by round."""
        return [self._env_steps(one) / one.wall_s for one in self.rounds]

    @property
    def agent_steps(self) -> float:
        """Agent-steps per CPU-second, the median of the rounds."""
        return statistics.median(self.env_steps) * self.agents

    @property
    def agent_steps_on_the_wall(self) -> float:
        """Agent-steps per second on the wall, the median of the rounds."""
        return statistics.median(self.env_steps_on_the_wall) * self.agents

    def _env_steps(self, one: Round) -> int:
        return one.calls * self.steps_per_call * self.envs

    def figures(self) -> dict[str, object]:
        """As JSON."""
        return {
            "group": self.group,
            "name": self.name,
            "envs": self.envs,
            "agents": self.agents,
            "threads": self.threads,
            **dataclasses.asdict(self.work),
            "env_steps_per_cpu_s": statistics.median(self.env_steps),
            "agent_steps_per_cpu_s": self.agent_steps,
            "agent_steps_per_s": self.agent_steps_on_the_wall,
            "env_steps_per_cpu_s_by_round": self.env_steps,
        }


def ratio(one: Sequence[float], other: Sequence[float]) -> float:
    """How many times as fast one was as the other: the median of the ratios within each round."""
    return statistics.median(a / b for a, b in zip(one, other, strict=True))


def play_round(subject: Subject, seconds: float) -> Round:
    """Call the step for about that many CPU-seconds; clocks are read rarely where a step is short."""
    calls, chunk = 0, 1
    wall, cpu = time.perf_counter(), time.process_time()
    while (spent := time.process_time() - cpu) < seconds:
        for _ in range(chunk):
            subject.step()
        calls += chunk
        if spent < 0.02 * seconds:
            chunk *= 2
    return Round(calls, spent, time.perf_counter() - wall)


def play_rounds(subjects: Sequence[Subject], rounds: int, seconds: float) -> None:
    """Subjects take turns in every round, so that a machine that slows down slows all of them; a first, unmeasured
    turn warms up.
    """
    from catch_arena.cli.progress import progress_bar

    turns = [*subjects] * (rounds + 1)
    with progress_bar("measuring", len(turns)) as show:
        for turn, subject in enumerate(turns):
            played = play_round(subject, seconds)
            if turn >= len(subjects):
                subject.rounds.append(played)
            show(turn + 1, len(turns))
