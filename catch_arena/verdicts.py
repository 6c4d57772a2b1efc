"""Rulebook R5.2: verdicts of the arbiter, and rulings, which add the evidence."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Final


class Verdict(IntEnum):
    """R5.2: the twelve answers to a request; the first test that fails gives the verdict.

    The tests have the order of the numbers, except that WAITING_FOR_PARTNER is tested after OUT_OF_REACH.

    The `catch_turtle` response of ROS has one bit for them: its `success` is `verdict is Verdict.GRANTED`.
    """

    MATCH_OVER = 1, "the match is over", "R5.2"
    MALFORMED = 2, "the requested name cannot be a target's name", "R5.2"
    HUNTER_INACTIVE = 3, "the hunter is withdrawn", "R1.6"
    DUPLICATE = 4, "the hunter has already requested in this step, and the first request stands", "R5.2"
    UNKNOWN_TARGET = 5, "no such target was ever spawned", "R5.2"
    ALREADY_CAUGHT = 6, "the target was caught earlier", "R5.8"
    SERVICE_DOWN = 7, "the kill service is down in this step", "R5.7"
    OUT_OF_REACH = 8, "the target is out of reach", "R5.3"
    LOST_CONTEST = 9, "another hunter in reach of the same target was preferred", "R5.6"
    KILL_FAILED = 10, "the hunter won the target, but the simulator refused the kill", "R5.7"
    GRANTED = 11, "caught", "R5.4"
    WAITING_FOR_PARTNER = 12, "too few hunters of its team asked for the target in this step", "R5.10"

    clause: str
    """Clause of the rulebook that the verdict follows from."""
    reason: str
    """Verdict in words, with its clause."""

    def __new__(cls, number: int, meaning: str = "", clause: str = "") -> "Verdict":
        """Return the verdict of a row of the table above; `Verdict(number)` finds it again."""
        verdict = int.__new__(cls, number)
        verdict._value_, verdict.clause, verdict.reason = number, clause, f"{meaning} ({clause})"
        return verdict


NO_REQUEST: Final = 0
"""Entry in a table of verdicts for a hunter without a request."""


@dataclass(frozen=True, slots=True)
class Ruling:
    """R5.6: one request's verdict with its evidence."""

    verdict: Verdict
    hunter: int
    """Seat of the hunter that made the request."""
    target: object
    """Requested name, as it was given; None for a rank that has no target."""
    distance_um: int | None = None
    """Distance between the centres [micrometres] (R5.3); None unless reach was tested."""
    winner: int | None = None
    """Seat of the hunter that won; None unless the request was granted or contested."""
    step: int = 0
    """Step in which the request was judged, from 0: the number of steps before it. Pages and commands count from 1."""

    @classmethod
    def of_numbers(
        cls, verdict: float, hunter: int, target: object, distance_um: float, winner: float, step: int
    ) -> "Ruling":
        """Return a ruling from the arbiter's numbers, in which -1 stands for no distance or no winner."""
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
        """R5.2: answer of the `catch_turtle` service."""
        return self.verdict is Verdict.GRANTED

    @property
    def reason(self) -> str:
        """Verdict in words, with its clause."""
        return self.verdict.reason

    def __str__(self) -> str:
        """Return one line for people: hunter, target, verdict and evidence."""
        evidence = "" if self.distance_um is None else f", {self.distance_um / 1e6:.6f} m away"
        if self.verdict is Verdict.LOST_CONTEST:
            evidence += f", won by hunter_{self.winner}"
        return f"hunter_{self.hunter} asked for {self.target}{evidence}: {self.verdict.name}, {self.reason}"
