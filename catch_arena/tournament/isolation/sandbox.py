"""The processes of isolated agents, from the tournament's side.

docs/isolation.md says what this protects against, and what it does not.
"""

import json
import os
import select
import shutil
import signal
import socket
import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from types import TracebackType
from typing import Any, Final

from catch_arena.descendants import family, is_stopped, start, state
from catch_arena.errors import NoContest
from catch_arena.files import is_full, room
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation import protocol
from catch_arena.tournament.isolation.levels import level_here
from catch_arena.tournament.isolation.limits import AgentLimits, Level
from catch_arena.tournament.isolation.namespaces import PLAY
from catch_arena.tournament.isolation.processes import close_to_others, how_it_ended

_MOST_SERVERS: Final = 16
"""Entrants whose fork servers wait for their next match; each holds its agent's modules in memory."""
_SUPERVISOR: Final = "catch_arena.tournament.isolation.supervisor"
_SUPERVISOR_S: Final = 30.0
"""How long the supervisor may take over anything that is asked of it."""
_SERVER_S: Final = 1.0
"""How long a fork server may take to say how its agent's process has ended."""
_GONE: Final = "the supervisor of the agents' processes has ended"
_MESSAGE: Final = 100
_PART: Final = 65536
_PASSED_ON: Final = (
    *("PATH", "LANG", "LC_ALL", "TZ", "TMPDIR"),
    # which instructions NumPy and its BLAS use: others round sums otherwise, and a network would play otherwise
    *("NPY_DISABLE_CPU_FEATURES", "NPY_ENABLE_CPU_FEATURES", "OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE"),
    *("MKL_CBWR", "MKL_ENABLE_INSTRUCTIONS"),
)
_SETTINGS: Final = {
    "PYTHONDONTWRITEBYTECODE": "1",  # nothing is left beside an agent's file
    "PYTHONHASHSEED": "0",  # equal seeds, equal play
    "PYTHONUNBUFFERED": "1",  # what is printed is kept, however its process ends
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}
"""The environment of agents, HOME and TMPDIR besides."""


