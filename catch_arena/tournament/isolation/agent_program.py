"""Program in an agent's process, which imports the agent's module once, and forks for each match.

It reads lines from one pipe and writes answers to another; standard output and standard error go to the agent's log.
From the import on it runs a stranger's code, so the tournament does not trust its answers. A command replaces this
program, and speaks the protocol itself, with its answers on standard output.

`sandbox.AgentProcess` starts it, with or without namespaces (namespaces.py).
"""

import ctypes
import errno
import gc
import importlib
import json
import os
import resource
import select
import shutil
import signal
import sys
import time
import traceback
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, NoReturn

import msgspec

from catch_arena.errors import AgentError, reason
from catch_arena.interrupts import LINUX
from catch_arena.tournament import loading
from catch_arena.tournament.agent_spec import command_of, folder_of
from catch_arena.tournament.isolation import protocol
from catch_arena.tournament.isolation.namespaces import SHARED
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.loading import agent_class, create_policy, sources_and_prey

_SET_PDEATHSIG, _SET_CHILD_SUBREAPER = 1, 36  # <linux/prctl.h>
_MIB: Final = 1 << 20
_ADDRESSES: Final = 4
"""Addresses that a process may use for each byte of its private memory: libraries map memory that they never use."""
_ERROR_SENT: Final = 76
"""Exit code of a match's process that has sent its agent's error; nothing more is sent, and the program ends."""
_END_LINES: Final = (b"", protocol.END)
"""Lines at which a match is over: the end of the pipe, and END."""
_CLEAN_S: Final = 1.0
"""Time to end the processes that a match has left [s]; then the program ends, and the tournament ends the rest."""
_PAUSE_S: Final = 0.01
"""Time between two looks at processes that may have ended, if the system sends no signal [s]."""


def main(words: str) -> None:
    """Run the program; `words` is JSON of the arguments of `serve`."""
    arguments = json.loads(words)
    code = 1
    try:
        serve(**arguments)
        code = 0
    except BaseException:  # noqa: BLE001 - the last line of the traceback becomes part of the reason
        traceback.print_exc()
    finally:
        _clean_up_and_exit(None if arguments["namespaced"] else Path(arguments["folder"]), code)


def serve(spec: str, quotas: Mapping[str, Any], folder: str, into: int, out: int, *, namespaced: bool) -> None:
    """Play matches until the tournament closes the pipe `into`; answers go to the pipe `out`.

    The agent's working folder is made in `folder` for each match.
    """
    tournament = os.getppid()
    if not namespaced:
        _end_after_parent(tournament, Path(folder))
    allowed = Quotas(**quotas)
    _confine(allowed, namespaced=namespaced)
    writable = [Path(folder), SHARED] if namespaced else [Path(folder)]
    kept = {path for place in writable for path in _contents_of(place)}
    working = Path(folder, ".match")
    _enter_folder(working)
    os.write(out, protocol.STARTED)
    if (command := command_of(spec)) is not None:
        _limit_cpu(allowed.cpu_s)
        _become_command(command, into, out)
    loading.in_own_process = True
    if (own := folder_of(spec)) is not None:
        sys.path.insert(0, str(own))
    try:
        agent_class(spec)
    except AgentError as error:
        _report(error, out)
        _flush()
        return
    gc.freeze()  # a collection in a fork would look at all modules, and copy their pages
    poll = select.poll()
    poll.register(into, select.POLLIN)
    while poll.poll()[0][1] & select.POLLIN:
        _enter_folder(working)
        _flush()
        parent, child = os.getpid(), os.fork()
        if child == 0:
            try:
                signal.signal(signal.SIGTERM, signal.SIG_DFL)
                _prctl(_SET_PDEATHSIG, signal.SIGKILL)
                _limit_cpu(allowed.cpu_s)
                if os.getppid() == parent:
                    _serve_match(spec, into, out)
            except BaseException as error:  # noqa: BLE001 - a class may raise anything when an instance is made
                _print(error)
            finally:
                os._exit(1)
        code = _exit_code(child, tournament, Path(folder))
        if not _end_descendants() or code == _ERROR_SENT:
            return
        os.chdir("/")
        for place in writable:
            _remove_all_except(kept, place)
        os.write(out, protocol.line(ended=code))


