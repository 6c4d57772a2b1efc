"""Playing a case in an arena: those about spawning, time and identity, and those for arbiters that can be staged."""

import operator
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

from catch_arena.config import TURTLESIM_SIDE_M
from catch_arena.conformance.answers import Difference, DiffersError, answered, shown
from catch_arena.conformance.cases import ArbiterCase, Asked, Beat, Lot, WorldCase
from catch_arena.conformance.comparison import Call, Strictness, compare, rulings
from catch_arena.verdicts import Verdict


class ArenaUnderTest(Protocol):
    """What an adjudicator with an arena offers, so that cases about spawning, time and identity can be played on it.

    Targets are named by their spawn numbers here. Hunters are under full control (R4.4) and stand still unless driven.
    """

    def reset(self, settings: Mapping[str, Any], /) -> None:
        """Begin an episode, with any seed.

        Args: `settings`, as in ArenaConfig, of a turtlesim arena with one hunter, no initial targets and no spawns
        unless they say so; and which services fail when: `kill_down`, a list of steps, from 0; `kill_refused`, of
        [step, number]; `spawn_down`, of firings, from 1; `spawn_refused`, of numbers.
        """

    def place(self, hunters: Sequence[tuple[float, float, float]], targets: Sequence[tuple[float, float]], /) -> None:
        """Put the hunters at rest at these poses (x, y, theta), and these targets in an arena that has none: they take
        the next numbers, in their order.
        """

    def withdraw(self, seat: int, /) -> None:
        """R1.6: the hunter takes no further part."""

    def step(
        self, requests: Sequence[tuple[int, int]], drive: Mapping[int, tuple[float, float]], /
    ) -> Sequence[object]:
        """Play one control period.

        Args: `requests`, (seat, number), at most one a seat, where the number 0 is a rank without a target; `drive`, (v
        [m/s], w [rad/s]) by seat.
        Returns: one ruling for each request, as of an arbiter, with the number that was asked for as its target. After
        the end nothing moves, and all are MATCH_OVER.
        """

    def read(self) -> Mapping[str, object]:
        """What stands in the arena: `time_ms`; `alive`, numbers in spawning order; `appeared_ms`, their times;
        `spawned`, how many appeared so far; `skipped_full`, `skipped_down` and `refused`, firings that had no target;
        `scores` by seat; `ended`, "", "terminated" or "truncated".
        """


@dataclass(frozen=True, slots=True)
class OtherReading(Difference):
    """Something else than expected stands in an arena."""

    right: Any
    found: Any


def can_be_staged(case: ArbiterCase) -> bool:
    """Whether hunters in an arena can ask what the case asks: once each, by rank, for targets that they see."""
    seats = [one.hunter for one in case.asked]
    return (
        len(case.hunters) > 0
        and len(seats) == len(set(seats))
        and not case.circumstances["match_over"]
        and all(isinstance(one.name, str) and one.name in case.targets for one in case.asked)
        and all(one.verdict is not Verdict.MALFORMED for one in case.asked)
        and all(0 <= x <= TURTLESIM_SIDE_M >= y >= 0 for x, y in (*case.hunters, *case.targets.values()))
    )


class Stage:
    """One arena on trial with one case."""

    def __init__(self, arena: ArenaUnderTest, strictness: Strictness) -> None:
        self._arena = arena
        # the arena's seed is its own, so nobody can have worked its lots out
        self._strictness = replace(strictness, exact_lots=False)
        self.how = ""
        """Which part of the case is being played."""
        self.calls: list[Call] = []
        """What it has ruled so far."""

    def play(self, case: ArbiterCase | WorldCase) -> None:
        """Raises: DiffersError, at the first part of the play that goes otherwise."""
        self.how = "in an arena"
        if isinstance(case, ArbiterCase):
            self._stage(case)
            return
        answered("reset", self._arena.reset, case.settings)
        for count, beat in enumerate(case.play, start=1):
            self.how = f"in an arena, part {count} of {len(case.play)}"
            self._play_beat(case, beat)

    def _stage(self, case: ArbiterCase) -> None:
        """An arbiter's case, and what must stand in the arena after it."""
        number_of = {name: number for number, name in enumerate(case.targets, start=1)}
        circumstances = case.circumstances
        refused = [number_of[name] for name in circumstances["kill_refused"] if name in number_of]
        settings: dict[str, Any] = {
            "hunters": len(case.hunters),
            "max_targets": max(1, len(case.targets)),
            "reach_m": circumstances["reach_m"],
            "policy": circumstances["policy"],
            "kill_down": [] if circumstances["kill_service_up"] else [0],
            "kill_refused": [[0, number] for number in refused],
        }
        poses = [(x, y, 0.0) for x, y in case.hunters]
        answered("reset", self._arena.reset, settings)
        answered("place", self._arena.place, poses, list(case.targets.values()))
        for seat in circumstances["inactive"]:
            answered("withdraw", self._arena.withdraw, seat)
        asked = tuple(replace(one, name=number_of[str(one.name)]) for one in case.asked)
        lots = tuple(replace(lot, target=number_of[str(lot.target)]) for lot in case.lots)
        decided = self._judge(asked, {}, lots, refused, case)
        granted = [one for one in decided if one.verdict is Verdict.GRANTED]
        gone = {one.name for one in granted} - set(refused)
        expected = {
            "alive": [number for number in number_of.values() if number not in gone],
            "scores": [sum(one.hunter == seat for one in granted) for seat in range(len(case.hunters))],
        }
        answered("read", self._require_readings, expected)

    def _play_beat(self, case: WorldCase, beat: Beat) -> None:
        if beat.reset:
            answered("reset", self._arena.reset, case.settings)
        if beat.hunters is not None:
            answered("place", self._arena.place, beat.hunters, beat.targets)
        if beat.withdraw is not None:
            answered("withdraw", self._arena.withdraw, beat.withdraw)
        for _ in range(beat.steps):
            answered("step", self._arena.step, [], {})
        if beat.asked is not None:
            self._judge(beat.asked, beat.drive)
        answered("read", self._require_readings, beat.read)

    def _judge(
        self,
        asked: Sequence[Asked],
        drive: Mapping[int, tuple[float, float]],
        lots: Sequence[Lot] = (),
        refused: Sequence[int] = (),
        case: ArbiterCase | None = None,
    ) -> tuple[Asked, ...]:
        requests = [(one.hunter, operator.index(one.name)) for one in asked]  # type: ignore[arg-type]
        given = rulings(lambda: self._arena.step(requests, drive), asked)
        if case is not None:
            self.calls.append(Call(case.arguments(), tuple(map(_named, given, asked, case.asked))))
        return compare(given, asked, lots=lots, refused=refused, strictness=self._strictness)

    def _require_readings(self, expected: Mapping[str, Any]) -> None:
        found = self._arena.read() if expected else {}
        differences: list[Difference] = []
        for word, value in expected.items():
            got = found.get(word) if isinstance(found, Mapping) else None
            if isinstance(got, Iterable) and not isinstance(got, str):
                got = list(got)
            if got != value:
                differences.append(OtherReading(word, repr(value), shown(got), value, got))
        if differences:
            raise DiffersError(*differences)


def _named(ruling: Asked, asked: Asked, named: Asked) -> Asked:
    """A ruling on a request by number as one on the same request by name."""
    return replace(ruling, name=named.name) if ruling.name == asked.name else ruling
