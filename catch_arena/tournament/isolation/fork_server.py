"""The fork server of one entrant: it imports an agent's module once, and forks a process for each of its matches.

From the import on, it runs a stranger's code: its parent, the supervisor, does not rely on it. A command has a fork
server too, which only starts it. In the fork, `speak_for` speaks the protocol for a Python class; a command speaks it
itself.

In namespaces of its own it is their first process: whatever loses its parent there is its child, and when it ends, all
end.
"""

import fcntl
import importlib
import json
import os
import signal
import socket
import sys
import traceback
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from io import BufferedReader, BufferedWriter
from pathlib import Path
from types import TracebackType
from typing import Any, Final

import catch_arena
from catch_arena.errors import AgentError, CatchArenaError, reason
from catch_arena.policy import Policy, PreyPolicy, Side
from catch_arena.tournament import entrants
from catch_arena.tournament.entrants import agent_class, command_of, create_policy, look_for_prey, sources_of
from catch_arena.tournament.isolation import protocol
from catch_arena.tournament.isolation.folders import empty
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.namespaces import WRITABLE
from catch_arena.tournament.isolation.processes import adopt_orphans, confine, die_with, limit_cpu

_INTO, _OUT = 3, 4
"""The descriptors that a Python agent's process reads lines from and answers to; what it prints goes to its log."""
_FIRST_FREE: Final = 10


def main() -> None:
    """Serve in namespaces of its own, on the socket that is the standard input."""
    channel = socket.socket(fileno=os.dup(0))
    null = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1, 2):
        os.dup2(null, standard)
    os.close(null)
    try:
        serve(channel, namespaced=True)
    finally:
        os._exit(0)  # what is wrong with us is nothing for an agent's log


def serve(channel: socket.socket, *, namespaced: bool = False) -> None:
    """Play matches, one after the other, until the other side goes.

    Each request brings three open files: for the lines that the agent reads, for its answers, and for its log. The
    first one also says which agent, and its limits; it is answered when all is ready for strangers.
    """
    adopt_orphans()
    received = protocol.receive(channel)
    if received is None:
        return
    spec, limits = received[0]["serve"], AgentLimits(**received[0]["limits"])
    confine(limits, namespaced=namespaced)
    kept = [path for folder in WRITABLE for path in _folders_in(folder)] if namespaced else []
    protocol.send(channel, ready=True)
    command, imported = command_of(spec), False
    while received is not None:
        message, files = received
        into, out, log = files
        _work_in(Path(message["play"]), log)
        if command is None and not imported:
            _import(spec, out)
            imported = True
        sys.stdout.flush()
        sys.stderr.flush()
        parent = os.getpid()
        pid = os.fork()
        if pid == 0:
            try:
                die_with(parent)
                limit_cpu(limits.cpu_s)
                if command is None:
                    _become_python(spec, message["side"], into, out, log)
                else:
                    _become_command(command, into, out, log)
            finally:
                os._exit(1)
        for file in files:
            os.close(file)
        status = _wait_for(pid)
        if namespaced:
            _leave_nothing(kept)
        protocol.send(channel, ended=status)
        received = protocol.receive(channel)


def speak_for(
    policy: Policy | PreyPolicy, lines: BufferedReader, answers: BufferedWriter, known: Mapping[str, Any]
) -> None:
    """Our side of the protocol for a Python class; what it raises is told in one line, and its traceback printed.

    Args:
        policy: an instance for this match.
        lines: what it reads.
        answers: where its answers go.
        known: what it says of itself besides its control.
    """
    doing = "init"
    try:
        lines.readline()  # hello
        _send(answers, protocol.line(control=getattr(policy, "control", "target"), **known))
        if not (line := lines.readline()):
            return
        doing = "reset"
        message = json.loads(line)["reset"]
        limits = protocol.limits_in(message)
        policy.reset(message["seed"])
        _send(answers, protocol.line(ready=True))
        doing = "act"
        while (seen := protocol.read_record(lines)) is not None:
            action = policy.act(limits.view(*seen))  # type: ignore[arg-type]  # its limits are of its side
            _send(answers, b'{"action":%d}\n' % action if type(action) is int else protocol.action_line(action))
    except BaseException as error:  # noqa: BLE001 - a stranger's code may raise anything
        _print(error, error.__traceback__ and error.__traceback__.tb_next)  # without our own frame
        _send(answers, protocol.line(error=f"{doing} raised {reason(error)}"))


