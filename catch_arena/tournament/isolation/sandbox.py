"""Processes of isolated agents, from the tournament's side. docs/howto/isolation.md lists what this stops."""

import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import catch_arena
from catch_arena.errors import ConfigError, MatchFailedError
from catch_arena.tournament.agent_spec import TEMPORARY, command_of
from catch_arena.tournament.isolation import protocol
from catch_arena.tournament.isolation.namespaces import available_level, bubblewrap_command, visible_paths
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.loading import module_folders
from catch_arena.tournament.match import Fault

ENDED: Final = Fault("FORFEIT_CRASH", "it closed its answers")
"""Result of `AgentProcess.read` if the agent closed its answers, mostly because its process has ended."""
_MOST_WAITING: Final = 16
"""Largest number of processes that wait for a next match; each holds its agent's modules in memory."""
_END_S: Final = 2.0
"""Time for a process to end a match, or to end itself [s]."""
_PAUSE_S: Final = 0.002
_KIB: Final = 1024
_ENDED_BY_SIGNAL: Final = 128
"""Exit code of bubblewrap, less the number of the signal, if a signal ended the program that it started."""
_MAIN: Final = (
    "import sys; words, package, *path = sys.argv[1:]; sys.path[:] = [package, *path]; "
    "from catch_arena.tournament.isolation.agent_program import main; del sys.path[0]; main(words)"
)
_PASSED_ON: Final = (
    *("PATH", "LANG", "LC_ALL", "TZ"),
    # the instructions of NumPy and its BLAS: with others, sums are rounded differently, and a network plays differently
    *("NPY_DISABLE_CPU_FEATURES", "NPY_ENABLE_CPU_FEATURES", "OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE"),
    *("MKL_CBWR", "MKL_ENABLE_INSTRUCTIONS"),
)
_SETTINGS: Final = {
    "PYTHONDONTWRITEBYTECODE": "1",  # nothing is left next to an agent's file
    "PYTHONHASHSEED": "0",  # equal seeds, equal play
    "PYTHONUNBUFFERED": "1",  # output is kept even if the process is killed
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}
"""Environment variables of agents, besides HOME and TMPDIR."""


class Log:
    """Log of an agent's output, up to a size in bytes: half of it from the beginning, half from the end."""

    def __init__(self, size: int) -> None:
        self._half = size // 2
        self._first, self._last = bytearray(), bytearray()
        self.printed = 0
        """Number of bytes that were added."""

    def add(self, content: bytes) -> None:
        """Add printed bytes."""
        self.printed += len(content)
        room = self._half - len(self._first)
        self._first += content[:room]
        self._last += content[room:]
        del self._last[: -self._half]

    def text(self) -> str:
        """Return the kept text, with a line in place of bytes that are left out."""
        between = self.printed - len(self._first) - len(self._last)
        gap = f"\n[{between} bytes left out]\n".encode() if between else b""
        return (self._first + gap + self._last).decode(errors="backslashreplace")

    def last_line(self) -> str:
        """Return the last line that is not blank; empty if there is none."""
        return next((line for line in reversed(self.text().splitlines()) if line.strip()), "")


