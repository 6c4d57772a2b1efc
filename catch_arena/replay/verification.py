"""R10.2: whether a match plays as it was recorded, and if not, what was altered."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from catch_arena.errors import ReplayError
from catch_arena.replay.named_requests import requests_of_step
from catch_arena.replay.quantisation import QuantisedState, quantise
from catch_arena.replay.recording import Replay
from catch_arena.replay.state_differences import first_lines, on_one_line, state_differences, state_name
from catch_arena.world import World


def verify(replay: Replay, progress: Callable[[int, int], None] | None = None) -> list[str]:
    """Play a match again and say all that does not fit; an empty list is a proof.

    A state follows from the one before. So where the digests differ from some step to the end, the match itself
    differs: an action, a setting or a rule is another one. A step whose digest differs although all later ones agree
    was altered in the file, and so was a quantised state where the digest agrees.

    With prey a match can differ for some steps alone: where prey was does not matter any more when it has been caught
    and returned. Then the numbers differ as well as the digests.

    Args:
        replay: the recorded match.
        progress: called with (steps played, steps in all).

    Returns:
        a line for each fault; where a match differs, a further line for each number that does in the first step.
    """
    found = _Findings(replay)
    before: World | None = None
    for step, engine in enumerate(replay.engines()):
        found.add(step, engine.digest(), quantise(engine.state(), replay.config))
        if before is not None:
            found.add_named(before, engine.world())
        before = engine.world() if requests_of_step(replay.named_requests, step) else None
        if progress is not None:
            progress(step, replay.steps)
    return found.lines()


@dataclass(slots=True)
class _Apart:
    """Steps, one after the other, whose digests differ."""

    first: int
    replayed: QuantisedState
    """What the first one was, played again."""
    numbers_differ: bool = False
    """Whether the numbers of any of them differ too."""


@dataclass(slots=True)
class _Findings:
    """What was seen of a match while it was played again."""

    replay: Replay
    apart: _Apart | None = None
    """The steps that differ until now."""
    rejoined: list[tuple[_Apart, int]] = field(default_factory=list)
    """Where the match differed, and from when on it plays as recorded again."""
    impossible_requests: list[str] = field(default_factory=list)
    """Requests by name that the arena would have granted."""
    altered_digests: list[int] = field(default_factory=list)
    """Steps in which only that was altered."""
    altered_numbers: list[int] = field(default_factory=list)
    first_numbers: QuantisedState = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """What the first of these steps was, played again."""

    def add(self, step: int, digest: bytes, state: QuantisedState) -> None:
        """One more state, as it was played again."""
        numbers_differ = not np.array_equal(state, self.replay.states[step])
        if digest != self.replay.digests[step]:
            self.apart = self.apart or _Apart(step, state)
            self.apart.numbers_differ |= numbers_differ
            return
        if self.apart is not None and self.apart.numbers_differ and self.replay.config.prey:
            self.rejoined.append((self.apart, step))
        elif self.apart is not None:
            self.altered_digests += range(self.apart.first, step)
        self.apart = None
        if numbers_differ:
            self.first_numbers = self.first_numbers if self.altered_numbers else state
            self.altered_numbers.append(step)

    def add_named(self, before: World, after: World) -> None:
        """What was asked for by name in one step."""
        try:
            self.replay.named_rulings(before, after)
        except ReplayError as error:
            self.impossible_requests.append(str(error))

    def lines(self) -> list[str]:
        """Each fault, and what it begins with."""
        found = self.impossible_requests[:1]
        if self.altered_digests:
            found.append(f"{_altered('digest', self.altered_digests)}: the match plays on as recorded")
        if self.altered_numbers:
            difference = on_one_line(self._differences(self.altered_numbers[0], self.first_numbers))
            found.append(f"{_altered('quantised state', self.altered_numbers)}: the digest agrees, but {difference}")
        for apart, until in self.rejoined:
            again = f"from {state_name(until)} on it plays as recorded"
            found.append(f"{state_name(apart.first)} is the first that differs; {again}")
            found += first_lines(apart.first, self._differences(apart.first, apart.replayed))
        if self.apart is not None:
            found.append(f"{state_name(self.apart.first)} is the first that differs")
            found += first_lines(self.apart.first, self._differences(self.apart.first, self.apart.replayed))
        return found

    def _differences(self, step: int, replayed: QuantisedState) -> list[str]:
        return state_differences(self.replay.config, self.replay.names, self.replay.states[step], replayed)


def _altered(what: str, steps: Sequence[int]) -> str:
    later = len(steps) - 1
    also = f", and that of {later} later {'step' if later == 1 else 'steps'}" if later else ""
    return f"{state_name(steps[0])}: its {what} was altered{also}"