class _Supervisor:
    """The process that all agents of a sandbox descend from (supervisor.py)."""

    def __init__(self) -> None:
        close_to_others()  # the match is in this process's memory
        self._control, theirs = socket.socketpair()
        with theirs:
            try:
                self._process = start(
                    _SUPERVISOR,
                    theirs.fileno(),
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                    cwd="/",
                    env={name: os.environ[name] for name in _PASSED_ON if name in os.environ} | _SETTINGS,
                )
            except OSError as error:
                raise NoContest(f"the supervisor of the agents' processes cannot be started: {error}") from None
        self._control.settimeout(_SUPERVISOR_S)
        try:
            self.folder = Path(self._heard()["folder"])
        except NoContest:
            self._end()
            raise

    @property
    def pid(self) -> int:
        """The process's id."""
        return self._process.pid

    def ask(self, files: Sequence[int] = (), **request: Any) -> dict[str, Any]:
        """Its answer.

        Raises:
            NoContest: where there is none.
        """
        self._require_not_stopped()
        with suppress(OSError):  # what is wrong shows when it is heard
            protocol.send(self._control, files, **request)
        return self._heard()

    def require_alive(self) -> None:
        """Require that it runs.

        Raises:
            NoContest: where it has ended, and all agents with it, or was stopped.
        """
        if select.select([self._control], [], [], 0.0)[0]:  # it says nothing that it was not asked
            raise NoContest(_GONE)
        self._require_not_stopped()

    def _require_not_stopped(self) -> None:
        if state(self.pid) == "T":
            raise NoContest("the supervisor of the agents' processes was stopped")

    def close(self) -> None:
        """Let it end everything, and itself."""
        self._end()
        shutil.rmtree(self.folder, ignore_errors=True)  # where the supervisor was killed

    def _end(self) -> None:
        self._control.close()
        self._process.send_signal(signal.SIGCONT)  # an agent may have stopped it
        try:
            self._process.wait(_SUPERVISOR_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _heard(self) -> dict[str, Any]:
        try:
            received = protocol.receive(self._control)
        except OSError as error:
            raise NoContest(f"the supervisor of the agents' processes does not answer: {error}") from None
        if received is None:
            raise NoContest(_GONE)
        return received[0]


class _ForkServer:
    """One entrant's.

    Args:
        pid: its process.
        channel: our end of its socket.
        errors: where bubblewrap says why it fails.
    """

    def __init__(self, pid: int, channel: socket.socket, errors: int) -> None:
        self.pid = pid
        self.channel = channel
        self.busy = True
        """Whether it has yet to say how the process that it forked has ended."""
        self.began = False
        """Whether it has been ready for its agent."""
        self._errors = errors
        self._unread = b""

    def exit_code(self) -> int | None:
        """That process's, less than 0 for a signal; None where the fork server does not say."""
        try:
            message = self._next()
            if not self.began:  # it has run none of its agent's code yet
                self.began = message == {"ready": True}
                message = self._next()
            code = os.waitstatus_to_exitcode(message["ended"])
        except (OSError, ValueError, TypeError, KeyError, OverflowError):
            return None
        self.busy = False
        return code

    def why_it_did_not_begin(self) -> str:
        """What bubblewrap has said."""
        try:
            said = os.read(self._errors, _PART).decode(errors="replace").strip().splitlines()
        except BlockingIOError:
            said = []
        return said[-1] if said else "it was ended"

    def close(self) -> None:
        """Let it go."""
        self.channel.close()
        os.close(self._errors)

    def _next(self) -> Any:
        """A short message, without files: it may come from a stranger's code."""
        while b"\n" not in self._unread:
            part = self.channel.recv(_MESSAGE)
            if not part or len(self._unread) > _MESSAGE:
                raise ConnectionError
            self._unread += part
        line, _, self._unread = self._unread.partition(b"\n")
        return json.loads(line)


class Sandbox:
    """Where the isolated agents of one tournament process live; it holds one match at a time.

    They descend from one process of ours, the supervisor, which is started when it is first needed, and which ends them
    all when this process ends, however that ends. Use it as a context manager, or `close` it. Whatever its methods
    raise is a NoContest.

    Args:
        limits: each agent's.

    Raises:
        ConfigError: for a level that this machine cannot hold.
    """

    def __init__(self, limits: AgentLimits | None = None) -> None:
        self.limits = limits or AgentLimits()
        if self.limits.level is not None:
            level_here(self.limits.level)
        self._supervisor: _Supervisor | None = None
        self._servers: dict[tuple[str, str], _ForkServer] = {}

    def __enter__(self) -> "Sandbox":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    @property
    def level(self) -> Level:
        """How its agents are held apart."""
        return level_here(self.limits.level)

    def close(self) -> None:
        """End all agents, and remove what they wrote; the next match would start anew."""
        for server in self._servers.values():
            server.close()
        self._servers.clear()
        if self._supervisor is not None:
            self._supervisor.close()
            self._supervisor = None

    def start(self, entrant: Entrant, seat: int, files: Sequence[int]) -> None:
        """Give an entrant a process for this match; `files` are its ends of AgentPipes: in, out and log."""
        if self._supervisor is None:
            self._supervisor = _Supervisor()
        folder = PLAY if self.level == "namespaces" else self._folder(self._supervisor, seat)
        server = self._servers.get(_key(entrant))
        if server is not None:
            try:
                protocol.send(server.channel, files, play=str(folder), side=entrant.side)
            except OSError:  # it has ended since its last match
                self.end(entrant)
                server = None
        if server is None:
            server = self._start_server(self._supervisor, entrant.spec)
            with suppress(OSError):  # whether it has ended already, its pipes will show
                whom = {"serve": entrant.spec, "limits": self.limits.numbers()}
                protocol.send(server.channel, files, play=str(folder), side=entrant.side, **whom)
        server.busy = True
        self._servers.pop(_key(entrant), None)
        self._servers[_key(entrant)] = server  # the last one: those that have waited longest are ended first

    def end(self, entrant: Entrant) -> None:
        """End an agent and all that it started, its fork server too."""
        server = self._servers.pop(_key(entrant), None)
        if server is not None and self._supervisor is not None:
            server.close()
            self._supervisor.ask(end=server.pid)

    def how_it_ended(self, entrant: Entrant) -> tuple[str, bool]:
        """Why an agent's answers have ended, in words; where that is no agent's fault, it is raised.

        Returns:
            these words, and whether a signal may have ended its process, which anybody may have sent.
        """
        server = self._servers[_key(entrant)]
        code = server.exit_code()
        self.require_alive()
        if code is not None:
            return how_it_ended(code), code < 0 and code != -signal.SIGXCPU
        if self._supervisor is not None and (excess := self._supervisor.ask(excess=server.pid)["excess"]):
            return str(excess), False
        if not server.began and self.level == "namespaces":
            raise NoContest(f"an agent's namespaces could not be made: {server.why_it_did_not_begin()}")
        return "its process has ended, or closed its answers", True

    def require_alive(self) -> None:
        """Require that what keeps the agents runs.

        Raises:
            NoContest: where it has ended or was stopped.
        """
        if self._supervisor is not None:
            self._supervisor.require_alive()

    def has_stopped(self) -> bool:
        """Whether what keeps the agents was stopped."""
        return self._supervisor is not None and is_stopped(self._supervisor.pid)

    def holds_stopped(self) -> bool:
        """Whether anybody has stopped a process of an agent."""
        return self._supervisor is not None and any(map(is_stopped, family(self._supervisor.pid)))

    def is_full(self) -> bool:
        """Whether the disk is full that agents' folders are on."""
        return self._supervisor is not None and is_full(self._supervisor.folder)

    @property
    def pid(self) -> int:
        """That of the process that all its agents descend from, which is started where it does not run."""
        if self._supervisor is None:
            self._supervisor = _Supervisor()
        return self._supervisor.pid

    def clear(self) -> None:
        """End what a match has left, but for the fork servers that serve the next one."""
        if self._supervisor is None:
            return
        try:
            if not self._supervisor.ask(sweep=True)["done"]:
                raise NoContest("a process of an agent could not be ended")
            for key, server in list(self._servers.items()):
                unclear = server.busy and server.exit_code() is None
                if unclear or len(self._servers) > _MOST_SERVERS:
                    del self._servers[key]
                    server.close()
                    self._supervisor.ask(end=server.pid)
        except BaseException:
            self.close()
            raise

    @staticmethod
    def _folder(supervisor: _Supervisor, seat: int) -> Path:
        """To work in, for one match."""
        try:
            return Path(tempfile.mkdtemp(prefix=f"seat_{seat}_", dir=supervisor.folder))
        except OSError as error:
            raise NoContest(
                f"{supervisor.folder}: no folder can be made there: {error.strerror}: {room(supervisor.folder)}"
            ) from None

    def _start_server(self, supervisor: _Supervisor, spec: str) -> _ForkServer:
        ours, theirs = socket.socketpair()
        ours.settimeout(_SERVER_S)
        errors, tells = os.pipe()
        os.set_blocking(errors, False)
        try:
            with theirs:
                asked = {"serve": spec, "limits": asdict(replace(self.limits, level=self.level))}
                answer = supervisor.ask([theirs.fileno(), tells], **asked)
        finally:
            os.close(tells)
        server = _ForkServer(answer["pid"], ours, errors)
        if answer["pid"] is None:
            server.close()
            raise NoContest(f"an agent's fork server cannot be started: {answer['error']}")
        return server


def _key(entrant: Entrant) -> tuple[str, str]:
    return entrant.name, entrant.spec
