"""What the processes of one agent hold together: how many they are, how much memory, how many files in memory.

The kernel bounds each process; the supervisor looks at all of one agent, some times a second.
"""

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Final

from catch_arena.descendants import family
from catch_arena.tournament.isolation.limits import AgentLimits

_MEMORY: Final = ("RssAnon:", "RssShmem:", "VmSwap:")
_TOGETHER: Final = 2
"""Memory of all, for each byte that one may have: a page that processes share, since they were forked, counts for each.
"""
_KIB_IN_MIB: Final = 1024
_FILES: Final = 65_536
"""In a folder in memory: an empty one takes up about 1 KiB, which no other limit counts."""


def exceeded(root: int, limits: AgentLimits, in_memory: Iterable[Path] = ()) -> str | None:
    """Which limit a process and its descendants exceed together, in words; None if none, and where the system does not
    show that.

    Args:
        root: the process.
        limits: an agent's.
        in_memory: folders as that process sees them, which lie in memory.
    """
    tasks = memory_kib = 0
    for pid in _members(root):
        facts = _status(pid)
        tasks += facts.get("Threads:", 0)
        memory_kib += sum(facts.get(name, 0) for name in _MEMORY)
        if tasks > limits.processes:
            return f"it had more than {limits.processes} processes and threads (processes)"
        if memory_kib > _TOGETHER * limits.memory_mib * _KIB_IN_MIB:
            return f"its processes together held more than twice {limits.memory_mib} MiB (memory_mib)"
    for folder in in_memory:
        try:
            found = os.statvfs(f"/proc/{root}/root{folder}")
        except OSError:  # it has just ended
            break
        if found.f_files - found.f_ffree > _FILES:
            return f"it made more than {_FILES} files"
    return None


def _members(root: int) -> Iterator[int]:
    """A process and its descendants, as far as they can be seen while they come and go."""
    if not _children_are_listed():
        yield from (root, *family(root))
        return
    waiting = [root]
    while waiting:
        pid = waiting.pop()
        yield pid
        waiting += children(pid)


def children(pid: int) -> set[int]:
    """Those of a process, as far as they can be seen while they come and go."""
    found: set[int] = set()
    with suppress(OSError):  # it has just ended, or the system does not say
        for thread in Path(f"/proc/{pid}/task").iterdir():
            found |= set(map(int, (thread / "children").read_text().split()))
    return found


@cache
def _children_are_listed() -> bool:
    return Path(
        f"/proc/self/task/{os.getpid()}/children"
    ).exists()  # CONFIG_PROC_CHILDREN; much quicker than all of /proc


def _status(pid: int) -> dict[str, int]:
    """The whole numbers that are told of a process."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text(errors="replace").splitlines()
    except OSError:  # it has just ended
        return {}
    words = [line.split() for line in lines]
    return {word[0]: int(word[1]) for word in words if len(word) > 1 and word[1].isdecimal()}
