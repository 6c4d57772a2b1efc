"""Rulebook R5.2: the answers of the arbiter, and the evidence that comes with each."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Final


class Verdict(IntEnum):
    """R5.2: the eleven answers, in the order in which their tests are made; the first test that fails names the
    verdict.

    ROS's `catch_turtle` response has one bit for all this: its `success` is `verdict is Verdict.GRANTED`.
    """

    MATCH_OVER = 1
    MALFORMED = 2
    HUNTER_INACTIVE = 3
    DUPLICATE = 4
    UNKNOWN_TARGET = 5
    ALREADY_CAUGHT = 6
    SERVICE_DOWN = 7
    OUT_OF_REACH = 8
    LOST_CONTEST = 9
    KILL_FAILED = 10
    GRANTED = 11


NO_REQUEST: Final = 0
"""What stands in a table of verdicts for a hunter that requested nothing."""

_MEANINGS: Final = {
    Verdict.MATCH_OVER: ("the match is over", "R5.2"),
    Verdict.MALFORMED: ("the request names no target that could be", "R5.2"),
    Verdict.HUNTER_INACTIVE: ("the hunter is withdrawn", "R1.6"),
    Verdict.DUPLICATE: ("the hunter has already requested in this step, and the first request stands", "R5.2"),
    Verdict.UNKNOWN_TARGET: ("no such target was ever spawned", "R5.2"),
    Verdict.ALREADY_CAUGHT: ("the target was caught earlier", "R5.8"),
    Verdict.SERVICE_DOWN: ("the kill service is down in this step", "R5.7"),
    Verdict.OUT_OF_REACH: ("the target is out of reach", "R5.3"),
    Verdict.LOST_CONTEST: ("another hunter in reach of the same target was preferred", "R5.6"),
    Verdict.KILL_FAILED: ("nobody was preferred to it, but the simulator refused the kill", "R5.7"),
    Verdict.GRANTED: ("caught", "R5.4"),
}
CLAUSES: Final[Mapping[Verdict, str]] = {verdict: clause for verdict, (_, clause) in _MEANINGS.items()}
"""The clause that each verdict rests on."""
REASONS: Final[Mapping[Verdict, str]] = {
    verdict: f"{words} ({clause})" for verdict, (words, clause) in _MEANINGS.items()
}
"""Each verdict in words, with its clause."""


@dataclass(frozen=True, slots=True)
class Ruling:
    """R5.6: one request's verdict with its evidence."""

    verdict: Verdict
    hunter: int
    """The seat of the hunter that asked."""
    target: object
    """The name that was asked for, as it was given; None for a rank that has no target."""
    distance_um: int | None = None
    """Distance between the centres [micrometres] (R5.3); None unless reach was tested."""
    winner: int | None = None
    """The seat that won; None unless the request was granted or contested."""
    step: int = 0
    """The step in which it was judged, from 0: how many were played before it. Pages and commands count from 1."""

    @classmethod
    def of_numbers(
        cls, verdict: float, hunter: int, target: object, distance_um: float, winner: float, step: int
    ) -> "Ruling":
        """A ruling from numbers as the arbiter writes them, in which -1 is a distance or a winner that is not there."""
        return cls(
            Verdict(int(verdict)),
            hunter,
            target,
            None if distance_um < 0 else int(distance_um),
            None if winner < 0 else int(winner),
            step,
        )

    @property
    def success(self) -> bool:
        """What the `catch_turtle` service answers (R5.2)."""
        return self.verdict is Verdict.GRANTED

    @property
    def reason(self) -> str:
        """The verdict in words, with the clause it rests on."""
        return REASONS[self.verdict]

    def __str__(self) -> str:
        """One line for people: who asked for what, the answer, and the evidence."""
        evidence = "" if self.distance_um is None else f", {self.distance_um / 1e6:.6f} m away"
        if self.verdict is Verdict.LOST_CONTEST:
            evidence += f", won by hunter_{self.winner}"
        return f"hunter_{self.hunter} asked for {self.target}{evidence}: {self.verdict.name}, {self.reason}"
