"""What the operating system offers to hold a family of processes together; Linux offers most."""

import ctypes
import os
import re
import resource
import signal
import sys
from contextlib import suppress
from pathlib import Path
from typing import Final

from catch_arena.descendants import LINUX
from catch_arena.tournament.isolation.forbidden_calls import forbid_calls
from catch_arena.tournament.isolation.limits import AgentLimits

# <linux/prctl.h>
_SET_PDEATHSIG: Final = 1
_SET_DUMPABLE: Final = 4
_SET_CHILD_SUBREAPER: Final = 36
_SET_NO_NEW_PRIVS: Final = 38

_MIB: Final = 1 << 20
_COUNTED_BY_NAMESPACE: Final = (5, 14)
"""Since this version of Linux a user's processes are counted apart in each user namespace."""
_SPARE_TASKS: Final = 1024
"""Where they are not: how many more processes and threads the machine may have before an agent can start no more."""
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


def close_to_others() -> None:
    """Keep other processes of the same user from this one's memory and open files, and from those of its forks; a
    program that one of them becomes is open again. Root is not kept from anything.
    """
    _prctl(_SET_DUMPABLE, 0)


def confine(limits: AgentLimits, *, namespaced: bool) -> None:
    """Limits on memory, files, processes and privileges, for this process and those that it starts.

    Args:
        limits: an agent's.
        namespaced: whether it is in a user namespace of its own.
    """
    with suppress(OSError):  # where the machine's memory ends, agents are ended first
        Path("/proc/self/oom_score_adj").write_text("1000")
    close_to_others()
    _prctl(_SET_NO_NEW_PRIVS, 1)
    forbid_calls()
    _limit(resource.RLIMIT_NPROC, _most_tasks(limits, namespaced=namespaced))  # root is not held by it
    _limit(resource.RLIMIT_DATA, limits.memory_mib * _MIB)
    _limit(resource.RLIMIT_AS, _ADDRESSES * limits.memory_mib * _MIB)
    _limit(resource.RLIMIT_NOFILE, limits.open_files)
    _limit(resource.RLIMIT_FSIZE, limits.file_mib * _MIB)
    _limit(resource.RLIMIT_CORE, 0)


def limit_cpu(seconds: int) -> None:
    """A limit on this process's CPU time, from its start."""
    _limit(resource.RLIMIT_CPU, seconds, spare=1)  # SIGXCPU comes before SIGKILL, and says why


def _most_tasks(limits: AgentLimits, *, namespaced: bool) -> int:
    """How many processes and threads the user may have for an agent to start one more."""
    if not LINUX:
        return resource.getrlimit(resource.RLIMIT_NPROC)[1]
    if namespaced and tuple(map(int, re.findall(r"\d+", os.uname().release)[:2])) >= _COUNTED_BY_NAMESPACE:
        return limits.processes
    tasks = Path("/proc/loadavg").read_text().split()[3].partition("/")[2]
    return int(tasks) + _SPARE_TASKS


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
