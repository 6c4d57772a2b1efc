"""Players of one match: in this process, or isolated in processes of their own, which are asked at the same time."""

import math
import select
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import cache, partial
from types import MappingProxyType
from typing import Any, Final, get_args

from catch_arena.config import Control, require_choice
from catch_arena.errors import AgentError, ConfigError, MatchFailedError, reason
from catch_arena.policy import AnyLimits, Policy, PreyPolicy, control_of
from catch_arena.text import last_lines, name_fault, one_line, shortened
from catch_arena.tournament.agent_spec import AgentSpec, is_shipped, resolve, unique_names
from catch_arena.tournament.entrants import SHIPPED_PREY, Entrant
from catch_arena.tournament.isolation import protocol
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import ENDED, AgentProcess, Sandbox, excerpt, exit_reason
from catch_arena.tournament.loading import create_policy, sources_and_prey
from catch_arena.tournament.match import Fault, Move, Observation

_POLL_S: Final = 0.1
"""Longest single wait [s], so that this process notices if it stood still itself."""
_STALL_S: Final = 1.0
"""Stall of this process [s] from which on no agent is blamed for being late."""
_WAIT_S: Final = 1.0 / 60.0
"""Time between two calls of `while_waiting` [s]."""

_Reply = tuple[dict[str, Any], float, Fault | None]
"""Answer of an isolated agent: JSON object in its line (empty if there is a fault); time taken [s]; fault."""