class AgentProcess:
    """Process of one agent (agent_program.py), with its pipes; it plays one match after the other."""

    def __init__(self, spec: str, quotas: Quotas) -> None:
        if not hasattr(os, "fork"):
            raise ConfigError(f"{spec}: agents are isolated on Linux and macOS only: give --trusted, or use WSL")
        self.spec = spec
        self.started = False
        """True after the process has begun to run the agent's code."""
        self.quotas = quotas
        self._namespaced = quotas.isolation == "namespaces"
        self._unread = b""
        self._log_open = True
        self.log = Log(quotas.log_kib * _KIB)
        pipes: list[tuple[int, int]] = []
        try:
            pipes.extend(os.pipe() for _ in range(3))
            (into, self._line_pipe), (self.answer_pipe, out), (self.log_pipe, log) = pipes
            self._folder = None if self._namespaced else tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
            folder = str(TEMPORARY) if self._folder is None else self._folder.name
            settings = {"spec": spec, "quotas": quotas.numbers(), "folder": folder, "into": into, "out": out}
            words = [sys.executable, "-c", _MAIN, json.dumps(settings | {"namespaced": self._namespaced})]
            words += [str(Path(catch_arena.__file__).parents[1]), *module_folders()]
            if self._namespaced:
                words = [*bubblewrap_command(visible_paths(spec), quotas.file_mib << 20), *words]
            self._process = subprocess.Popen(  # noqa: S603 - our own program
                words,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                cwd="/",
                env={name: os.environ[name] for name in _PASSED_ON if name in os.environ} | _SETTINGS,
                pass_fds=(into, out),
                start_new_session=True,
            )
        except OSError as error:
            for file in (file for pipe in pipes for file in pipe):
                os.close(file)
            lacks_folder = "temporary directory" in str(error)
            why = f"{error.strerror}: set TMPDIR to a writable folder" if lacks_folder else error
            raise MatchFailedError(f"an agent's process cannot be started: {why}") from None
        self.pid = self._process.pid
        """Id of the process; in namespaces, id of the process that made them."""
        for file in (into, out, log):
            os.close(file)
        for file in (self._line_pipe, self.answer_pipe, self.log_pipe):
            os.set_blocking(file, False)

    def files(self) -> tuple[int, ...]:
        """Return the descriptors to poll: answers, and printed text while the log is open."""
        return (self.answer_pipe, self.log_pipe) if self._log_open else (self.answer_pipe,)

    def write(self, line: bytes) -> bool:
        """Write a line, and return False if the pipe has no room; a closed pipe shows in the next `read`."""
        try:
            return os.write(self._line_pipe, line) == len(line)
        except BlockingIOError:
            return False
        except BrokenPipeError:
            return True

    def read(self) -> bytes | Fault | None:
        """Read the available bytes, and return a whole line, a fault, or None if the line is not complete yet."""
        try:
            part = os.read(self.answer_pipe, protocol.PART)
        except BlockingIOError:
            return None
        if not part:
            return ENDED
        self._unread += part
        if not self.started and self._unread.startswith(protocol.STARTED):
            self.started = True
            self._unread = self._unread.removeprefix(protocol.STARTED)
        line, end, rest = self._unread.partition(b"\n")
        if rest:
            return Fault("FORFEIT_ILLEGAL", f"said more than one line: {excerpt(self._unread)}")
        if len(self._unread) > (most := self.quotas.answer_kib * _KIB):
            return Fault("FORFEIT_ILLEGAL", f"its line is longer than {most} bytes: {excerpt(line)}")
        if not end:
            return None
        self._unread = b""
        return line

    def read_log(self) -> bool:
        """Add printed bytes to the log, and return whether more may come."""
        with suppress(BlockingIOError):
            for _ in range(4):  # an agent that prints without end must not block
                if self._log_open and (part := os.read(self.log_pipe, protocol.PART)):
                    self.log.add(part)
                else:
                    self._log_open = False
        return self._log_open

    def finish(self) -> bool:
        """End the current match, and return whether the process can play another one."""
        if command_of(self.spec) is not None or not self.write(protocol.END):  # a command ends with its first match
            return False
        line: bytes | Fault | None = None
        deadline = time.monotonic() + _END_S
        while line is None and (left := deadline - time.monotonic()) > 0:
            if select.select([self.answer_pipe], [], [], left)[0]:
                line = self.read()
        self.read_log()
        return isinstance(line, bytes) and line.startswith(b'{"ended":')

    def exit_code(self) -> int | None:
        """Return the exit code of the process, below 0 for a signal; None if it does not end in time."""
        deadline = time.monotonic() + _END_S
        while (code := self._process.poll()) is None and time.monotonic() < deadline:
            self.read_log()  # a process that waits for room in the pipe could not end
            time.sleep(_PAUSE_S)
        ended_by = code - _ENDED_BY_SIGNAL if self._namespaced and code is not None else 0
        return -ended_by if 0 < ended_by < signal.NSIG else code

    def close(self) -> None:
        """Kill the process and all processes in its namespaces or in its group, and remove its folder."""
        if not self._namespaced and self._process.poll() is None:
            self._process.terminate()  # it ends all that it started, also in other groups
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(_END_S)
        with suppress(ProcessLookupError, PermissionError):  # macOS raises the latter for dead processes
            os.killpg(self.pid, signal.SIGKILL)
        self._process.wait()
        deadline = time.monotonic() + _END_S  # the log ends with the last process in the namespaces
        while self.read_log() and (left := deadline - time.monotonic()) > 0:
            select.select([self.log_pipe], [], [], left)
        self._log_open = False
        for file in (self._line_pipe, self.answer_pipe, self.log_pipe):
            os.close(file)
        if self._folder is not None:
            self._folder.cleanup()


class Sandbox(AbstractContextManager["Sandbox"]):
    """Sandbox: the isolated agents of one process, for one match at a time. Use it as a context manager, or `close` it.

    A level of isolation that this machine does not have raises ConfigError.
    """

    def __init__(self, quotas: Quotas) -> None:
        self.quotas = replace(quotas, isolation=available_level(quotas.isolation))
        self._playing: list[AgentProcess] = []
        self._waiting: list[AgentProcess] = []

    def __exit__(self, *_: object) -> None:
        self.close()

    def start(self, spec: str) -> AgentProcess:
        """Return a process for the agent of a spec in the next match: one that waits, or a new one."""
        process = next((one for one in self._waiting if one.spec == spec), None)
        if process is None:
            process = AgentProcess(spec, self.quotas)
        else:
            self._waiting.remove(process)
            process.log = Log(self.quotas.log_kib * _KIB)
        self._playing.append(process)
        return process

    def end(self, process: AgentProcess) -> None:
        """End an agent in a match, and all processes that it started."""
        if process in self._playing:
            self._playing.remove(process)
            process.close()

    def clear(self) -> None:
        """End a match; processes that can play another match wait for it."""
        for process in [*self._playing]:
            if process.finish():
                self._playing.remove(process)
                self._waiting.append(process)
            else:
                self.end(process)
        while len(self._waiting) > _MOST_WAITING:
            self._waiting.pop(0).close()

    def close(self) -> None:
        """End all agents, and remove the files that they wrote."""
        while processes := self._playing or self._waiting:
            processes.pop().close()


def sandbox_for(quotas: Quotas | None) -> AbstractContextManager[Sandbox | None]:
    """Return a context manager with a sandbox of these quotas, or with None if all agents are trusted."""
    return nullcontext() if quotas is None else Sandbox(quotas)


def exit_reason(code: Any, log: Log) -> str:
    """Return an exit code in words, and the last line of the log; a code below 0 is a signal."""
    how = ENDED.reason  # the agent may have written any code
    if isinstance(code, int) and 0 <= code <= 255:
        how = f"its process exited with code {code}"
    elif isinstance(code, int) and -code in set(signal.Signals):
        name = signal.Signals(-code).name
        how = "its process used up its CPU time (cpu_s)" if name == "SIGXCPU" else f"its process was ended by {name}"
    return f'{how}; its last line: "{line}"' if (line := log.last_line()) else how


def excerpt(content: bytes) -> str:
    """Return the beginning of an agent's line as text in quotes."""
    return repr(content[:80].decode(errors="replace"))
