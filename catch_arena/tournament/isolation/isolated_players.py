"""Players that are isolated agents: all are asked at the same time, and each must answer within its limit."""

import json
import math
import select
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final, NamedTuple, get_args

from catch_arena.config import Control, require_choice
from catch_arena.errors import ConfigError, MatchFailedError
from catch_arena.policy import AnyLimits, Policy, PreyPolicy
from catch_arena.text import one_line, shortened
from catch_arena.tournament.entrants import Entrant, Inspection
from catch_arena.tournament.isolation import protocol
from catch_arena.tournament.isolation.sandbox import ENDED, AgentProcess, Sandbox, excerpt, exit_reason
from catch_arena.tournament.players import Fault, Move, Observation, Players

_POLL_S: Final = 0.1
"""Longest single wait [s], so that this process notices if it stood still itself."""
_STALL_S: Final = 1.0
"""Stall of this process [s] from which on no agent is blamed for being late."""
_FIRST_WAIT_S: Final = 0.05
"""Time within which most agents have answered, so that `while_waiting` need not be called [s]."""
_WAIT_S: Final = 1.0 / 60.0
"""Time between two calls of `while_waiting` [s]."""


class _Reply(NamedTuple):
    """Answer of an agent in one line, or the fault that it has instead."""

    fields: dict[str, Any]
    """JSON object in the line; empty if there is a fault."""
    seconds: float
    """Time from sending a line to reading the answer [s]."""
    fault: Fault | None = None


