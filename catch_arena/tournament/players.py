"""Players of one match: their interface, and the players in this process."""

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
"""Kinds of failure, in this order: the agent raises or dies; it takes too long; its answer is no legal action; it
cannot begin; it has failed in too many matches in a row, and is not started any more.
"""


@dataclass(frozen=True, slots=True)
class Fault:
    """Reason for which a seat cannot go on."""

    code: ForfeitCode
    reason: str
    """Reason in one line."""
    late: bool = False
    """True if the seat was too slow."""
    log: str = ""
    """Output of an agent that was not started in this match."""


# plain tuples: a trusted match makes thousands of them
Observation = tuple[list[float], list[int]]
"""Observation of a seat in a step: the vector of R7.1 or R12.4, and the mask of R7.2; empty if the seat has none."""
Move = tuple[Any, float, Fault | None]
"""Answer of a seat: action, unchecked (None if there is a fault); time taken [s]; fault (None if there is none)."""


class Players:
    """Players of one match in this process: fast, and asked one after the other.

    A seat that had a fault is not asked again. An agent that raises harms only itself. Nothing limits the agents' time,
    memory or access. `isolation.isolated_players` adds seats whose agents are in their own processes.

    Args:
        seated: by seat, an instance for this match, or an entrant, of which an instance is made; the control of prey
            is ignored.
        absent: faults of the seats for which no instance is made, by seat.
    """

    def __init__(
        self,
        seated: Mapping[int, Policy | PreyPolicy | Entrant],
        absent: Mapping[int, Fault] = MappingProxyType({}),
    ) -> None:
        self.controls: dict[int, Control] = {
            seat: one.control if isinstance(one, Entrant) else control_of(one) for seat, one in seated.items()
        }
        """Control of each seat."""
        self._policies: dict[int, Policy | PreyPolicy] = {}
        self._limits: Sequence[AnyLimits] = ()
        self._absent = dict(absent)
        for seat in seated.keys() - absent.keys():
            one = seated[seat]
            try:
                self._policies[seat] = one.create() if isinstance(one, Entrant) else one
            except AgentError as error:
                self._absent[seat] = Fault("FORFEIT_INIT", str(error))

    def reset(self, seeds: Sequence[int], limits: Sequence[AnyLimits]) -> dict[int, Fault]:
        """Begin a match, with a seed for each seat.

        Returns:
            The faults of seats that cannot play, by seat.
        """
        self._limits = limits
        for seat, policy in self._policies.items():
            try:
                policy.reset(seeds[seat])
            except (Exception, SystemExit) as error:  # noqa: BLE001 - a stranger's code may raise anything
                self._absent[seat] = Fault("FORFEIT_INIT", f"reset raised {reason(error)}")
        return self._absent

    def act(self, observations: Mapping[int, Observation]) -> dict[int, Move]:
        """Return the answers of these seats in one step."""
        moves: dict[int, Move] = {}
        policies, all_limits, clock = self._policies, self._limits, time.perf_counter
        for seat, (vector, mask) in observations.items():
            view = all_limits[seat].view(vector, mask)
            begin = clock()
            try:
                action = policies[seat].act(view)  # type: ignore[arg-type]  # a seat's limits make its side's view
            except (Exception, SystemExit) as error:  # noqa: BLE001 - a stranger's code may raise anything
                fault = Fault("FORFEIT_CRASH", f"act raised {reason(error)}")
                moves[seat] = None, clock() - begin, fault
            else:
                moves[seat] = action, clock() - begin, None
        return moves

    def drop(self, seat: int) -> None:
        """End the agent of a seat that forfeited or dropped out; no process of it is left."""

    def logs(self) -> dict[int, str]:
        """Return the printed text by seat, of absent agents only: the others print to this process's own output."""
        return {seat: fault.log for seat, fault in self._absent.items() if fault.log}
