"""Golden matches: whole short matches as text, one line for each step and each event.

A file has inputs and outcomes. Inputs are its head, what stands before « -> » in the line of a step, and withdrawals;
all else are outcomes. `make golden` plays the inputs on the oracle and writes the outcomes anew: read the difference
before it is committed, since equal inputs that play differently need another ruleset (R10.3). To add a match, write its
inputs into a file and call `make golden`.
"""

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rulebook.adjudicators import Adjudicator, adjudicator

from catch_arena.config import ArenaConfig
from catch_arena.layout import groups
from catch_arena.scenarios import scenario

FOLDER = Path(__file__).parent
HEAD = ("about", "scenario", "settings", "seed")
STEP = re.compile(r"step (\d+): (.*?)( -> .*)?")
WITHDRAWAL = re.compile(r"withdraw hunter_(\d+)")

Input = int | list[Any]
"""The seat of a withdrawal, or the actions of a step by seat."""


@dataclass(frozen=True)
class Match:
    """The inputs of one file."""

    path: Path
    head: dict[str, str]
    inputs: list[Input]

    @property
    def config(self) -> ArenaConfig:
        return scenario(self.head["scenario"], **json.loads(self.head["settings"]))

    def lines(self, kind: str) -> Iterator[str]:
        """The whole file, as the adjudicator of that kind plays it."""
        arena = adjudicator(kind, self.config)
        arena.reset(int(self.head["seed"]))
        yield from (f"{key}: {self.head[key]}" for key in HEAD)
        yield from changes(arena, [], [0] * self.config.hunters)
        count = 0
        for one in self.inputs:
            if isinstance(one, int):
                arena.withdraw(one)
                yield f"withdraw hunter_{one}"
                continue
            alive, scores = arena.alive, arena.scores
            arena.step(*one)
            count += 1
            seats = range(self.config.hunters)
            places = " ".join("({0.x:.3f}, {0.y:.3f}, {0.theta:+.3f})".format(arena.hunter(seat)) for seat in seats)
            yield f"step {count}: {json.dumps(one)} -> {arena.time / 1000:.1f} s, {places}, {arena.digest().hex()}"
            if self.config.targets_move:
                yield "  targets at " + " ".join(f"({t.x:.3f}, {t.y:.3f}, {t.theta:+.3f})" for t in arena.targets)
            if self.config.partial_view or self.config.view_noise_m > 0:
                yield from (view(arena, seat) for seat in seats if not arena.hunter(seat).withdrawn)
            for seat, found in enumerate(arena.evidence()):
                if found is not None:
                    target = "no target" if found.number is None else f"target {found.number}"
                    away = "" if found.distance_um is None else f", {found.distance_um} um away"
                    winner = "" if found.winner is None else f", winner hunter_{found.winner}"
                    yield f"  hunter_{seat} asks for {target}{away}: {found.verdict.name}{winner}"
            yield from changes(arena, alive, scores)
        yield "end: terminated" if arena.terminated else "end: truncated" if arena.truncated else "end: not yet"


def view(arena: Adjudicator, seat: int) -> str:
    """Targets and rivals that one hunter sees, in its own frame, the nearest first."""
    numbers = arena.observation(seat)
    found = [
        " ".join(f"({numbers[at]:.3f}, {numbers[at + 1]:.3f})" for at in places if numbers[at + 2]) or "none"
        for places in (range(group.first, group.end, len(group.table._fields)) for group in groups(arena.config)[1:])
    ]
    return f"  hunter_{seat} sees targets {found[0]}, rivals {found[1]}"


def changes(arena: Adjudicator, alive: Sequence[int], scores: Sequence[int]) -> Iterator[str]:
    """Targets that left, targets that appeared, and the scores if they have changed."""
    now = {int(target.number): target for target in arena.targets}
    yield from (f"  target {number} leaves" for number in alive if number not in now)
    yield from (
        f"  target {number} appears at ({target.x:.3f}, {target.y:.3f})"
        for number, target in now.items()
        if number not in alive
    )
    if arena.scores != scores:
        yield f"  scores: {' '.join(map(str, arena.scores))}"


def read(path: Path) -> Match:
    """The inputs of a file."""
    head: dict[str, str] = {}
    inputs: list[Input] = []
    for line in path.read_text(encoding="utf-8").splitlines():
        key, colon, value = line.partition(": ")
        if colon and key in HEAD:
            head[key] = value
        elif found := WITHDRAWAL.fullmatch(line):
            inputs.append(int(found[1]))
        elif found := STEP.fullmatch(line):
            inputs.append(json.loads(found[2]))
    return Match(path, head, inputs)


def matches() -> list[Match]:
    """Every file, by name."""
    return [read(path) for path in sorted(FOLDER.glob("*.txt"))]


if __name__ == "__main__":
    for match in matches():
        match.path.write_text("".join(f"{line}\n" for line in match.lines("oracle")), encoding="utf-8")