class IsolatedPlayers(Players):
    """Players of a match, some of them in their own processes; these are asked at the same time.

    Args:
        sandbox: starts and ends their processes.
        entrants: the entrants in their own processes, by seat.
        here: the players in this process, by seat, as in `Players`.
        absent: the faults of seats without a player, as in `Players`.
        while_waiting: called repeatedly while actions are due, to draw a window; no agent pays for the time that it
            takes. If it raises, the agents that have not answered are dropped.
    """

    def __init__(
        self,
        sandbox: Sandbox,
        entrants: Mapping[int, Entrant],
        here: Mapping[int, Policy | PreyPolicy | Entrant] = MappingProxyType({}),
        absent: Mapping[int, Fault] = MappingProxyType({}),
        while_waiting: Callable[[], None] | None = None,
    ) -> None:
        super().__init__(here, absent)
        self.controls |= {seat: entrant.control for seat, entrant in entrants.items()}
        self._sandbox = sandbox
        self._entrants = entrants
        self._while_waiting = while_waiting
        self._quotas = sandbox.quotas
        self._bank_s = dict.fromkeys(entrants, sandbox.quotas.bank_s)
        self._limit_names = {
            "init": f"init_s ({self._quotas.init_s:g} s)",
            "reset": f"what was left of init_s ({self._quotas.init_s:g} s)",
            "act": f"step_ms ({self._quotas.step_ms:g} ms) and what was left of bank_s ({self._quotas.bank_s:g} s)",
        }
        """Names of the limits that a late agent exceeds, by request; reports count faults by these words."""
        self._processes: dict[int, AgentProcess] = {}
        self._dropped: set[int] = set()

    def reset(self, seeds: Sequence[int], limits: Sequence[AnyLimits]) -> dict[int, Fault]:
        """Begin a match; all time and faults before the first view count as init."""
        here = super().reset(seeds, limits)
        faults: dict[int, Fault] = {}
        greeted = self._greet(self._entrants)
        for seat, reply in greeted.items():
            if reply.fault is not None:
                faults[seat] = reply.fault
            elif self._entrants[seat].side == "prey":  # prey cannot choose its control (R12.2)
                continue
            elif (control := reply.fields.get("control", "target")) != self.controls[seat]:
                why = f"says that its control is {shortened(control)}, and said {self.controls[seat]!r} before"
                faults[seat] = Fault("FORFEIT_INIT", why)
        lines = {seat: protocol.reset_line(seeds[seat], limits[seat]) for seat in greeted if seat not in faults}
        left_s = {seat: max(0.0, self._quotas.init_s - greeted[seat].seconds) for seat in lines}
        for seat, reply in self._exchange(lines, left_s, "reset").items():
            if reply.fault is not None:
                faults[seat] = reply.fault
        return here | {seat: replace(fault, code="FORFEIT_INIT") for seat, fault in faults.items()}

    def act(self, observations: Mapping[int, Observation]) -> dict[int, Move]:
        """Ask these seats for their actions; all processes get their views before the first answer is read."""
        step_s, bank_s = self._quotas.step_ms / 1000.0, self._bank_s
        lines = {
            seat: protocol.view_line(*observation)
            for seat, observation in observations.items()
            if seat in self._processes
        }
        moves = super().act({seat: one for seat, one in observations.items() if seat not in self._processes})
        allowed_s = {seat: step_s + bank_s[seat] for seat in lines}
        for seat, reply in self._exchange(lines, allowed_s, "act", self._while_waiting).items():
            bank_s[seat] -= max(0.0, reply.seconds - step_s)
            fault = reply.fault
            if fault is None and "action" not in reply.fields:
                fault = Fault("FORFEIT_ILLEGAL", f"its line holds no action: {shortened(reply.fields)}")
            moves[seat] = reply.fields.get("action"), reply.seconds, fault
        return moves

    def inspect(self) -> Inspection:
        """Ask the agent in seat 0 for its control, side and sources, and end it."""
        reply = self._greet([0])[0]
        log = self.logs()[0]
        self.drop(0)
        if reply.fault is not None:
            return Inspection(fault=reply.fault.reason, log=log)
        control, sources = reply.fields.get("control", "target"), reply.fields.get("sources")
        try:
            require_choice("control", control if isinstance(control, str) else shortened(control), get_args(Control))
        except ConfigError as error:
            return Inspection(fault=str(error), log=log)
        listed = sources if isinstance(sources, list) else []  # a stranger's code may say anything
        named = tuple(one for one in listed if isinstance(one, str))
        return Inspection(control, named, None, log, reply.fields.get("prey") is True)

    def drop(self, seat: int) -> None:
        """End the agent of a seat that has stopped playing, and all processes that it started."""
        if seat in self._processes:
            self._dropped.add(seat)
            self._sandbox.end(self._entrants[seat])

    def logs(self) -> dict[int, str]:
        """Return the printed text of each seat."""
        for seat, process in self._processes.items():
            if seat not in self._dropped:
                process.read_log()
        return super().logs() | {seat: process.log.text() for seat, process in self._processes.items()}

    def _greet(self, seats: Collection[int]) -> dict[int, _Reply]:
        """Start the agents of these seats, and return their answers to the greeting."""
        for seat in seats:
            self._processes[seat] = self._sandbox.start(self._entrants[seat])
        lines = {seat: protocol.hello_line(self._entrants[seat].side) for seat in seats}
        return self._exchange(lines, dict.fromkeys(seats, self._quotas.init_s), "init")

    def _exchange(
        self,
        lines: Mapping[int, bytes],
        allowed_s: Mapping[int, float],
        doing: str,
        while_waiting: Callable[[], None] | None = None,
    ) -> dict[int, _Reply]:
        """Send each seat its line, and return the answer of each: a JSON object or a fault.

        Raises:
            MatchFailedError: if this process stood still, or an agent's process ended before any code of the agent ran.
        """
        replies: dict[int, _Reply] = {}
        sent_at: dict[int, float] = {}
        due: dict[int, float] = {}
        seat_of: dict[int, int] = {}
        poll = select.poll()
        late = Fault("FORFEIT_TIMEOUT", f"{doing} took longer than {self._limit_names[doing]}", late=True)
        now = time.monotonic()
        call_at = math.inf if while_waiting is None else now + _FIRST_WAIT_S
        waited_s = 0.0  # time in `while_waiting`, which `now` does not count
        for seat, line in lines.items():
            process = self._processes[seat]
            sent_at[seat] = sent = time.monotonic()
            if not process.write(line):
                replies[seat] = _Reply(
                    {}, 0.0, Fault("FORFEIT_TIMEOUT", f"{doing}: it does not read its lines", late=True)
                )
                continue
            due[seat] = sent + allowed_s[seat]
            for file in process.files():
                seat_of[file] = seat
                poll.register(file, select.POLLIN)
        while due:
            wait_s = min(max(0.0, min(*due.values(), call_at) - now), _POLL_S)
            events = poll.poll(math.ceil(1000.0 * wait_s))
            before, now = now, time.monotonic() - waited_s
            if now - before > wait_s + _STALL_S:
                raise MatchFailedError(f"this process stood still for {now - before - wait_s:.1f} s")
            for file, _ in events:
                seat = seat_of[file]
                process = self._processes[seat]
                if file == process.log_pipe:
                    if not process.read_log():
                        poll.unregister(file)
                elif (received := process.read()) is not None:
                    poll.unregister(file)
                    reply = _parse(doing, received, now - sent_at[seat], process)
                    in_time = now <= due.pop(seat) or reply.fault is not None
                    replies[seat] = reply if in_time else _Reply({}, reply.seconds, late)
            for seat in [seat for seat, end in due.items() if now > end]:
                del due[seat]
                poll.unregister(self._processes[seat].answer_pipe)  # later answers are too late
                replies[seat] = _Reply({}, now - sent_at[seat], late)
            if while_waiting is not None and due and now >= call_at:
                try:
                    while_waiting()
                except BaseException:
                    for seat in due:
                        self.drop(seat)
                    raise
                waited_s = time.monotonic() - now
                call_at = now + _WAIT_S
        for seat, reply in replies.items():
            if reply.fault is ENDED:
                why = self._end_of_process(seat)
                replies[seat] = _Reply({}, reply.seconds, Fault("FORFEIT_CRASH", f"{doing}: {why}"))
        return replies

    def _end_of_process(self, seat: int) -> str:
        """End an agent that closed its answers, and return in words how its process ended.

        Raises:
            MatchFailedError: if the process ended before it ran any code of the agent.
        """
        process = self._processes[seat]
        code = process.exit_code()
        self.drop(seat)
        if not process.started:
            last = process.log.last_line() or "it printed nothing"
            raise MatchFailedError(f"the process of {self._entrants[seat].name} could not start: {last}")
        return exit_reason(code, process.log)


