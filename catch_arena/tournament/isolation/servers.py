"""One entrant's fork server, from the supervisor's side: how it is started, watched and ended."""

import fcntl
import json
import os
import select
import shutil
import signal
import socket
import sys
import time
from collections.abc import Collection
from contextlib import suppress
from typing import BinaryIO, Final

from catch_arena.descendants import LINUX, family, kill_all
from catch_arena.tournament.isolation import fork_server
from catch_arena.tournament.isolation.control_groups import AgentGroup
from catch_arena.tournament.isolation.group_watch import exceeded, too_much_memory
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.namespaces import PROGRAM, WRITABLE, bubblewrap_words
from catch_arena.tournament.isolation.processes import die_with
from catch_arena.tournament.isolation.visible_files import visible_files

_START_S: Final = 5.0
"""How long bubblewrap may take to say which process is the first in its namespaces."""
_STOP_S: Final = 5.0
_OPTIONS, _INFO = 3, 4
_FIRST_FREE: Final = 10
_PART: Final = 4096
_IN_GROUP: Final = ("/bin/sh", "-c", 'echo 0 >"$0" && exec "$@"')
"""A program that becomes another one in the group whose door is named first: bubblewrap's first fork is in it too."""
_MAIN: Final = f"import sys; sys.path[:] = sys.argv[1:]; from {fork_server.__name__} import main; main()"


class Server:
    """A fork server that runs.

    Args:
        pid: its process; where it has namespaces of its own, the one that made them.
        limits: its agent's.
        group: its control group, where it has one.
        inner: the first process in these namespaces.
    """

    def __init__(self, pid: int, limits: AgentLimits, group: AgentGroup | None, inner: int | None = None) -> None:
        self.pid = pid
        self.pids = {pid} if inner is None else {pid, inner}
        """Those that live on from match to match."""
        self._excess: str | None = None
        self._limits = limits
        self._group = group
        self._inner = inner

    def excess(self) -> str | None:
        """The limit for which it was ended, in words; None if it was not."""
        if self._excess is None and self._group is not None and self._group.excess():
            self._excess = too_much_memory(self._limits)
        return self._excess

    def look(self) -> None:
        """End it where all its processes together take too much."""
        if self.excess() is None:
            root, in_memory = (self.pid, ()) if self._inner is None else (self._inner, WRITABLE)
            self._excess = exceeded(root, self._limits, in_memory)
            if self._excess is not None:
                self.end()

    def end(self) -> bool:
        """End it and all that descends from it; false where some would not go."""
        if not LINUX:
            self.end_group()
            return True
        if self._group is not None:
            self._group.kill()
        doomed: set[int] = set()
        patience = time.monotonic() + _STOP_S
        while (more := self._family() - doomed) and time.monotonic() < patience:
            for pid in more:  # what stands still starts no others; with the first process all in its namespaces end
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL if pid == self._inner else signal.SIGSTOP)
            doomed |= more
        ended = kill_all(lambda: family(os.getpid()) & doomed)
        if self._group is not None:
            self._group.remove()
        return ended

    def _family(self) -> set[int]:
        """Itself and its descendants, but none that has got its number since it ended."""
        return family(os.getpid()) & {self.pid, *family(self.pid)}

    def end_group(self) -> None:
        """End its group: all but those who left its session."""
        with suppress(ProcessLookupError, PermissionError):  # macOS says the latter of the dead
            os.killpg(self.pid, signal.SIGKILL)


def fork_it(channel: int, limits: AgentLimits, group: AgentGroup | None, ours: Collection[int]) -> Server:
    """A fork server that is only a process.

    Args:
        channel: its socket.
        limits: its agent's.
        group: its control group, where it has one.
        ours: the files of this process that it must not have.
    """
    supervisor = os.getpid()
    pid = os.fork()
    if pid:
        return Server(pid, limits, group)
    try:
        die_with(supervisor)
        if group is not None:
            group.door.write_text("0")
        for usual in (signal.SIGCHLD, signal.SIGTERM):
            signal.signal(usual, signal.SIG_DFL)
        os.setsid()
        null = os.open(os.devnull, os.O_RDWR)
        for standard in (0, 1, 2):
            os.dup2(null, standard)
        for file in (null, *ours):
            if file > 2:
                os.close(file)
        fork_server.serve(socket.socket(fileno=channel))
    finally:
        os._exit(0)


def start_in_namespaces(channel: int, errors: int, spec: str, limits: AgentLimits, group: AgentGroup | None) -> Server:
    """A fork server in namespaces of its own.

    Args:
        channel: its socket.
        errors: where bubblewrap says why it fails.
        spec: its agent's.
        limits: its agent's.
        group: its control group, where it has one.

    Raises:
        OSError: where bubblewrap cannot be started.
    """
    words = bubblewrap_words(visible_files(spec, limits.entrants, limits.hidden), limits.file_mib << 20)
    program = [shutil.which(PROGRAM) or PROGRAM, "--args", f"{_OPTIONS}", "--info-fd", f"{_INFO}", "--"]
    program += [sys.executable, "-c", _MAIN, *sys.path]
    if group is not None:
        program = [*_IN_GROUP, str(group.door), *program]
    options = os.memfd_create("options")
    info_read, info_write = os.pipe()
    null = os.open(os.devnull, os.O_RDWR)
    ends = [
        fcntl.fcntl(file, fcntl.F_DUPFD_CLOEXEC, _FIRST_FREE) for file in (channel, null, errors, options, info_write)
    ]
    try:
        os.write(options, b"".join(os.fsencode(word) + b"\0" for word in words))
        os.lseek(options, 0, os.SEEK_SET)
        pid = os.posix_spawn(
            program[0],
            program,
            os.environ,
            file_actions=[(os.POSIX_SPAWN_DUP2, end, number) for number, end in enumerate(ends)],
            setsid=True,
            setsigdef=[signal.SIGCHLD, signal.SIGTERM],
        )
    except OSError:
        os.close(info_read)
        raise
    finally:
        for file in (options, info_write, null, *ends):
            os.close(file)
    with os.fdopen(info_read, "rb") as info:
        return Server(pid, limits, group, _first_process(info))


def _first_process(info: BinaryIO) -> int | None:
    """Its id, as bubblewrap tells it; None where it fails."""
    said = b""
    while select.select([info], [], [], _START_S)[0] and (part := os.read(info.fileno(), _PART)):
        said += part
    try:
        return int(json.loads(said)["child-pid"])
    except ValueError:
        return None
