"""Rulebook R10.2: recorded matches: header, seed and actions, with a digest of every state."""

import os
from bisect import insort
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields
from html import escape
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from catch_arena.arbitration import arbitrate
from catch_arena.config import ArenaConfig
from catch_arena.core.random import kill_service_down
from catch_arena.engine import Engine
from catch_arena.equality import EqualByBits
from catch_arena.errors import OutputError, ReplayError
from catch_arena.files import write_whole
from catch_arena.replay.named_requests import NamedRequest, describe_name, requests_of_step
from catch_arena.text import with_type
from catch_arena.verdicts import Ruling, Verdict
from catch_arena.world import World

_FOR_A_RANK: Final = (Verdict.GRANTED, Verdict.LOST_CONTEST, Verdict.KILL_FAILED, Verdict.WAITING_FOR_PARTNER)
"""Verdicts on targets in reach. Those are always in view (R7.5), so they have a rank, and no request by name."""


@dataclass(slots=True, eq=False)
class Replay(EqualByBits):
    """One recorded match, or its part played so far. Two replays are equal if they agree in every bit."""

    config: ArenaConfig
    seed: int
    names: tuple[str, ...]
    """Names of the agents: of the hunters by seat, and then of the prey by index."""
    title: str = ""
    choices: list[NDArray[np.int64]] = field(default_factory=list)
    """Ranks that the hunters chose in each step: (H,)."""
    commands: list[NDArray[np.float32]] = field(default_factory=list)
    """Velocity commands of all agents in each step, of the hunters by seat and then of the prey: (H + P, 2)."""
    digests: list[bytes] = field(default_factory=list)
    """A.8: digests of the states after the reset and after each step."""
    withdrawals: list[tuple[int, int]] = field(default_factory=list)
    """R1.6, R12.5: withdrawals as (number of steps before it, agent); an agent is an index in `names`."""
    named_requests: list[NamedRequest] = field(default_factory=list)
    """R8.4: requests by name without a rank in the action, in their order."""
    colors: tuple[int, ...] = ()
    """Number of each hunter's colour, by seat, which a tournament gives to its agents; empty if colours go by seat."""

    html_formatter: ClassVar[Callable[["Replay"], str] | None] = None
    """Function that returns a replay's HTML for notebooks; importing `catch_arena.player` sets it. None before that."""

    @property
    def hunter_names(self) -> tuple[str, ...]:
        """Names of the hunters' agents, by seat."""
        return self.names[: self.config.hunters]

    @property
    def prey_names(self) -> tuple[str, ...]:
        """Names of the prey's agents, by index."""
        return self.names[self.config.hunters :]

    @property
    def steps(self) -> int:
        """Number of steps played."""
        return len(self.choices)

    @property
    def duration_ms(self) -> int:
        """Duration of the steps played [ms]."""
        return self.steps * self.config.control_period_ms

    def action(self, step: int, agent: int) -> str:
        """Return an agent's action in a step, counted from 0, in words; nine digits distinguish all float32 numbers.

        Args:
            step: number of steps played before.
            agent: index in `names`.
        """
        linear, angular = self.commands[step][agent].tolist()
        commanded = f"linear {linear:+.9g} and angular {angular:+.9g} of the limits"
        if agent >= self.config.hunters or self.config.controls[agent] == "velocity":
            return commanded
        rank = int(self.choices[step][agent])
        if self.config.controls[agent] == "target":
            return f"rank {rank}" if rank else "hold"
        named = requests_of_step(self.named_requests, step)  # R8.4
        requests = [describe_name(request.name) for request in named if request.seat == agent]
        requests += [f"rank {rank}"] if rank else []
        return f"{commanded}, catch {', '.join(requests) or 'nothing'}"

    def withdrawn_before(self, step: int) -> list[int]:
        """Return the agents that were withdrawn after `step` steps, as indices in `names`."""
        return [agent for before, agent in self.withdrawals if before == step]

    def append(
        self,
        choices: NDArray[np.int64],
        commands: NDArray[np.float32],
        engine: Engine,
    ) -> None:
        """Record one more step: its actions, which are copied, and the state after it.

        Args:
            choices: the hunters' ranks, (H,).
            commands: the velocity commands of the hunters and then of the prey, (H + P, 2).
            engine: the engine; its first arena is recorded.
        """
        self.choices.append(choices.copy())
        self.commands.append(commands.copy())
        self.digests.append(engine.digest())

    def copy(self) -> "Replay":
        """Return a copy of the match so far; steps appended to one of the two do not appear in the other."""
        values = (getattr(self, attribute.name) for attribute in fields(self))
        copied: list[Any] = [value.copy() if isinstance(value, list) else value for value in values]
        return Replay(*copied)

    def engines(self) -> Iterator[Engine]:
        """Play the match again without checks; yield the same engine at every step's boundary, steps + 1 times."""
        engine = Engine(self.config)
        engine.reset([self.seed])
        yield engine
        for step in range(self.steps):
            for agent in self.withdrawn_before(step):
                engine.withdraw(0, agent)
            engine.step(self.choices[step][None], self.commands[step][None])
            yield engine

    def worlds(self) -> Iterator[World]:
        """Play the match again; yield the world at every step's boundary, steps + 1 worlds, each checked by its digest.

        Raises:
            ReplayError: if a state differs; it names the first such step.
        """
        return (engine.world() for engine in self.checked_engines())

    def checked_engines(self) -> Iterator[Engine]:
        """Play the match again; yield the engine as `engines` does, each state checked by its digest.

        Raises:
            ReplayError: if a state differs; it names the first such step.
        """
        for step, engine in enumerate(self.engines()):
            if engine.digest() != self.digests[step]:
                raise ReplayError(
                    f"the replay does not play as it was recorded: the states first differ in {state_name(step)}"
                )
            yield engine

    def judged_steps(self) -> Iterator[tuple[World, World, list[Ruling]]]:
        """Play the match again, each state checked; yield for each step the world before it, the world after it, and
        the rulings on requests by name (R8.4), which `rulings` of the world after it lacks.

        Raises:
            ReplayError: if a state differs; it names the first such step.
        """
        appeared: set[str] = set()
        for before, after in pairwise(self.worlds()):
            appeared.update(target.name for target in before.targets)
            yield before, after, self._named_rulings(before, after, appeared)

    def _named_rulings(self, before: World, after: World, appeared: set[str]) -> list[Ruling]:
        requests = requests_of_step(self.named_requests, before.step)
        if not requests:
            return []
        config, step = self.config, before.step
        alive = {target.name: (target.x, target.y) for target in before.targets}
        asked = {request.name for request in requests}
        ranked = [(ruling.hunter, ruling.target) for ruling in after.rulings]
        with np.errstate(over="ignore"):  # the hashes of A.5 are arithmetic modulo 2^64
            kill_service_up = not kill_service_down(np.uint64(self.seed), step, config.faults.kill_down)
        rulings = arbitrate(
            hunters=[(hunter.x, hunter.y) for hunter in before.hunters],
            targets=alive,
            requests=[*ranked, *((request.seat, request.name) for request in requests)],
            reach_m=config.reaches,
            policy=config.policy,
            seed=self.seed,
            step=step,
            caught=list(appeared & (asked - alive.keys())),
            inactive=[seat for seat, hunter in enumerate(after.hunters) if hunter.withdrawn],
            kill_service_up=kill_service_up,
            teams=config.teams,
            hunters_per_catch=config.hunters_per_catch,
        )
        return [ruling for ruling in rulings[len(ranked) :] if ruling.verdict not in _FOR_A_RANK]

    def _repr_html_(self) -> str:
        """Return the HTML for notebooks: a player of the match, if `catch_arena.player` was imported."""
        formatter = Replay.html_formatter
        if formatter is None:
            return f"<p>A replay of {self.steps} steps; it plays here after <code>import catch_arena.player</code></p>"
        try:
            return formatter(self)
        except ReplayError as error:
            return f"<p>{escape(str(error))}</p>"

    def save(self, file: str | os.PathLike[str] | BytesIO) -> None:
        """Write the replay to a file or a BytesIO; a file appears whole or not at all.

        Raises:
            OutputError: if it cannot be written.
        """
        if not isinstance(file, str | os.PathLike | BytesIO):
            raise OutputError(f"file must be a path or a BytesIO, got {with_type(file)}")
        from catch_arena.replay.fileformat import encode_replay

        try:
            content = encode_replay(self)
        except ReplayError as error:
            raise OutputError(f"{'the replay' if isinstance(file, BytesIO) else file}: {error}") from None
        if isinstance(file, BytesIO):
            file.write(content)
        else:
            write_whole(Path(file), content)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Replay":
        """Return the replay in a file.

        Raises:
            ReplayError: if the file is not a whole replay of this ruleset or cannot be read, or `path` is no path.
        """
        from catch_arena.replay.fileformat import LARGEST_FILE, decode_replay

        if not isinstance(path, str | os.PathLike):
            raise ReplayError(f"path must be a string or a Path, got {with_type(path)}")
        try:
            with Path(path).open("rb") as file:
                content = file.read(LARGEST_FILE + 1)
        except (OSError, ValueError) as error:  # ValueError: a path with a zero byte
            raise ReplayError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
        try:
            return decode_replay(content)
        except ReplayError as error:
            raise ReplayError(f"{path}: {error}") from None


