"""Play of a case in an arena: cases about spawning, time and identity, and the arbiter's cases that fit into one."""

import operator
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol

from msgspec.structs import replace

from catch_arena.config import TURTLESIM_SIDE_M
from catch_arena.conformance.adjudicator_calls import Difference, DiffersError, call_adjudicator
from catch_arena.conformance.cases import ArbiterCase, ArenaCase, CaseStep, ExpectedRuling, Lot
from catch_arena.conformance.comparison import Compared, compare, decide_lots, request_rulings
from catch_arena.text import shortened
from catch_arena.verdicts import Verdict


class ArenaUnderTest(Protocol):
    """Interface of an adjudicator with an arena, on which cases about spawning, time and identity can be played.

    Targets are named by their spawn numbers here. Hunters are under full control (R4.4) and stand still unless driven.
    """

    def reset(self, settings: Mapping[str, Any], /) -> None:
        """Begin an episode, with any seed.

        Args:
            settings: fields of ArenaConfig. By default the arena is turtlesim's, with one hunter, no initial targets
                and no spawns. Teams are a list of lists of seats. Lists of failures: `kill_down`, steps from 0;
                `kill_refused`, [step, number]; `spawn_down`, firings from 1; `spawn_refused`, numbers; `drop_outs`,
                [step, seat].
        """

    def place(self, hunters: Sequence[tuple[float, float, float]], targets: Sequence[tuple[float, float]], /) -> None:
        """Put the hunters at rest at these poses (x, y, theta), and add these targets; prey stays where it is.

        The arena has no other targets than prey's. The new targets take the next numbers, in their order.
        """

    def withdraw(self, seat: int, /) -> None:
        """R1.6: withdraw a hunter from the episode."""

    def withdraw_prey(self, index: int, /) -> None:
        """R12.5: withdraw a prey from the episode."""

    def step(
        self,
        requests: Sequence[tuple[int, int]],
        drive: Mapping[int, tuple[float, float]],
        prey: Mapping[int, tuple[float, float]] = ...,
        /,
    ) -> Sequence[object]:
        """Play one control period.

        Args:
            requests: (seat, number), at most one per seat; the number 0 is a rank without a target.
            drive: (v [m/s], w [rad/s]) by seat.
            prey: (v [m/s], w [rad/s]) by index, given only in cases that have prey; prey without an entry stands still.

        Returns:
            one ruling for each request, as an arbiter returns it, with the requested number as its target. After the
            end nothing moves, and all rulings are MATCH_OVER.
        """

    def read(self) -> Mapping[str, object]:
        """Return the arena's state by name, with at least the following keys.

        `time_ms`; `alive`, numbers in spawning order; `appeared_ms`, the times of the alive targets; `spawned`, the
        number of targets so far; `skipped_full`, `skipped_down` and `refused`, counts of firings without a target;
        `scores` by seat; `team_scores` by team, in the order of the settings; `prey`, by index the number of the
        target that it plays, 0 while it is out; `times_caught` by index; `ended`, "", "terminated" or "truncated";
        `seen` by seat, the numbers that each hunter sees, the nearest first; `rivals_seen` by seat, the seats.
        """


def fits_into_an_arena(case: ArbiterCase) -> bool:
    """Return whether the case can be played in an arena: each hunter asks once, by rank, for a target that it sees."""
    seats = [ruling.hunter for ruling in case.expected]
    return (
        len(case.hunters) > 0
        and len(seats) == len(set(seats))
        and not case.match_over
        and all(isinstance(ruling.target, str) and ruling.target in case.targets for ruling in case.expected)
        and all(ruling.verdict is not Verdict.MALFORMED for ruling in case.expected)
        and all(0 <= x <= TURTLESIM_SIDE_M >= y >= 0 for x, y in (*case.hunters, *case.targets.values()))
    )


