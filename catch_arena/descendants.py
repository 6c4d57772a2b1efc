"""The processes that descend from this one: their start, who they are, and their end.

Only Linux says who descends from whom.
"""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Collection, Iterable
from pathlib import Path
from typing import Any, Final

LINUX: Final = sys.platform == "linux"
_PATIENCE_S: Final = 10.0
_GRACE_S: Final = 0.5
_PAUSE_S: Final = 0.002
_LOOKS, _BETWEEN_LOOKS_S = 3, 0.0002


def start(module: str, channel: int, **options: Any) -> subprocess.Popen[bytes]:
    """A process that runs the `main` of a module of ours, with the same modules to import as this one.

    It has a session of its own, so that Ctrl-C is for this process alone.

    Args:
        module: what it runs, by its full name; it has a function `main`.
        channel: a socket, which is its standard input.
        options: more of those of Popen.

    Raises:
        OSError: where no process can be started.
    """
    code = f"import sys; sys.path[:] = sys.argv[1:]; from {module} import main; main()"
    path = [str(Path(entry).absolute()) for entry in (*sys.path, "")]
    return subprocess.Popen(  # noqa: S603 - our own module
        [sys.executable, "-c", code, *path], stdin=channel, start_new_session=True, **options
    )


def family(*roots: int) -> set[int]:
    """The living descendants of these processes, themselves left out; empty where the system does not say."""
    return set(_by_generation(*roots)) - {*roots}


def _by_generation(*roots: int) -> list[int]:
    """These processes and their living descendants, parents before their children."""
    children: dict[int, list[int]] = {}
    for entry in os.scandir("/proc") if LINUX else ():
        if entry.name.isdigit() and (parent := parent_of(int(entry.name))) is not None:
            children.setdefault(parent, []).append(int(entry.name))
    found = dict.fromkeys(roots)
    generation = list(roots)
    while generation:
        generation = [child for parent in generation for child in children.get(parent, ()) if child not in found]
        found |= dict.fromkeys(generation)
    return list(found)


def kill_all(doomed: Callable[[], Iterable[int]], patience_s: float = _PATIENCE_S) -> bool:
    """Kill until none is left, as they may start others meanwhile; false where some would not go."""
    patience = time.monotonic() + patience_s
    while pids := list(doomed()):
        for pid in pids:
            send(pid, signal.SIGKILL)
        if time.monotonic() > patience:
            return False
        time.sleep(0.0005)
    return True


def end(roots: Collection[int]) -> None:
    """End these processes and all that descend from them: they are asked to, and killed a moment later.

    Parents are asked first: one that waits for its child, and then goes on, would start another.
    """
    doomed = _by_generation(*roots)
    for pid in doomed:
        send(pid, signal.SIGTERM)
    patience = time.monotonic() + _GRACE_S
    while (left := list(filter(_lives, doomed))) and time.monotonic() < patience:
        time.sleep(_PAUSE_S)

    def living() -> list[int]:
        nonlocal left
        left = list(filter(_lives, _by_generation(*left)))  # once its parent is dead, nobody else knows of a process
        return left

    kill_all(living, _GRACE_S)


def state(pid: int) -> str:
    """A process's state, as proc(5) has it, `T` for one that was stopped (SIGSTOP); empty where nobody knows, `Z` or
    empty where it has ended.
    """
    return (_stat(pid) or [b""])[0].decode()


def is_stopped(pid: int) -> bool:
    """Whether a process stands still, or is told to and has not had its turn on a busy machine yet.

    It is looked at more than once: for a moment it has taken the signal, and its state does not say so yet.
    """
    for _ in range(_LOOKS):
        if _looks_stopped(pid):
            return True
        time.sleep(_BETWEEN_LOOKS_S)
    return False


def _looks_stopped(pid: int) -> bool:
    try:
        status = Path(f"/proc/{pid}/status").read_text(errors="replace")
    except OSError:
        return False
    fields = dict(line.split(":", 1) for line in status.splitlines() if ":" in line)
    pending = int(fields["SigPnd"], 16) | int(fields["ShdPnd"], 16)
    return fields["State"].split()[0] == "T" or bool(pending >> (signal.SIGSTOP - 1) & 1)


def session_of(pid: int) -> int:
    """The session that a process belongs to; 0 where nobody knows."""
    stat = _stat(pid)
    return int(stat[3]) if stat else 0


def end_all() -> None:
    """End all that descend from this process."""
    end(_by_generation(os.getpid())[1:])


def _lives(pid: int) -> bool:
    return parent_of(pid) is not None if LINUX else send(pid, 0)


def parent_of(pid: int) -> int | None:
    """None where the process has ended, though it may not be buried."""
    stat = _stat(pid)
    return None if not stat or stat[0] in {b"Z", b"X"} else int(stat[1])


def _stat(pid: int) -> list[bytes]:
    """What the system tells of a process, from its state on; empty where there is none, or where it tells nothing."""
    try:
        with open(f"/proc/{pid}/stat", "rb", buffering=0) as file:  # noqa: PTH123 - read for each process there is
            return file.read().rpartition(b")")[2].split()
    except OSError:  # it has just ended
        return []


def send(pid: int, number: int) -> bool:
    """Send a signal; whether there was a process of ours to take it."""
    try:
        os.kill(pid, number)
    except OSError:
        return False
    return True
