"""Control groups (cgroup v2): where a part of their tree is delegated to us, the kernel bounds each agent's processes
together, with all the memory that it holds for them.

    systemd-run --user --scope -p Delegate=yes catch-arena tournament ...

Sources: the Linux kernel's "Control Group v2" (Documentation/admin-guide/cgroup-v2.rst), and "Control Group APIs and
Delegation" of systemd, which marks what it delegates by an extended attribute since version 251.
"""

import os
import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Final

from catch_arena.descendants import LINUX
from catch_arena.tournament.isolation.limits import AgentLimits

MOUNT: Final = Path("/sys/fs/cgroup")
TOGETHER: Final = 2
"""Memory that all processes of an agent may hold, for each byte that one may have."""
_CONTROLLERS: Final = {"memory", "pids"}
_MARKS: Final = ("user.delegate", "trusted.delegate")
_OURS: Final = "catch-arena-ours"
"""The group of those that were in the delegated one: it may have no processes of its own, since its groups are bounded.
"""
_AGENT: Final = re.compile(r"catch-arena-(\d+)-\d+")
_SPARE_TASKS: Final = 64
"""Over an agent's limit: whoever passes that is ended, which says more than that a fork fails."""
_TRIES: Final = 20
"""To move all of a group's processes out of it, as others may start meanwhile."""


def delegated_group(mount: Path = MOUNT, membership: Path = Path("/proc/self/cgroup")) -> Path | None:
    """The nearest group above this process in which it may make others, with bounds on memory and processes.

    Args:
        mount: where the tree of groups is.
        membership: what tells this process's place in it.

    Returns:
        its folder, or None where there is none: another system, the older version of control groups, or nothing that is
        delegated.
    """
    if not LINUX:
        return None
    try:
        lines = membership.read_text().splitlines()
    except OSError:
        return None
    for place in (line.removeprefix("0::") for line in lines if line.startswith("0::/")):
        own = mount / place.lstrip("/")
        for group in (own, *own.parents):
            if not group.is_relative_to(mount):
                break
            if _is_marked(group) or _is_root(group):
                return group if _is_usable(group) else None
    return None


class AgentGroup:
    """The control group of one entrant's processes.

    Args:
        folder: its own.
    """

    def __init__(self, folder: Path) -> None:
        self.door = folder / "cgroup.procs"
        """A process that writes 0 there is in the group, with all that it starts from then on."""
        self._folder = folder

    def excess(self) -> bool:
        """Whether the kernel has ended its processes, since they held more memory than they may."""
        try:
            events = dict(line.split() for line in (self._folder / "memory.events").read_text().splitlines())
        except OSError:
            return False
        return int(events.get("oom_kill", 0)) > 0

    def kill(self) -> None:
        """Kill all its processes at once."""
        with suppress(OSError):  # Linux before 5.14 has no such file
            (self._folder / "cgroup.kill").write_text("1")

    def remove(self) -> None:
        """Remove it, if all its processes have ended."""
        with suppress(OSError):
            self._folder.rmdir()


class ControlGroups:
    """Where this process makes groups for agents.

    Args:
        folder: the delegated group.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._made = 0

    @classmethod
    def here(cls) -> "ControlGroups | None":
        """Those of this machine, made ready; None where nothing is delegated to us, or it fails."""
        folder = delegated_group()
        if folder is None:
            return None
        try:
            _make_ready(folder)
        except OSError:
            return None
        return cls(folder)

    def make(self, limits: AgentLimits) -> AgentGroup:
        """A group for an agent with these limits.

        Raises:
            OSError: where it cannot be made.
        """
        self._made += 1
        folder = self._folder / f"catch-arena-{os.getpid()}-{self._made}"
        folder.mkdir()
        files_mib = 2 * limits.file_mib if limits.level == "namespaces" else 0  # it writes to two folders in memory
        (folder / "memory.max").write_text(str((TOGETHER * limits.memory_mib + files_mib) << 20))
        (folder / "memory.oom.group").write_text("1")
        (folder / "pids.max").write_text(str(limits.processes + _SPARE_TASKS))
        with suppress(OSError):  # a kernel that counts no swapped memory
            (folder / "memory.swap.max").write_text("0")
        return AgentGroup(folder)


def _is_marked(group: Path) -> bool:
    for mark in _MARKS:
        with suppress(OSError):  # only root reads the second
            if os.getxattr(group, mark) == b"1":
                return True
    return False


def _is_root(group: Path) -> bool:
    """Whether it is that of the whole machine, which alone may have processes beside bounded groups; a container sees
    its own group in that place, and whoever enters the container later could not.
    """
    return (group / "cgroup.controllers").exists() and not (group / "cgroup.type").exists()


def _is_usable(group: Path) -> bool:
    try:
        controllers = set((group / "cgroup.controllers").read_text().split())
    except OSError:
        return False
    files = (group, group / "cgroup.procs", group / "cgroup.subtree_control")
    return controllers >= _CONTROLLERS and all(os.access(file, os.W_OK) for file in files)


def _make_ready(group: Path) -> None:
    """Let the groups in it be bounded, and remove those of processes that were killed.

    Raises:
        OSError: where that fails.
    """
    for folder, maker in _agents_groups(group):
        if not Path(f"/proc/{maker}").exists():
            AgentGroup(folder).remove()
    control = group / "cgroup.subtree_control"
    wanted = " ".join(f"+{name}" for name in sorted(_CONTROLLERS))
    if _is_root(group):
        control.write_text(wanted)
        return
    ours = group / _OURS
    ours.mkdir(exist_ok=True)
    for left in reversed(range(_TRIES)):
        for pid in (group / "cgroup.procs").read_text().split():
            with suppress(ProcessLookupError):
                (ours / "cgroup.procs").write_text(pid)
        try:
            control.write_text(wanted)
        except OSError:  # a process has come meanwhile
            if left == 0:
                raise
        else:
            return


def _agents_groups(group: Path) -> Iterator[tuple[Path, int]]:
    """The groups of agents in it, and the process that made each."""
    for folder in group.iterdir():
        if match := _AGENT.fullmatch(folder.name):
            yield folder, int(match[1])
