"""The fork server of one entrant: it imports an agent's module once, and forks a process for each of its matches.

From the import on, it runs a stranger's code: its parent, the supervisor, does not rely on it. A command has a fork
server too, which only starts it. In the fork, `speak_for` speaks the protocol for a Python class; a command speaks it
itself.
"""

import fcntl
import json
import os
import signal
import socket
import sys
import traceback
from collections.abc import Sequence
from io import BufferedReader, BufferedWriter
from pathlib import Path
from typing import Final

from catch_arena.errors import AgentError, reason
from catch_arena.policy import Limits, Policy, View
from catch_arena.tournament.entrants import agent_class, command_of, create_policy, source_of
from catch_arena.tournament.isolation import protocol
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.processes import confine, die_with, limit_cpu

_INTO, _OUT = 3, 4
"""The descriptors that a Python agent's process reads lines from and answers to; what it prints goes to its log."""
_FIRST_FREE: Final = 10


def serve(channel: socket.socket, spec: str, limits: AgentLimits) -> None:
    """Play matches, one after the other, until the other side goes.

    Each request brings three open files: for the lines that the agent reads, for its answers, and for its log.
    """
    confine(limits)
    command, imported = command_of(spec), False
    while (received := protocol.receive(channel)) is not None:
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
                    _become_python(spec, into, out, log)
                else:
                    _become_command(command, into, out, log)
            finally:
                os._exit(1)
        for file in files:
            os.close(file)
        _, status = os.waitpid(pid, 0)
        protocol.send(channel, ended=status)


def speak_for(policy: Policy, lines: BufferedReader, answers: BufferedWriter) -> None:
    """Our side of the protocol for a Python class; what it raises is told in one line, and its traceback printed."""
    limits: Limits | None = None
    doing = "init"
    try:
        for line in lines:
            message = json.loads(line)
            if "view" in message and limits is not None:
                doing = "act"
                action = policy.act(View(protocol.float32(message["view"]), message["mask"], limits))
                answer = b'{"action":%d}\n' % action if type(action) is int else protocol.action_line(action)
            elif "reset" in message:
                doing = "reset"
                limits = Limits(**message["reset"]["limits"])
                policy.reset(message["reset"]["seed"])
                answer = protocol.line(ready=True)
            else:
                answer = protocol.line(control=getattr(policy, "control", "target"), source=source_of(policy))
            answers.write(answer)
            answers.flush()
    except BaseException as error:  # noqa: BLE001 - a stranger's code may raise anything
        theirs = error.__traceback__ and error.__traceback__.tb_next  # without our own frame
        traceback.print_exception(type(error), error, theirs)
        _send_error(answers, f"{doing} raised {reason(error)}")


def _work_in(folder: Path, log: int) -> None:
    """Work in that folder, and print to that log."""
    os.chdir(folder)
    os.environ["HOME"] = os.environ["TMPDIR"] = str(folder)
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


def _become_python(spec: str, into: int, out: int, log: int) -> None:
    _keep_only((os.open(os.devnull, os.O_RDONLY), log, log, into, out))
    with os.fdopen(_INTO, "rb") as lines, os.fdopen(_OUT, "wb") as answers:
        try:
            policy = create_policy(spec)
        except AgentError as error:
            _report(error, answers)
        else:
            speak_for(policy, lines, answers)
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
        traceback.print_exception(error.__cause__)
    _send_error(answers, str(error))


def _send_error(answers: BufferedWriter, text: str) -> None:
    answers.write(protocol.line(error=text))
    answers.flush()
