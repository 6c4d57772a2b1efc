"""What agents leave behind that have killed the process above them: orphans, who would escape."""

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Final

from catch_arena.descendants import LINUX, family, kill_all, session_of
from catch_arena.tournament.isolation.processes import adopt_orphans

# <linux/prctl.h>
_SET_CHILD_SUBREAPER: Final = 36
_GET_CHILD_SUBREAPER: Final = 37


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
        if LINUX:
            ctypes.CDLL(None).prctl(_SET_CHILD_SUBREAPER, adopts.value, 0, 0, 0)


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
