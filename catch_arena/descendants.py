"""Descendants of this process, and how they are ended. Only Linux lists them."""

import os
import signal
import sys
import time
from collections.abc import Iterable
from contextlib import suppress
from typing import Final

LINUX: Final = sys.platform == "linux"
_GRACE_S: Final = 0.5
_PAUSE_S: Final = 0.002


def family(*roots: int) -> set[int]:
    """Return the living descendants of these processes, without themselves; empty if the system does not tell."""
    return set(_by_generation(roots)) - {*roots}


def end_all() -> None:
    """End all that descend from this process: first by SIGTERM, a moment later by SIGKILL.

    Parents come first: one that waits for its child, and then goes on, would start another.
    """
    for number in (signal.SIGTERM, signal.SIGKILL) if LINUX else ():
        for pid in _by_generation([os.getpid()])[1:]:
            _send(pid, number)
        patience = time.monotonic() + _GRACE_S
        while family(os.getpid()) and time.monotonic() < patience:
            time.sleep(_PAUSE_S)


def _parent_of(pid: int) -> int | None:
    """Return the id of a process's parent; None if the process has ended."""
    try:
        with open(f"/proc/{pid}/stat", "rb", buffering=0) as file:  # noqa: PTH123 - read for each process there is
            state, parent, *_ = file.read().rpartition(b")")[2].split()
    except (OSError, ValueError):  # it has just ended
        return None
    return None if state in {b"Z", b"X"} else int(parent)


def _by_generation(roots: Iterable[int]) -> list[int]:
    """Return these processes and their living descendants, parents before their children."""
    children: dict[int, list[int]] = {}
    for entry in os.scandir("/proc") if LINUX else ():
        if entry.name.isdigit() and (parent := _parent_of(int(entry.name))) is not None:
            children.setdefault(parent, []).append(int(entry.name))
    found = dict.fromkeys(roots)
    generation = list(found)
    while generation:
        generation = [child for parent in generation for child in children.get(parent, ()) if child not in found]
        found |= dict.fromkeys(generation)
    return list(found)


def _send(pid: int, number: int) -> None:
    with suppress(OSError):  # it has just ended
        os.kill(pid, number)
