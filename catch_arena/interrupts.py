"""Ctrl-C, SIGTERM and a closed terminal: the first signal ends a command in order, a second one immediately.

The first signal raises KeyboardInterrupt in the main thread; the command saves its results, and ends its processes.
Both print one line, exit with code 130 (143 for SIGTERM, 129 for a closed terminal), and end all descendants.

This module imports little, since a signal before `listen` prints a traceback.
"""

import atexit
import os
import signal
import sys
import time
from contextlib import suppress

TYPE_CHECKING = False  # not imported from typing, which takes long to load
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import NoReturn

LINUX = sys.platform == "linux"
_LONG_S = 3600.0
_GRACE_S = 0.5
_PAUSE_S = 0.002
_SET_CHILD_SUBREAPER = 36  # option of Linux's prctl
_WORDS = {"SIGINT": "interrupted", "SIGTERM": "terminated", "SIGHUP": "hung up"}


class _Command:
    """State of the command that this process runs."""

    status = 2  # exit code; until the command has ended, the one for an unexpected error
    first_signal = 0  # its number, or 0
    is_running = False  # the command is running, so KeyboardInterrupt can be raised
    is_waiting = False  # an interrupt is the command's normal end
    is_saving = False  # the command is saving results, so an interrupt waits
    more: "Callable[[], str]" = str


def listen() -> None:
    """Install the signal handlers. A signal that was ignored when the process started stays ignored."""
    for name in _WORDS:
        if (number := getattr(signal, name, None)) and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _on_signal)
    atexit.register(_exit)  # registered first, so called last


def run(command: "Callable[[], object]") -> "NoReturn":
    """Run a command as the whole process, after `listen`; exit with the status that it returns or exits with."""
    status: object = None
    try:
        try:
            _Command.is_running = True
            status = command()
        finally:
            _Command.is_running = False
    except SystemExit as exit_:
        status = exit_.code
    except BaseException:
        if not _Command.first_signal:
            raise
    if _Command.first_signal:  # also if the command has caught the interrupt
        _flush()
        _end()
    _Command.status = status if isinstance(status, int) else int(status is not None)
    sys.exit(status)  # type: ignore[arg-type]


def run_until_signal(last: "Callable[[], object]") -> None:
    """Call `last`; a signal ends it as the command's normal end, with exit code 0."""
    _Command.is_waiting = True
    try:
        with suppress(KeyboardInterrupt):
            last()
    finally:
        _Command.is_waiting = False


def wait(announce: "Callable[[], object]") -> None:
    """Call `announce`, and then wait for a signal: the command's normal end, with exit code 0."""

    def last() -> None:
        announce()
        while True:
            time.sleep(_LONG_S)

    run_until_signal(last)


def run_uninterrupted(save: "Callable[[], object]") -> None:
    """Call `save`; an interrupt during the call is raised after it."""
    before, _Command.is_saving = _Command.first_signal, True
    try:
        save()
    finally:
        _Command.is_saving = False
    if _Command.first_signal != before:
        raise KeyboardInterrupt


def was_interrupted() -> bool:
    """Return whether a signal has arrived; errors after it need no report."""
    return bool(_Command.first_signal)


def add_to_message(more: "Callable[[], str]") -> None:
    """Append the text that `more` returns to the line that is printed after a signal."""
    _Command.more = more


def descendants(*roots: int) -> set[int]:
    """Return the ids of the running descendants of these processes; empty if the system does not list processes."""
    children: dict[int, list[int]] = {}
    for name in os.listdir("/proc") if LINUX else ():  # noqa: PTH208 - pathlib takes long to import
        with suppress(OSError, ValueError), open(f"/proc/{name}/stat", "rb", buffering=0) as file:  # noqa: PTH123
            state, parent, *_ = file.read().rpartition(b")")[2].split()
            if state not in {b"Z", b"X"}:
                children.setdefault(int(parent), []).append(int(name))
    found = list(roots)
    for parent in found:  # `found` grows during the loop
        found += children.get(parent, ())
    return {*found} - {*roots}


def _on_signal(number: int, _: object) -> None:
    if _Command.first_signal:
        _Command.status = 128 + _Command.first_signal  # not a normal end any more, since the command was still busy
        _end()
    _Command.first_signal, _Command.status = number, 0 if _Command.is_waiting else 128 + number
    # a destructor may swallow the interrupt; its other errors, and those of threads, are expected from now on
    sys.unraisablehook = lambda error: _end() if error.exc_type is KeyboardInterrupt else None
    if (threading := sys.modules.get("threading")) is not None:
        threading.excepthook = lambda _: None  # type: ignore[attr-defined]
    if _Command.is_running and not _Command.is_saving:
        raise KeyboardInterrupt
    if not _Command.is_saving:
        _end()


def _end() -> "NoReturn":
    """End this process and all its descendants, without Python's work at exit."""
    try:
        _end_descendants()
        if _Command.status:
            line, more = f"catch-arena: {_WORDS[signal.Signals(_Command.first_signal).name]}", ""
            with suppress(Exception):  # the line is printed in any case
                more = _Command.more()
            before = "\r\x1b[K\x1b[?25h" if os.isatty(2) else ""  # show a hidden cursor again
            os.write(2, f"{before}{line}{more and ': '}{more}\n".encode(errors="backslashreplace"))
    finally:
        os._exit(_Command.status)


def _end_descendants() -> None:
    """End all descendants of this process: first by SIGTERM, a moment later by SIGKILL."""
    if not LINUX:
        return
    with suppress(Exception):  # ctypes may be half imported
        from ctypes import CDLL

        CDLL(None).prctl(_SET_CHILD_SUBREAPER, 1)  # descendants whose parent ends become children of this process
    for number in (signal.SIGTERM, signal.SIGKILL):
        deadline = time.monotonic() + _GRACE_S
        while (left := descendants(os.getpid())) and time.monotonic() < deadline:
            for pid in left:
                with suppress(OSError):  # the process has just ended
                    os.kill(pid, number)
            time.sleep(_PAUSE_S)
    with suppress(OSError):  # no child is left
        while os.waitpid(-1, os.WNOHANG)[0]:  # after this process the system may take a moment to collect them
            pass


def _flush() -> bool:
    """Return whether all output could be written."""
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except Exception:  # noqa: BLE001 - a full disk, a closed pipe, or no stdout
        return False
    return True


def _exit() -> None:
    """End without the cleanup of modules, which takes long and ignores signals."""
    if _flush():  # otherwise Python tries again, and prints the error
        os._exit(_Command.status)