class Players(AbstractContextManager["Players"]):
    """Players of one match. Use it as a context manager if there is a sandbox: its exit ends the match's processes.

    Do not ask a seat again that had a fault. Instances, agents that come with the package, and all agents if there
    is no sandbox, play in this process, one after the other: one that raises harms only itself, but nothing limits its
    time, memory or access. All others play in their own processes, and are asked at the same time.

    `seated` has by seat an instance for this match, or an entrant; the control of prey is ignored. `absent` has the
    faults of the seats that are not started. `while_waiting` is called repeatedly while isolated agents think, to draw
    a window; no agent pays for the time that it takes. If it raises, the agents that have not answered are dropped.
    """

    def __init__(
        self,
        seated: Mapping[int, Policy | PreyPolicy | Entrant] | Sequence[Policy | PreyPolicy | Entrant],
        sandbox: Sandbox | None = None,
        absent: Mapping[int, Fault] = MappingProxyType({}),
        while_waiting: Callable[[], None] | None = None,
    ) -> None:
        self.controls: dict[int, Control] = {}  # by seat
        self._policies: dict[int, Policy | PreyPolicy] = {}
        self._isolated: dict[int, Entrant] = {}
        self._absent = dict(absent)
        self._inspection_logs: dict[int, str] = {}
        self._limits: Sequence[AnyLimits] = ()
        for seat, one in seated.items() if isinstance(seated, Mapping) else enumerate(seated):
            self.controls[seat] = one.control if isinstance(one, Entrant) else control_of(one)
            if seat in absent:
                continue
            if not isinstance(one, Entrant):
                self._policies[seat] = one
            elif one.fault is not None:
                self._absent[seat] = Fault("FORFEIT_INIT", one.fault)
                self._inspection_logs[seat] = one.log
            elif sandbox is not None and not is_shipped(one.spec):
                self._isolated[seat] = one
            else:
                try:
                    self._policies[seat] = create_policy(one.spec, one.side)
                except AgentError as error:
                    self._absent[seat] = Fault("FORFEIT_INIT", str(error))
        self._sandbox = sandbox
        self._while_waiting = while_waiting
        self._processes: dict[int, AgentProcess] = {}
        self._quotas = Quotas() if sandbox is None else sandbox.quotas
        self._bank_s = dict.fromkeys(self._isolated, self._quotas.bank_s)

    def __exit__(self, error: object, *_: object) -> None:
        if self._sandbox is not None and self._isolated:
            # after an error the next match must not meet processes of this one
            self._sandbox.clear() if error is None else self._sandbox.close()

    def reset(self, seeds: Sequence[int], limits: Sequence[AnyLimits]) -> dict[int, Fault]:
        """Begin a match, with a seed for each seat, and return the faults of seats that cannot play, by seat.

        All time and faults before the first view count as init. A match that failed on our side raises
        MatchFailedError, also in `act`.
        """
        self._limits = limits
        for seat, policy in self._policies.items():
            try:
                policy.reset(seeds[seat])
            except (Exception, SystemExit) as error:  # noqa: BLE001 - a stranger's code may raise anything
                self._absent[seat] = Fault("FORFEIT_INIT", f"reset raised {reason(error)}")
        greeted = self._greet()
        left_s = {
            seat: max(0.0, self._quotas.init_s - took_s) for seat, (_, took_s, fault) in greeted.items() if not fault
        }
        lines = {seat: protocol.reset_line(seeds[seat], limits[seat]) for seat in left_s}
        replies = greeted | self._exchange(lines, left_s, "reset")
        faults = {seat: fault for seat, (_, _, fault) in replies.items() if fault is not None}
        return self._absent | {seat: replace(fault, code="FORFEIT_INIT") for seat, fault in faults.items()}

    def act(self, observations: Mapping[int, Observation]) -> dict[int, Move]:
        """Return the answers of these seats in one step; all processes get their views before one is read."""
        moves: dict[int, Move] = {}
        policies, all_limits, clock = self._policies, self._limits, time.perf_counter
        for seat, (vector, mask) in observations.items():
            if seat not in policies:
                continue
            view = all_limits[seat].view(vector, mask)
            begin = clock()
            try:
                action = policies[seat].act(view)  # type: ignore[arg-type]  # a seat's limits make its side's view
            except (Exception, SystemExit) as error:  # noqa: BLE001 - a stranger's code may raise anything
                fault = Fault("FORFEIT_CRASH", f"act raised {reason(error)}")
                moves[seat] = None, clock() - begin, fault
            else:
                moves[seat] = action, clock() - begin, None
        return moves | self._isolated_moves(observations) if self._processes else moves

    def inspect(self, agent: AgentSpec) -> Entrant:
        """Return the entrant of the agent in seat 0 by its answer to the greeting, and end it."""
        entrant, (fields, _, fault) = self._isolated[0], self._greet()[0]
        log = self.logs()[0]
        self.drop(0)
        control, sources = fields.get("control", "target"), fields.get("sources")
        why = None if fault is None else fault.reason
        try:
            require_choice("control", control if isinstance(control, str) else shortened(control), get_args(Control))
        except ConfigError as error:
            why = str(error)
        if why is not None:
            return replace(entrant, fault=one_line(why), log=last_lines(log))
        listed = sources if isinstance(sources, list) else []  # a stranger's code may say anything
        digest = agent.digest([one for one in listed if isinstance(one, str)])
        return replace(entrant, control=control, digest=digest, prey=fields.get("prey") is True)

    def drop(self, seat: int) -> None:
        """End the agent of a seat that forfeited or dropped out; no process of it is left."""
        if self._sandbox is not None and seat in self._processes:
            self._sandbox.end(self._processes[seat])

    def logs(self) -> dict[int, str]:
        """Return the printed text by seat; agents in this process print to its own output."""
        for process in self._processes.values():
            process.read_log()
        return self._inspection_logs | {seat: process.log.text() for seat, process in self._processes.items()}

    def _greet(self) -> dict[int, _Reply]:
        """Start all isolated agents, and return their answers to the greeting."""
        if self._sandbox is None:
            return {}
        self._sandbox.clear()  # processes of an earlier match of these players
        for seat, entrant in self._isolated.items():
            self._processes[seat] = self._sandbox.start(entrant.spec)
        lines = {seat: protocol.line(hello=protocol.VERSION, side=one.side) for seat, one in self._isolated.items()}
        return self._exchange(lines, dict.fromkeys(lines, self._quotas.init_s), "init")

    def _isolated_moves(self, observations: Mapping[int, Observation]) -> dict[int, Move]:
        """Return the answers of those of these seats whose agents are isolated, and charge their time banks."""
        moves: dict[int, Move] = {}
        step_s, bank_s = self._quotas.step_ms / 1000.0, self._bank_s
        lines = {seat: protocol.view_line(*one) for seat, one in observations.items() if seat in self._processes}
        allowed_s = {seat: step_s + bank_s[seat] for seat in lines}
        for seat, (fields, seconds, fault) in self._exchange(lines, allowed_s, "act").items():
            bank_s[seat] -= max(0.0, seconds - step_s)
            if fault is None and "action" not in fields:
                moves[seat] = None, seconds, Fault("FORFEIT_ILLEGAL", f"its line holds no action: {shortened(fields)}")
            else:
                moves[seat] = fields.get("action"), seconds, fault
        return moves

    def _exchange(self, lines: Mapping[int, bytes], allowed_s: Mapping[int, float], doing: str) -> dict[int, _Reply]:
        """Send each seat its line, and return the answer of each: a JSON object or a fault."""
        if not lines:  # Windows has no poll
            return {}
        replies: dict[int, _Reply] = {}
        sent_at: dict[int, float] = {}
        due: dict[int, float] = {}
        seat_of: dict[int, int] = {}
        poll = select.poll()
        now = time.monotonic()
        while_waiting = self._while_waiting if doing == "act" else None
        call_at = math.inf if while_waiting is None else now + _WAIT_S
        waited_s = 0.0  # time in `while_waiting`, which `now` does not count
        for seat, line in lines.items():
            process = self._processes[seat]
            sent_at[seat] = sent = time.monotonic()
            if not process.write(line):
                replies[seat] = {}, 0.0, Fault("FORFEIT_TIMEOUT", f"{doing}: it does not read its lines", late=True)
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
                    fields, fault = _parse(doing, received, process)
                    if now > due.pop(seat) and fault is None:
                        fields, fault = {}, self._late(doing)
                    replies[seat] = fields, now - sent_at[seat], fault
            for seat in [seat for seat, end in due.items() if now > end]:
                del due[seat]
                poll.unregister(self._processes[seat].answer_pipe)  # later answers are too late
                replies[seat] = {}, now - sent_at[seat], self._late(doing)
            if while_waiting is not None and due and now >= call_at:
                try:
                    while_waiting()
                except BaseException:
                    for seat in due:
                        self.drop(seat)
                    raise
                waited_s = time.monotonic() - now
                call_at = now + _WAIT_S
        for seat, (_, seconds, fault) in replies.items():
            if fault is ENDED:
                replies[seat] = {}, seconds, Fault("FORFEIT_CRASH", f"{doing}: {self._end_of_process(seat)}")
        return replies

    def _late(self, doing: str) -> Fault:
        """Return the fault of an agent that exceeds a limit; reports count faults by these words."""
        init, step = f"init_s ({self._quotas.init_s:g} s)", f"step_ms ({self._quotas.step_ms:g} ms)"
        limit = init if doing == "init" else f"what was left of {init}"
        if doing == "act":
            limit = f"{step} and what was left of bank_s ({self._quotas.bank_s:g} s)"
        return Fault("FORFEIT_TIMEOUT", f"{doing} took longer than {limit}", late=True)

    def _end_of_process(self, seat: int) -> str:
        """End an agent that closed its answers, and return in words how its process ended.

        It is no fault of the agent if the process ended before it ran any code of it: then MatchFailedError is raised.
        """
        process = self._processes[seat]
        code = process.exit_code()
        self.drop(seat)
        if not process.started:
            last = process.log.last_line() or "it printed nothing"
            raise MatchFailedError(f"the process of {self._isolated[seat].name} could not start: {last}")
        return exit_reason(code, process.log)


