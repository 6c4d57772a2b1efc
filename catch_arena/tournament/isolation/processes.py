"""What the operating system offers to hold a family of processes together; Linux offers most."""

import ctypes
import os
import resource
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Final

from catch_arena.descendants import LINUX, family, kill_all, parent_of, send, session_of, state
from catch_arena.tournament.isolation.limits import AgentLimits

# <linux/prctl.h>
_SET_PDEATHSIG: Final = 1
_SET_CHILD_SUBREAPER: Final = 36
_GET_CHILD_SUBREAPER: Final = 37
_SET_NO_NEW_PRIVS: Final = 38

_MIB: Final = 1 << 20
_FREEZE_S: Final = 10.0
_PAUSE_S: Final = 0.0002
_ADDRESSES: Final = 4
"""Addresses that a process may use for each byte of its private memory: libraries map much that they never touch."""


def missing_protections() -> tuple[str, ...]:
    """What this system cannot do for isolated agents, a line each; empty on Linux."""
    if LINUX:
        return ()
    return (
        f"{sys.platform}: a process that an agent starts in a session of its own may outlive the match",
        f"{sys.platform}: the limit on memory may not be enforced",
        f"{sys.platform}: agents may outlive a tournament that is killed, until they next read or write",
    )


class Freezer:
    """Makes a process stand still, and all that descends from it; and go on.

    Args:
        root: that process.
    """

    def __init__(self, root: int) -> None:
        self._root = root
        self._found = {root}
        self._still: set[int] = set()
        """Those of them who live, and stand still."""
        self._newest = 0
        """The newest process of the system when they were looked for: who is not older was started since."""

    def freeze(self) -> bool:
        """Return when nobody runs any more; false where some do not obey."""
        patience = time.monotonic() + _FREEZE_S
        obeyed: set[int] = set()
        while True:
            self._look()
            if obeyed >= self._found:
                return True
            for pid in self._found - obeyed:
                send(pid, signal.SIGSTOP)
            # twice the same: whoever has just ended may have taken another with him
            before, stopped = None, self._stopped()
            while stopped is None or stopped != before:
                if time.monotonic() > patience:
                    return False
                time.sleep(_PAUSE_S)
                before, stopped = stopped, self._stopped()
            self._still = stopped
            obeyed |= self._found

    def lost(self) -> int | None:
        """One who should stand still and does not: it has been killed, from that moment on, or told to go on. The first
        one of all is lost too where it had ended before.
        """
        return next((pid for pid in (self._root, *self._still) if state(pid) != "T"), None)

    def thaw(self) -> None:
        """Let them go on."""
        for pid in self._found:
            send(pid, signal.SIGCONT)

    def _look(self) -> None:
        """Find those who have come since the last time: looking at all processes takes longer than most moves."""
        newest, before = _newest_process(), self._newest
        if before == 0 or newest < before:
            self._found = {self._root, *family(self._root)}
        for pid in range(before + 1, newest + 1) if before else ():
            if parent_of(pid) in self._found:
                self._found.add(pid)
        self._newest = newest

    def _stopped(self) -> set[int] | None:
        """Those who stand still; None while somebody runs: who is not stopped has ended, or waits for its disk."""
        states = {pid: state(pid) for pid in self._found}
        if not set(states.values()) <= {"", "D", "T", "X", "Z"}:
            return None
        return {pid for pid, one in states.items() if one == "T"}


@contextmanager
def no_newcomers_left() -> Iterator[None]:
    """What agents have left under this process in the meantime is killed at the end: as of `kill_newcomers`."""
    before, adopts = family(os.getpid()), ctypes.c_int()
    if LINUX:
        ctypes.CDLL(None).prctl(_GET_CHILD_SUBREAPER, ctypes.byref(adopts), 0, 0, 0)
    adopt_orphans()
    try:
        yield
    finally:
        kill_newcomers(before)
        _prctl(_SET_CHILD_SUBREAPER, adopts.value)


def kill_newcomers(before: set[int]) -> None:
    """Kill all that has come to descend from this process, orphans that it adopted included, but for those who did
    `before`, and for its own session: agents' processes have others, and cannot enter it.
    """
    doomed: set[int] = set()
    ours = os.getsid(0)

    def newcomers() -> set[int]:
        found = {pid for pid in family(os.getpid()) - before if session_of(pid) not in {0, ours}}
        doomed.update(found)
        return found

    kill_all(newcomers)
    for pid in doomed:
        with suppress(ChildProcessError):  # another's child
            os.waitpid(pid, os.WNOHANG)


def adopt_orphans() -> None:
    """Make this process the parent of every descendant that loses its own."""
    _prctl(_SET_CHILD_SUBREAPER, 1)


def die_with(parent: int) -> None:
    """Have this process killed when its parent, that process, ends, however it ends."""
    _prctl(_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it ended before the call
        os._exit(1)


def confine(limits: AgentLimits) -> None:
    """Limits on memory, files and privileges, for this process and those that it starts."""
    _prctl(_SET_NO_NEW_PRIVS, 1)
    _limit(resource.RLIMIT_DATA, limits.memory_mib * _MIB)
    _limit(resource.RLIMIT_AS, _ADDRESSES * limits.memory_mib * _MIB)
    _limit(resource.RLIMIT_NOFILE, limits.open_files)
    _limit(resource.RLIMIT_FSIZE, limits.file_mib * _MIB)
    _limit(resource.RLIMIT_CORE, 0)


def limit_cpu(seconds: int) -> None:
    """A limit on this process's CPU time, from its start."""
    _limit(resource.RLIMIT_CPU, seconds, spare=1)  # SIGXCPU comes before SIGKILL, and says why


def how_it_ended(code: int) -> str:
    """An exit code in words; one less than 0 is a signal."""
    if code >= 0:
        return f"its process exited with code {code}"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
    return "its process used up its CPU time (cpu_s)" if name == "SIGXCPU" else f"its process was ended by {name}"


def _newest_process() -> int:
    """The id that the system gave last, to a process or a thread; 0 where nobody knows."""
    try:
        with open("/proc/loadavg", "rb", buffering=0) as file:  # noqa: PTH123 - read twice in each turn of an agent
            return int(file.read().split()[-1])
    except OSError:
        return 0


def _limit(what: int, amount: int, spare: int = 0) -> None:
    _, hard = resource.getrlimit(what)
    most = amount + spare if hard == resource.RLIM_INFINITY else min(amount + spare, hard)
    with suppress(ValueError, OSError):  # macOS knows some limits by name only
        resource.setrlimit(what, (min(amount, most), most))


def _prctl(option: int, value: int) -> None:
    if LINUX:
        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)
