"""A census: every step that can be asked in a small position, and how many verdicts of each kind that makes.

Each .toml file beside this one is a position, what may be asked in it, and the counts that the oracle found. `make
golden` counts anew; a person derives the counts from `review`, by the rulebook, before they are committed.
"""

import itertools
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from oracle.arbiter import judge
from oracle.arena import OracleArena

from catch_arena.config import ArenaConfig
from catch_arena.files import tomllib
from catch_arena.verdicts import Verdict

FOLDER = Path(__file__).parent
COUNTED = "\n# Counted by the oracle: how often each hunter gets each verdict, by seat.\n"
"""Begins the part of a file that `make golden` writes."""

Answer = tuple[int, Verdict]
"""A seat, and what it was answered."""
Counts = dict[str, Any]
"""Number of steps, and by verdict the number that each seat got."""


@dataclass(frozen=True)
class Position:
    """One file."""

    path: Path
    situation: str
    review: str
    hunters: list[tuple[float, float]]
    targets: dict[str, tuple[float, float]]
    names: list[object]
    most: int
    """Most requests of a hunter in one step, by name; by rank it is one."""
    circumstances: dict[str, Any]
    """Further arguments of `arbitrate`."""
    counts: dict[str, Counts]

    @property
    def name(self) -> str:
        return self.path.stem

    def __str__(self) -> str:
        hunters = [f"hunter {seat} at {tuple(at)}" for seat, at in enumerate(self.hunters)]
        targets = [f"{name} at {tuple(at)}" for name, at in self.targets.items()]
        return "; ".join([*hunters, *targets, *(f"{key} = {value!r}" for key, value in self.circumstances.items())])

    # by name

    def steps_by_name(self) -> list[list[tuple[int, object]]]:
        """All requests of each step, those of the lower seats first."""
        own = [one for count in range(self.most + 1) for one in itertools.product(self.names, repeat=count)]
        return [
            [(seat, name) for seat, requested in enumerate(step) for name in requested]
            for step in itertools.product(own, repeat=len(self.hunters))
        ]

    def answers_by_name(self, arbiter: Callable[..., Iterable[Any]]) -> list[list[Answer]]:
        """For each step the answers; `arbiter` takes what `arbitrate` takes."""
        case = {"hunters": self.hunters, "targets": self.targets, **self.circumstances}
        return [
            [(seat, Verdict(verdict)) for verdict, seat in arbiter(**case, requests=requests)]
            for requests in self.steps_by_name()
        ]

    # by rank, in an arena

    @property
    def in_an_arena(self) -> bool:
        """True if an arena can have this position: outages cannot be ordered there."""
        return self.circumstances.keys() <= {"policy", "seed", "inactive", "caught"}

    @property
    def config(self) -> ArenaConfig:
        """With room for a rank that has no target."""
        return ArenaConfig().replace(
            hunters=len(self.hunters),
            control="full",
            policy=self.circumstances.get("policy", "nearest"),
            initial_targets=0,
            spawn_frequency_hz=0.001,
            max_targets=len(self.targets) + 1,
            observed_targets=len(self.targets) + 1,
        )

    @property
    def poses(self) -> list[tuple[float, float, float]]:
        return [(x, y, 0.0) for x, y in self.hunters]

    @property
    def seed(self) -> int:
        return int(self.circumstances.get("seed", 0))

    @property
    def withdrawn(self) -> list[int]:
        return list(self.circumstances.get("inactive", []))

    def steps_by_rank(self) -> list[tuple[int, ...]]:
        """The ranks that are asked for, by seat; 0 asks for nothing, and the last one has no target."""
        return list(itertools.product(range(len(self.targets) + 2), repeat=len(self.hunters)))

    def answers_of_the_oracles_arena(self) -> list[list[Answer]]:
        """For each step the answers, by seat."""
        found = []
        for ranks in self.steps_by_rank():
            arena = OracleArena(self.config.to_dict())
            arena.reset(self.seed)
            arena.place(self.poses, list(self.targets.values()))
            for seat in self.withdrawn:
                arena.withdraw(seat)
            arena.step([((0.0, 0.0), rank) for rank in ranks])
            found.append([(seat, Verdict(one[0])) for seat, one in enumerate(arena.rulings) if one is not None])
        return found


def counted(answers: Sequence[Sequence[Answer]], hunters: int) -> Counts:
    """Return the number of steps, and by verdict the number of answers that each seat got."""
    tally = Counter(answer for step in answers for answer in step)
    found: Counts = {"steps": len(answers)}
    for verdict in Verdict:
        by_seat = [tally[seat, verdict] for seat in range(hunters)]
        if any(by_seat):
            found[verdict.name] = by_seat
    return found


def of_the_oracle(**case: Any) -> list[tuple[int, int]]:
    """The oracle's verdicts with their seats."""
    return [(verdict, seat) for verdict, seat, *_ in judge(**case)]


def positions() -> list[Position]:
    """Every file, by name."""
    found = []
    for path in sorted(FOLDER.glob("*.toml")):
        content = tomllib.loads(path.read_text(encoding="utf-8"))
        counts = {kind: content.pop(kind) for kind in ("by_name", "by_rank") if kind in content}
        own = {key: content.pop(key) for key in ("situation", "review", "hunters", "targets", "names", "most")}
        found.append(Position(path, **own, circumstances=content, counts=counts))
    return found


def count_anew(position: Position) -> None:
    """Write the oracle's counts into the file."""
    hunters = len(position.hunters)
    counts = {"by_name": counted(position.answers_by_name(of_the_oracle), hunters)}
    if position.in_an_arena:
        counts["by_rank"] = counted(position.answers_of_the_oracles_arena(), hunters)
    lines = [COUNTED]
    for kind, found in counts.items():
        lines += [f"\n[{kind}]\n", *(f"{key} = {value}\n" for key, value in found.items())]
    text = position.path.read_text(encoding="utf-8").partition(COUNTED)[0]
    position.path.write_text(text + "".join(lines), encoding="utf-8")


if __name__ == "__main__":
    for one in positions():
        count_anew(one)