def _wait_for(pid: int) -> int:
    """How that process has ended; others that end meanwhile are buried."""
    while True:
        ended, status = os.waitpid(-1, 0)
        if ended == pid:
            return status


def _leave_nothing(kept: Collection[Path]) -> None:
    """End whatever else runs in these namespaces, and remove what was written there."""
    if os.getpid() == 1:
        with suppress(ProcessLookupError):
            os.kill(-1, signal.SIGKILL)  # all but this one
    with suppress(ChildProcessError):
        while True:
            os.waitpid(-1, 0)
    os.chdir("/")
    for folder in WRITABLE:
        empty(folder, kept)


def _folders_in(folder: Path) -> Iterator[Path]:
    """The folders in a folder, and what is mounted there, as long as nobody has written to it."""
    for entry in folder.iterdir():
        yield entry
        if not entry.is_symlink() and entry.is_dir() and not entry.is_mount():
            yield from _folders_in(entry)


def _work_in(folder: Path, log: int) -> None:
    """Work in that folder, and print to that log."""
    folder.mkdir(mode=0o700, exist_ok=True)
    os.chdir(folder)
    os.environ["HOME"] = os.environ["TMPDIR"] = os.environ["PWD"] = str(folder)
    for standard in (1, 2):
        os.dup2(log, standard)


def _import(spec: str, out: int) -> None:
    """Load the agent's class; a fork server that cannot says so and ends."""
    try:
        agent_class(spec)
    except AgentError as error:
        with os.fdopen(out, "wb") as answers:
            _report(error, answers)
        sys.stderr.flush()
        os._exit(1)


def _become_python(spec: str, side: Side, into: int, out: int, log: int) -> None:
    _keep_only((os.open(os.devnull, os.O_RDONLY), log, log, into, out))
    with os.fdopen(_INTO, "rb") as lines, os.fdopen(_OUT, "wb") as answers:
        try:
            policy = create_policy(spec, side)
        except AgentError as error:
            _report(error, answers)
        else:
            prey, prey_fault = look_for_prey(spec)
            known = {"sources": sources_of(spec), "prey": prey, "prey_fault": prey_fault}
            speak_for(policy, lines, answers, known)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


def _become_command(command: list[str], into: int, out: int, log: int) -> None:
    _keep_only((into, out, log))
    for ignored in (signal.SIGPIPE, signal.SIGXFSZ):  # by Python, not by other programs
        signal.signal(ignored, signal.SIG_DFL)
    try:
        os.execv(command[0], command)  # noqa: S606 - no shell is wanted
    except OSError as error:
        os.write(1, protocol.line(error=f"{command[0]}: cannot be started: {error.strerror}"))


def _keep_only(files: Sequence[int]) -> None:
    """These files become descriptors 0, 1, 2, ...; all others are closed."""
    copies = [fcntl.fcntl(file, fcntl.F_DUPFD, _FIRST_FREE) for file in files]
    for number, copy in enumerate(copies):
        os.dup2(copy, number)
    os.closerange(len(files), os.sysconf("SC_OPEN_MAX"))


def _report(error: AgentError, answers: BufferedWriter) -> None:
    if error.__cause__ is not None:
        cause = error.__cause__
        theirs = cause.__traceback__
        while theirs is not None and _imports(theirs.tb_frame.f_code.co_filename):
            theirs = theirs.tb_next
        _print(cause, theirs)
    _send(answers, protocol.line(error=str(error)))


def _print(error: BaseException, theirs: TracebackType | None) -> None:
    """Its traceback, for the agent's log. An error of ours is told in one line elsewhere, and the lines of ours that
    raised it help nobody: of these the agent's own lines are left.
    """
    if not isinstance(error, CatchArenaError):
        traceback.print_exception(type(error), error, theirs)
        return
    ours = str(Path(catch_arena.__file__).parent) + os.sep
    traceback.print_list([frame for frame in traceback.extract_tb(theirs) if not frame.filename.startswith(ours)])


def _imports(file: str) -> bool:
    """Whether a line of this file imports an agent, and is none of the agent's own."""
    return file.startswith("<frozen importlib") or file in {importlib.__file__, entrants.__file__}


def _send(answers: BufferedWriter, line: bytes) -> None:
    answers.write(line)
    answers.flush()