class Recorder:
    """Recorder of every episode from the reset after `record` on; before that it keeps nothing."""

    def __init__(self, config: ArenaConfig) -> None:
        self._config = config
        self._names_and_title: tuple[tuple[str, ...], str] | None = None
        self.replay: Replay | None = None
        """Replay of the episode so far; None if it is not recorded."""

    def record(self, names: Sequence[str], title: str) -> None:
        """Record the following episodes; raise ConfigError for names or a title that a replay cannot have."""
        from catch_arena.replay.fileformat import checked_names, checked_text

        called = checked_names(names, self._config)
        self._names_and_title = called, checked_text("title", title)

    def begin(self, seed: int, engine: Engine) -> None:
        """Note that an episode has begun."""
        self.replay = None
        if self._names_and_title is not None:
            self.replay = Replay(self._config, seed, *self._names_and_title)
            self.replay.digests.append(engine.digest())

    def withdraw(self, row: int) -> None:
        """Note that an agent was withdrawn: `row` is a hunter's seat, or the number of hunters plus prey's index."""
        if self.replay is not None:
            insort(self.replay.withdrawals, (self.replay.steps, row))  # agents can be withdrawn in any order

    def __deepcopy__(self, memo: object) -> "Recorder":
        """Return an independent copy."""
        twin = Recorder(self._config)
        twin._names_and_title = self._names_and_title
        twin.replay = None if self.replay is None else self.replay.copy()
        return twin


def state_name(step: int) -> str:
    """Return the name of the state after `step` steps."""
    return "the initial state" if step == 0 else f"step {step}"
