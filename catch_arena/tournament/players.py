"""The players of one match: what a match asks of them and what they answer, and those that play in this process.

Those in processes of their own are in isolation/.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal, Protocol

from catch_arena.config import Control
from catch_arena.errors import AgentError, reason
from catch_arena.policy import AnyLimits, Policy, PreyPolicy, control_of
from catch_arena.tournament.entrants import Entrant

ForfeitCode = Literal["FORFEIT_CRASH", "FORFEIT_TIMEOUT", "FORFEIT_ILLEGAL", "FORFEIT_INIT", "FORFEIT_OUT"]
"""Kinds of failure: an agent raises or dies; it takes too long; its answer is no legal action; it cannot begin; it has
failed in too many matches in a row, and is not started any more.
"""


@dataclass(frozen=True, slots=True)
class Fault:
    """Why one seat cannot go on."""

    code: ForfeitCode
    reason: str
    """One line for people."""
    late: bool = False
    """True if the seat was too slow."""


# plain tuples: a trusted match makes thousands of them
Observation = tuple[list[float], list[int]]
"""What a seat is shown in a step: R7.1's or R12.4's vector, and R7.2's mask, which not every seat has (empty then)."""
Answer = tuple[Any, float, Fault | None]
"""What it makes of that: its action, unchecked (None where there is a fault), how long that took [s], and its fault."""


class Players(Protocol):
    """Agents in the seats of one match; a seat that had a fault is not asked again."""

    @property
    def controls(self) -> Mapping[int, Control]:
        """What each seat asks for."""

    def reset(self, seeds: Sequence[int], limits: Sequence[AnyLimits]) -> dict[int, Fault]:
        """Begin a match: each seat is told its own seed.

        Returns:
            those that cannot play, by seat.
        """

    def act(self, observations: Mapping[int, Observation]) -> dict[int, Answer]:
        """Ask these seats for their actions, in one step."""

    def drop(self, seat: int) -> None:
        """End the agent of a seat that plays no further: it has forfeited, or dropped out."""

    def logs(self) -> dict[int, str]:
        """What seats have printed, as far as it is kept."""


class TrustedPlayers:
    """Agents in this process: quick, and asked one after the other. What they raise is their fault alone; nothing
    limits their time, their memory or their reach.

    Args:
        policies: by seat; what prey says of its control does not matter.
    """

    def __init__(self, policies: Mapping[int, Policy | PreyPolicy]) -> None:
        self.controls: dict[int, Control] = {seat: control_of(policy) for seat, policy in policies.items()}
        self._policies = dict(policies)
        self._limits: Sequence[AnyLimits] = ()
        self._faults: dict[int, Fault] = {}

    @classmethod
    def of(
        cls, entrants: Mapping[int, Entrant], absent: Mapping[int, Fault] = MappingProxyType({})
    ) -> "TrustedPlayers":
        """Return a fresh instance of each entrant, by seat; one that cannot be made forfeits.

        Args:
            entrants: by seat.
            absent: the seats of those that are not made, and why.
        """
        players = cls({})
        players.controls = {seat: entrant.control for seat, entrant in entrants.items()}
        players._faults = dict(absent)
        for seat in entrants.keys() - absent.keys():
            try:
                players._policies[seat] = entrants[seat].create()
            except AgentError as error:
                players._faults[seat] = Fault("FORFEIT_INIT", str(error))
        return players

    def reset(self, seeds: Sequence[int], limits: Sequence[AnyLimits]) -> dict[int, Fault]:
        """Begin a match."""
        self._limits = limits
        for seat, policy in self._policies.items():
            try:
                policy.reset(seeds[seat])
            except (Exception, SystemExit) as error:  # noqa: BLE001 - a stranger's code may raise anything
                self._faults[seat] = Fault("FORFEIT_INIT", f"reset raised {reason(error)}")
        return self._faults

    def act(self, observations: Mapping[int, Observation]) -> dict[int, Answer]:
        """Ask these seats for their actions."""
        answers: dict[int, Answer] = {}
        policies, all_limits, clock = self._policies, self._limits, time.perf_counter
        for seat, (vector, mask) in observations.items():
            view = all_limits[seat].view(vector, mask)
            begin = clock()
            try:
                action = policies[seat].act(view)  # type: ignore[arg-type]  # a seat's limits make its side's view
            except (Exception, SystemExit) as error:  # noqa: BLE001 - a stranger's code may raise anything
                fault = Fault("FORFEIT_CRASH", f"act raised {reason(error)}")
                answers[seat] = None, clock() - begin, fault
            else:
                answers[seat] = action, clock() - begin, None
        return answers

    def drop(self, seat: int) -> None:
        """Nothing of it runs on."""

    def logs(self) -> dict[int, str]:
        """What agents print here goes where this process prints."""
        return {}


class CompositePlayers:
    """Players of several kinds in one match, each kind in seats of its own."""

    def __init__(self, parts: Sequence[Players]) -> None:
        self.controls = {seat: control for part in parts for seat, control in part.controls.items()}
        self._part_of = {seat: part for part in parts for seat in part.controls}
        self._parts = parts

    def reset(self, seeds: Sequence[int], limits: Sequence[AnyLimits]) -> dict[int, Fault]:
        """Begin a match."""
        return {seat: fault for part in self._parts for seat, fault in part.reset(seeds, limits).items()}

    def act(self, observations: Mapping[int, Observation]) -> dict[int, Answer]:
        """Ask these seats for their actions, one kind after the other."""
        answers: dict[int, Answer] = {}
        for part in self._parts:
            answers |= part.act({seat: one for seat, one in observations.items() if seat in part.controls})
        return answers

    def drop(self, seat: int) -> None:
        """The seat has forfeited."""
        self._part_of[seat].drop(seat)

    def logs(self) -> dict[int, str]:
        """What seats have printed."""
        return {seat: log for part in self._parts for seat, log in part.logs().items()}
