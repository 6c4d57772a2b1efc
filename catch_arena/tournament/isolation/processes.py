"""What the operating system offers to hold a family of processes together; Linux offers most."""

import ctypes
import os
import resource
import signal
import sys
from contextlib import suppress
from typing import Final

from catch_arena.descendants import LINUX
from catch_arena.tournament.isolation.limits import AgentLimits

# <linux/prctl.h>
_SET_PDEATHSIG: Final = 1
_SET_CHILD_SUBREAPER: Final = 36
_SET_NO_NEW_PRIVS: Final = 38

_MIB: Final = 1 << 20
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


def _limit(what: int, amount: int, spare: int = 0) -> None:
    _, hard = resource.getrlimit(what)
    most = amount + spare if hard == resource.RLIM_INFINITY else min(amount + spare, hard)
    with suppress(ValueError, OSError):  # macOS knows some limits by name only
        resource.setrlimit(what, (min(amount, most), most))


def _prctl(option: int, value: int) -> None:
    if LINUX:
        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)