class ArenaRunner:
    """Plays one case in an arena."""

    def __init__(self, arena: ArenaUnderTest, case: ArbiterCase | ArenaCase, compared: Compared) -> None:
        self._arena = arena
        self._case = case
        self._compared = compared
        self.variation = ""
        """Description of the part of the case that is being played."""

    def run(self) -> None:
        """Play the case part by part, and raise DiffersError at the first part that differs from it."""
        case = self._case
        self.variation = "in an arena"
        if isinstance(case, ArbiterCase):
            self._play_position(case)
            return
        call_adjudicator("reset", self._arena.reset, case.settings)
        for count, step in enumerate(case.play, start=1):
            self.variation = f"in an arena, part {count} of {len(case.play)}"
            self._play_step(case, step)

    def _play_position(self, case: ArbiterCase) -> None:
        """Play an arbiter's case, and check the alive targets and the scores after it."""
        number_of = {name: number for number, name in enumerate(case.targets, start=1)}
        refused = [number_of[name] for name in case.kill_refused if name in number_of]
        settings: dict[str, Any] = {
            "hunters": len(case.hunters),
            "max_targets": max(1, len(case.targets)),
            "reach_m": case.reach_m,
            "policy": case.policy,
            "kill_down": [] if case.kill_service_up else [0],
            "kill_refused": [[0, number] for number in refused],
        }
        if case.teams is not None:
            settings |= {"teams": case.teams, "hunters_per_catch": case.hunters_per_catch}
        poses = [(x, y, 0.0) for x, y in case.hunters]
        call_adjudicator("reset", self._arena.reset, settings)
        call_adjudicator("place", self._arena.place, poses, list(case.targets.values()))
        for seat in case.inactive:
            call_adjudicator("withdraw", self._arena.withdraw, seat)
        expected = tuple(replace(ruling, target=number_of[str(ruling.target)]) for ruling in case.expected)
        # the arena chooses its own seed, so a case cannot know which seat a lot draws
        lots = tuple(replace(lot, target=number_of[str(lot.target)], drawn=None) for lot in case.lots)
        decided = self._judge(expected, ({},), lots, refused)
        granted = [ruling for ruling in decided if ruling.verdict is Verdict.GRANTED]
        gone = {ruling.target for ruling in granted} - set(refused)
        readings = {
            "alive": [number for number in number_of.values() if number not in gone],
            "scores": [sum(ruling.hunter == seat for ruling in granted) for seat in range(len(case.hunters))],
        }
        call_adjudicator("read", self._require_readings, readings)

    def _play_step(self, case: ArenaCase, step: CaseStep) -> None:
        if step.reset:
            call_adjudicator("reset", self._arena.reset, case.settings)
        if step.hunters is not None:
            call_adjudicator("place", self._arena.place, step.hunters, step.targets)
        if step.withdraw is not None:
            call_adjudicator("withdraw", self._arena.withdraw, step.withdraw)
        if step.withdraw_prey is not None:
            call_adjudicator("withdraw_prey", self._arena.withdraw_prey, step.withdraw_prey)
        has_prey = bool(case.settings.get("prey"))
        for _ in range(step.steps):
            call_adjudicator("step", self._arena.step, [], {}, *([{}] if has_prey else []))
        if step.expected is not None:
            hunters, prey = ({one: (v, w) for one, v, w in commands} for commands in (step.drive, step.drive_prey))
            self._judge(step.expected, (hunters, prey) if has_prey else (hunters,))
        call_adjudicator("read", self._require_readings, step.read)

    def _judge(
        self,
        expected: Sequence[ExpectedRuling],
        driven: Sequence[Mapping[int, tuple[float, float]]],
        lots: Sequence[Lot] = (),
        refused: Sequence[int] = (),
    ) -> tuple[ExpectedRuling, ...]:
        requests = [(ruling.hunter, operator.index(ruling.target)) for ruling in expected]
        given = request_rulings(lambda: self._arena.step(requests, *driven), expected)
        decided = decide_lots(given, expected, lots, refused)
        if differences := compare(given, decided, self._compared):
            raise DiffersError(*differences)
        return decided

    def _require_readings(self, expected: Mapping[str, Any]) -> None:
        found = self._arena.read() if expected else {}
        differences: list[Difference] = []
        for name, value in expected.items():
            got = found.get(name) if isinstance(found, Mapping) else None
            if isinstance(got, Iterable) and not isinstance(got, str):
                got = list(got)
            if got != value:
                differences.append(Difference(name, repr(value), shortened(got)))
        if differences:
            raise DiffersError(*differences)