def enter(
    specs: Sequence[str], sandbox: Sandbox | None = None, progress: Callable[[int, int], None] = lambda *_: None
) -> tuple[Entrant, ...]:
    """Return the entrants that these words on the command line name, in their order.

    Each agent is inspected in the kind of process in which it would play; without a sandbox all are trusted. One that
    cannot begin has a `fault`. AgentError is raised for a word that names no agent, and for a shipped agent with a
    fault. `progress` gets (number of the agent, number of all) before each inspection.
    """
    entrants = []
    inspect = cache(partial(_inspect, sandbox))
    agents, shipped_prey = [resolve(spec) for spec in specs], resolve(SHIPPED_PREY)
    for number, (agent, name) in enumerate(zip(agents, unique_names(agents), strict=True), 1):
        if any("\ud800" <= letter <= "\udfff" for letter in agent.spec):  # Python's form of bytes that are no text
            raise AgentError(
                f"{agent.spec!a}: must be text in this system's encoding, {sys.getfilesystemencoding()}: "
                "give the file or its folder another name, or try LANG=C.UTF-8"
            )
        if (wrong := name_fault(name)) is not None:
            raise AgentError(f"{agent.spec!a}: {wrong}; give the file another name")
        progress(number, len(agents))
        entrant = inspect(agent)
        if entrant.fault is not None and is_shipped(agent.spec):
            raise AgentError(entrant.fault)
        prey_digest = inspect(shipped_prey).digest if entrant.needs_prey else entrant.digest
        entrants.append(replace(entrant, name=name, prey_digest=prey_digest))
    return tuple(entrants)


def _inspect(sandbox: Sandbox | None, agent: AgentSpec) -> Entrant:
    """Return the entrant of an agent, with a fault if it cannot play; its name is its spec."""
    entrant = Entrant(agent.spec, agent.spec, "target", agent.digest(()))
    if sandbox is not None and not is_shipped(agent.spec):
        with Players([entrant], sandbox) as players:
            return players.inspect(agent)
    try:
        control = control_of(create_policy(agent.spec))
        sources, prey = sources_and_prey(agent.spec)
    except AgentError as error:
        return replace(entrant, fault=one_line(str(error)))
    return replace(entrant, control=control, digest=agent.digest(sources), prey=prey)


def _parse(doing: str, received: bytes | Fault, process: AgentProcess) -> tuple[dict[str, Any], Fault | None]:
    """Return the JSON object in an agent's line, and its fault: a line without one, or with an error."""
    if isinstance(received, Fault):
        return {}, received
    try:
        fields = protocol.read_json(received)
    except (ValueError, RecursionError):
        fields = None
    if not isinstance(fields, dict):
        return {}, Fault("FORFEIT_ILLEGAL", f"its line is no JSON object: {excerpt(received)}")
    process.read_log()  # all that it printed before this line
    if "ended" in fields:  # our program reports the end of the process that it forked for the match
        return {}, Fault("FORFEIT_CRASH", f"{doing}: {exit_reason(fields['ended'], process.log)}")
    if "error" in fields:
        why = fields["error"]
        return {}, Fault("FORFEIT_CRASH", one_line(why if isinstance(why, str) else shortened(why)))
    if process.log.printed > (most := process.quotas.file_mib) << 20:
        return {}, Fault("FORFEIT_CRASH", f"printed more than {most} MiB: print less (file_mib)")
    return fields, None
