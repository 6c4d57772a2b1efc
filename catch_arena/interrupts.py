"""Ctrl-C, SIGTERM and a closed terminal: the first signal ends a command in order, a second one immediately.

The first signal raises KeyboardInterrupt in the main thread; the command saves its results, and ends its processes.
Both print one line, exit with code 130 (143 for SIGTERM, 129 for a closed terminal), and end all descendants. This
module imports little, since a signal before `listen` prints a traceback.
"""

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
_GRACE_S = 0.5
_PAUSE_S = 0.002
_WORDS = {"SIGINT": "interrupted", "SIGTERM": "terminated", "SIGHUP": "hung up"}


class _Command:
    """State of the command that this process runs."""

    status = 0  # exit code after a signal
    first_signal = 0  # its number, or 0
    is_running = False  # the command is running, so KeyboardInterrupt can be raised
    is_waiting = False  # an interrupt is the command's normal end
    more = ""  # end of the line about an interrupt


def listen() -> None:
    """Install the signal handlers. A signal that was ignored when the process started stays ignored."""
    for name in _WORDS:
        if (number := getattr(signal, name, None)) and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _on_signal)


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
    except BaseException:  # noqa: BLE001 - it is printed as Python prints it
        if not _Command.first_signal:
            sys.excepthook(*sys.exc_info())
            status = 2  # Python's own would be 1, which is the answer no
    if _Command.first_signal:  # also if the command has caught the interrupt
        with suppress(Exception):  # a full disk, a closed pipe, or no stdout
            sys.stdout.flush()
        _end()
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
            time.sleep(3600.0)

    run_until_signal(last)


def was_interrupted() -> bool:
    """Return whether a signal has arrived; errors after it need no report."""
    return bool(_Command.first_signal)


def add_to_message(more: str) -> None:
    """Append a text to the line that is printed after a signal."""
    _Command.more = f": {more}"


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
    if not _Command.is_running:
        _end()
    raise KeyboardInterrupt


def _end() -> "NoReturn":
    """End this process and all its descendants, without Python's work at exit."""
    try:
        if LINUX:
            _end_descendants()
        if _Command.status:
            line = f"catch-arena: {_WORDS[signal.Signals(_Command.first_signal).name]}{_Command.more}"
            before = "\r\x1b[K\x1b[?25h" if os.isatty(2) else ""  # show a hidden cursor again
            os.write(2, f"{before}{line}\n".encode(errors="backslashreplace"))
    finally:
        os._exit(_Command.status)


def _end_descendants() -> None:
    """End all descendants of this process: first by SIGTERM, a moment later by SIGKILL."""
    with suppress(Exception):  # another system, or a module is missing or half imported
        from ctypes import CDLL

        CDLL(None).prctl(36, 1)  # PR_SET_CHILD_SUBREAPER: descendants whose parent ends become our children
        # multiprocessing's own process, which ignores SIGTERM
        os.kill(sys.modules["multiprocessing.resource_tracker"]._resource_tracker._pid, signal.SIGKILL)  # noqa: SLF001
    for number in (signal.SIGTERM, signal.SIGKILL):
        deadline = time.monotonic() + _GRACE_S
        while (left := descendants(os.getpid())) and time.monotonic() < deadline:
            for pid in left:
                with suppress(OSError):  # the process has just ended
                    os.kill(pid, number)
            time.sleep(_PAUSE_S)