def _serve_match(spec: str, into: int, out: int) -> NoReturn:
    """Speak the protocol in one match; an error of the agent is sent in one line, and its traceback printed."""
    # an END is still in the pipe if the last match's process ended before it read it
    hello = _read_line(into).removeprefix(protocol.END) or _read_line(into)
    try:
        policy = create_policy(spec, json.loads(hello)["side"])
    except AgentError as error:
        _report(error, out)
        os._exit(_ERROR_SENT)
    doing = "init"
    try:
        control = getattr(policy, "control", "target")
        sources, prey = sources_and_prey(spec)
        _send(out, protocol.line(control=control, sources=sources, prey=prey))
        if (line := _read_line(into)) not in _END_LINES:
            doing = "reset"
            message = json.loads(line)["reset"]
            limits = protocol.limits_in(message)
            policy.reset(message["seed"])
            _send(out, protocol.line(ready=True))
            doing = "act"
            while (line := _read_line(into)) not in _END_LINES:
                seen = msgspec.json.decode(line)
                action = policy.act(limits.view(seen["view"], seen["mask"]))  # type: ignore[arg-type]  # its limits are of its side
                _send(out, protocol.action_line(action))
    except BaseException as error:  # noqa: BLE001 - a stranger's code may raise anything
        _print(error)
        _send(out, protocol.line(error=f"{doing} raised {reason(error)}"))
        os._exit(_ERROR_SENT)
    _flush()
    os._exit(0)


def _become_command(command: list[str], into: int, out: int) -> NoReturn:
    for number, file in enumerate((into, out)):
        os.dup2(file, number)
    os.closerange(3, max(into, out) + 1)
    for usual in (signal.SIGPIPE, signal.SIGXFSZ, signal.SIGTERM):  # Python ignores or handles them
        signal.signal(usual, signal.SIG_DFL)
    try:
        os.execv(command[0], command)  # noqa: S606 - no shell is wanted
    except OSError as error:
        hint = "; a script's first line must name its interpreter, such as #!/bin/sh"
        why = f"{error.strerror}{hint if error.errno == errno.ENOEXEC else ''}"
        os.write(1, protocol.line(error=f"{command[0]}: cannot be started: {why}"))
    os._exit(1)


def _confine(quotas: Quotas, *, namespaced: bool) -> None:
    """Limit the memory, files and processes of this process and of those that it starts."""
    with suppress(OSError):  # when the machine has no memory left, agents are ended first
        Path("/proc/self/oom_score_adj").write_text("1000")
    _prctl(_SET_CHILD_SUBREAPER, 1)
    if LINUX:  # this limit does not apply to root
        with suppress(OSError, IndexError, ValueError):  # without /proc the number of tasks is unknown
            # all of this machine, an upper bound for those of the user
            tasks = 0 if namespaced else int(Path("/proc/loadavg").read_text().split()[3].partition("/")[2])
            _limit(resource.RLIMIT_NPROC, quotas.processes + tasks)
    _limit(resource.RLIMIT_DATA, quotas.memory_mib * _MIB)
    _limit(resource.RLIMIT_AS, _ADDRESSES * quotas.memory_mib * _MIB)
    _limit(resource.RLIMIT_NOFILE, quotas.open_files)
    _limit(resource.RLIMIT_FSIZE, quotas.file_mib * _MIB)
    _limit(resource.RLIMIT_CORE, 0)


def _limit_cpu(seconds: int) -> None:
    _limit(resource.RLIMIT_CPU, seconds, spare=1)  # SIGXCPU comes before SIGKILL, and shows the reason


def _limit(kind: int, amount: int, spare: int = 0) -> None:
    _, hard = resource.getrlimit(kind)
    most = amount + spare if hard == resource.RLIM_INFINITY else min(amount + spare, hard)
    with suppress(ValueError, OSError):  # macOS knows some limits by name only
        resource.setrlimit(kind, (min(amount, most), most))


def _clean_up_and_exit(folder: Path | None, code: int = 0) -> NoReturn:
    """End this process, and without namespaces all processes that it started; remove its folder."""
    try:
        if folder is not None:
            _end_descendants()
            shutil.rmtree(folder, ignore_errors=True)
    finally:
        os._exit(code)


