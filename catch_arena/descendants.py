"""Descendants of this process, and how they are ended. Only Linux lists them."""

import os
import signal
import sys
import time

LINUX = sys.platform == "linux"
_GRACE_S = 0.5
_PAUSE_S = 0.002


def family(*roots: int) -> set[int]:
    """Return the living descendants of these processes, without themselves; empty if the system does not list them."""
    children: dict[int, list[int]] = {}
    for name in os.listdir("/proc") if LINUX else ():  # noqa: PTH208 - pathlib takes long to import
        try:
            with open(f"/proc/{name}/stat", "rb", buffering=0) as file:  # noqa: PTH123
                state, parent, *_ = file.read().rpartition(b")")[2].split()
            if state not in {b"Z", b"X"}:
                children.setdefault(int(parent), []).append(int(name))
        except (OSError, ValueError):  # it is no process, or has just ended
            continue
    found = list(roots)
    for parent in found:  # it grows meanwhile
        found += children.get(parent, ())
    return {*found} - {*roots}


def end_all() -> None:
    """End all that descend from this process: first by SIGTERM, a moment later by SIGKILL."""
    for number in (signal.SIGTERM, signal.SIGKILL) if LINUX else ():
        patience = time.monotonic() + _GRACE_S
        while (left := family(os.getpid())) and time.monotonic() < patience:
            for pid in left:
                try:  # noqa: SIM105 - contextlib may be half imported
                    os.kill(pid, number)
                except OSError:  # it has just ended
                    pass
            time.sleep(_PAUSE_S)
