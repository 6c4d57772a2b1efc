"""What the processes of one agent hold together: how many they are, how much memory, how many files in memory.

The kernel bounds each process; the supervisor looks at all of one agent, some times a second.
"""

import math
import os
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Final

from catch_arena.descendants import family
from catch_arena.tournament.isolation.control_groups import TOGETHER
from catch_arena.tournament.isolation.limits import AgentLimits

_MEMORY: Final = ("RssAnon:", "VmSwap:", "VmPTE:")
_KIB_IN_MIB: Final = 1024
_BYTES_IN_KIB: Final = 1024
_SHARED: Final = re.compile(rb"^(\w+)-(\w+) \S\S\Ss (\w+) (\S+ \d+) +/dev/zero \(deleted\)$", re.MULTILINE)
"""A line of /proc/<pid>/maps for memory without a file that forks share: begin, end, offset, and which memory it is."""
_MAPS_BYTES: Final = 32 << 20
"""What is read of such lines; ordinary processes have some 100 kB."""
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
    tasks = own_kib = addresses_kib = 0
    shared_kib = 0.0
    most_kib = TOGETHER * limits.memory_mib * _KIB_IN_MIB
    pids: list[int] = []
    for pid in _members(root):
        pids.append(pid)
        facts = _status(pid)
        tasks += facts.get("Threads:", 0)
        own_kib += sum(facts.get(name, 0) for name in _MEMORY)
        shared_kib += facts.get("RssShmem:", 0)
        addresses_kib += facts.get("VmSize:", 0)
        if tasks > limits.processes:
            return f"it had more than {limits.processes} processes and threads (processes)"
        if own_kib + shared_kib > most_kib:
            break
    if own_kib + shared_kib <= most_kib < addresses_kib:  # a process may hold what it shares without having it at hand
        shared_kib = max(shared_kib, _shared_kib(pids))
    if own_kib + shared_kib > most_kib:
        return too_much_memory(limits)
    for folder in in_memory:
        try:
            found = os.statvfs(f"/proc/{root}/root{folder}")
        except OSError:  # it has just ended
            break
        if found.f_files - found.f_ffree > _FILES:
            return f"it made more than {_FILES} files"
    return None


def too_much_memory(limits: AgentLimits) -> str:
    """That an agent's processes held more memory together than they may."""
    return f"its processes together held more than twice {limits.memory_mib} MiB (memory_mib)"


def _shared_kib(pids: Iterable[int]) -> float:
    """How large all memory is that these processes share among each other, as far as their maps may be read; infinite
    where these are too long to be read.
    """
    ends: dict[bytes, int] = {}
    left = _MAPS_BYTES
    for pid in pids:
        try:
            with Path(f"/proc/{pid}/maps").open("rb") as file:
                maps = file.read(left)
        except OSError:  # it has just ended, or may not be looked into
            continue
        left -= len(maps)
        if left == 0:
            return math.inf
        for begin, end, offset, which in _SHARED.findall(maps):
            ends[which] = max(ends.get(which, 0), int(offset, 16) + int(end, 16) - int(begin, 16))
    return sum(ends.values()) / _BYTES_IN_KIB


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
