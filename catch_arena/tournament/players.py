"""The players of one match: what a match asks of them, and what they answer."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

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


class Players:
    """Agents in the seats of one match, in this process: quick, and asked one after the other. A seat that had a fault
    is not asked again.

    What they raise is their fault alone; nothing limits their time, their memory or their reach.
    `isolation.isolated_players` has further seats, whose agents are in processes of their own.

    Args:
        seated: by seat, an instance for this match, or an entrant, of which one is made; what prey says of its control
            does not matter.
        absent: the seats of those that are not made, and why.
    """

    def __init__(
        self,
        seated: Mapping[int, Policy | PreyPolicy | Entrant],
        absent: Mapping[int, Fault] = MappingProxyType({}),
    ) -> None:
        self.controls: dict[int, Control] = {
            seat: one.control if isinstance(one, Entrant) else control_of(one) for seat, one in seated.items()
        }
        """What each seat asks for."""
        self._policies: dict[int, Policy | PreyPolicy] = {}
        self._limits: Sequence[AnyLimits] = ()
        self._faults = dict(absent)
        for seat in seated.keys() - absent.keys():
            one = seated[seat]
            try:
                self._policies[seat] = one.create() if isinstance(one, Entrant) else one
            except AgentError as error:
                self._faults[seat] = Fault("FORFEIT_INIT", str(error))

    def reset(self, seeds: Sequence[int], limits: Sequence[AnyLimits]) -> dict[int, Fault]:
        """Begin a match: each seat is told its own seed.

        Returns:
            those that cannot play, by seat.
        """
        self._limits = limits
        for seat, policy in self._policies.items():
            try:
                policy.reset(seeds[seat])
            except (Exception, SystemExit) as error:  # noqa: BLE001 - a stranger's code may raise anything
                self._faults[seat] = Fault("FORFEIT_INIT", f"reset raised {reason(error)}")
        return self._faults

    def act(self, observations: Mapping[int, Observation]) -> dict[int, Answer]:
        """Ask these seats for their actions, in one step."""
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
        """End the agent of a seat that plays no further: it has forfeited, or dropped out. Nothing of it runs on."""

    def logs(self) -> dict[int, str]:
        """What seats have printed, as far as it is kept: here it goes where this process prints."""
        return {}