def _parse(doing: str, received: bytes | Fault, seconds: float, process: AgentProcess) -> _Reply:
    """Return an agent's line as a reply; a line that is no JSON object, or that holds an error, is a fault."""
    if isinstance(received, Fault):
        return _Reply({}, seconds, received)
    try:
        fields = json.loads(received)
    except (ValueError, RecursionError):
        fields = None
    if not isinstance(fields, dict):
        return _Reply({}, seconds, Fault("FORFEIT_ILLEGAL", f"its line is no JSON object: {excerpt(received)}"))
    if "ended" in fields:  # our program reports the end of the process that it forked for the match
        process.read_log()
        why = exit_reason(fields["ended"], process.log)
        return _Reply({}, seconds, Fault("FORFEIT_CRASH", f"{doing}: {why}"))
    if "error" in fields:
        why = fields["error"]
        return _Reply({}, seconds, Fault("FORFEIT_CRASH", one_line(why if isinstance(why, str) else shortened(why))))
    return _Reply(fields, seconds)


@contextmanager
def isolated_players(sandbox: Sandbox, *seated: Any) -> Iterator[IsolatedPlayers]:
    """Make `IsolatedPlayers` for one match, and end all that they started when it is over."""
    try:
        yield IsolatedPlayers(sandbox, *seated)
    except BaseException:
        sandbox.close()  # the next match must not meet processes of this one
        raise
    sandbox.clear()