def _end_after_parent(parent: int, folder: Path) -> None:
    """End this process and all that it started when its parent ends or sends SIGTERM; then remove its folder."""
    signal.signal(signal.SIGTERM, lambda *_: _clean_up_and_exit(folder))
    _prctl(_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:  # the parent ended before the call
        _clean_up_and_exit(folder)


def _prctl(option: int, value: int) -> None:
    if LINUX:
        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)


def _exit_code(child: int, tournament: int, folder: Path) -> int:
    """Wait for the child and return its exit code; other processes that end meanwhile are reaped too.

    Systems like macOS send no signal when the tournament's process ends; then this function removes the folder, and
    ends this process with all of its group.
    """
    while True:
        ended, status = os.waitpid(-1, 0 if LINUX else os.WNOHANG)
        if ended == child:
            return os.waitstatus_to_exitcode(status)
        if ended == 0 and os.getppid() != tournament:
            shutil.rmtree(folder, ignore_errors=True)
            os.killpg(0, signal.SIGKILL)
        elif ended == 0:
            time.sleep(_PAUSE_S)


def _end_descendants() -> bool:
    """End all descendants of this process that the system lists; return False if some do not end in time."""
    deadline = time.monotonic() + _CLEAN_S
    while time.monotonic() < deadline:
        pids: list[str] = []
        for children in Path("/proc/self/task").glob("*/children"):
            with suppress(OSError):  # the thread has ended
                pids += children.read_text().split()
        if not pids:
            return True
        for pid in pids:  # their own children become this process's
            os.kill(int(pid), signal.SIGKILL)
        for _ in pids:
            os.waitpid(-1, 0)
    return False


def _enter_folder(folder: Path) -> None:
    folder.mkdir(mode=0o700, exist_ok=True)
    os.chdir(folder)
    os.environ["HOME"] = os.environ["TMPDIR"] = os.environ["PWD"] = str(folder)


def _contents_of(folder: Path) -> Iterator[Path]:
    """Yield the files and folders in a folder, with those in its subfolders; links and mounts are not entered."""
    for entry in folder.iterdir():
        yield entry
        if not entry.is_symlink() and entry.is_dir() and not entry.is_mount():
            yield from _contents_of(entry)


def _remove_all_except(kept: Collection[Path], folder: Path) -> None:
    """Empty a folder, except for `kept`; if that fails the program ends, and the next one has new folders."""
    for path in reversed([*_contents_of(folder)]):  # a folder comes after its contents
        if path not in kept:
            path.rmdir() if path.is_dir() and not path.is_symlink() else path.unlink()


def _report(error: AgentError, out: int) -> None:
    if error.__cause__ is not None:
        _print(error.__cause__)
    _send(out, protocol.line(error=str(error)))


def _print(error: BaseException) -> None:
    """Print a traceback to the agent's log, from the agent's first line on."""
    agent_traceback = error.__traceback__
    while agent_traceback is not None and _calls_agents(agent_traceback.tb_frame.f_code.co_filename):
        agent_traceback = agent_traceback.tb_next
    # sys.stderr may be closed, or be anything
    with suppress(OSError), os.fdopen(2, "w", errors="backslashreplace", closefd=False) as log:
        traceback.print_exception(type(error), error, agent_traceback, file=log)


def _calls_agents(file: str) -> bool:
    """Return whether a file imports or calls agents, and so stands above their own lines in a traceback."""
    return file.startswith("<frozen importlib") or file in {importlib.__file__, loading.__file__, __file__}


def _read_line(into: int) -> bytes:
    """Read a line and return it, empty at the end of the pipe; the other side sends nothing after a line."""
    line = b""
    while not line.endswith(b"\n") and (part := os.read(into, protocol.PART)):
        line += part
    return line


def _send(out: int, line: bytes) -> None:
    while line:
        line = line[os.write(out, line) :]


def _flush() -> None:
    for stream in (sys.stdout, sys.stderr):
        with suppress(Exception):  # an agent may have closed or replaced it
            stream.flush()
