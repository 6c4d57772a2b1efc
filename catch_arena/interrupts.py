"""Ctrl-C, SIGTERM and a closed terminal: the first ends a command in order, a second one ends it immediately.

The first signal raises KeyboardInterrupt in the main thread; the command keeps what it has, and ends its processes.
Both end with one line and exit code 130 (143 for SIGTERM, 129 for a closed terminal), and leave no process behind.

Little is imported here, since a signal before `listen` is a traceback.
"""

import atexit
import os
import signal
import sys
import time

TYPE_CHECKING = False  # as typing says, which takes 10 ms to load
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import NoReturn

LINUX = sys.platform == "linux"
_LONG_S = 3600.0
_GRACE_S = 0.5
_PAUSE_S = 0.002
_WORDS = {"SIGINT": "interrupted", "SIGTERM": "terminated", "SIGHUP": "hung up"}


class _Command:
    """State of the command that this process runs."""

    status = 2  # exit code; until the command has ended, that of an unexpected error
    heard = 0  # the first signal, or 0
    unwinds = False  # from the begin of the command to its end: an interrupt can be raised
    lingers = False  # an interrupt is the command's normal end
    keeps = False  # it saves what must not be lost: an interrupt waits
    more: "Callable[[], str]" = str


def listen() -> None:
    """Handle signals from here on. A signal that is ignored when the process starts stays so."""
    for name in _WORDS:
        if (number := getattr(signal, name, None)) and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _hear)
    atexit.register(_exit)  # the first that is registered is the last that is called


def run(command: "Callable[[], object]") -> "NoReturn":
    """Run this as the whole of the process, after `listen`; exit with what it returns or exits with."""
    status: object = None
    try:
        try:
            _Command.unwinds = True
            status = command()
        finally:
            _Command.unwinds = False
    except SystemExit as exit_:
        status = exit_.code
    except BaseException:
        if not _Command.heard:
            raise
    if _Command.heard:  # whatever the command has made of it
        _flush()
        _end()
    _Command.status = status if isinstance(status, int) else int(status is not None)
    sys.exit(status)  # type: ignore[arg-type]


def linger(last: "Callable[[], object]") -> None:
    """Call `last`; a signal ends it, and is the normal end of the command: its exit code is 0."""
    _Command.lingers = True
    try:
        last()
    except KeyboardInterrupt:
        pass
    finally:
        _Command.lingers = False


def wait(tell: "Callable[[], object]") -> None:
    """Call `tell`, and wait for a signal, which is the normal end of the command."""

    def last() -> None:
        tell()
        while True:
            time.sleep(_LONG_S)

    linger(last)


def keep(save: "Callable[[], object]") -> None:
    """Call `save`; an interrupt is raised after it."""
    before, _Command.keeps = _Command.heard, True
    try:
        save()
    finally:
        _Command.keeps = False
    if _Command.heard != before:
        raise KeyboardInterrupt


def received() -> bool:
    """Return whether a signal has come: what fails from then on is no news."""
    return bool(_Command.heard)


def also_say(more: "Callable[[], str]") -> None:
    """Add this to the line that is printed if a signal comes."""
    _Command.more = more


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


def _hear(number: int, _: object) -> None:
    if _Command.heard:
        _Command.status = 128 + _Command.heard  # the command had more to do, although the first was its normal end
        _end()
    _Command.heard, _Command.status = number, 0 if _Command.lingers else 128 + number
    sys.unraisablehook = _swallowed
    if (threading := sys.modules.get("threading")) is not None:
        threading.excepthook = lambda _: None  # type: ignore[attr-defined]
    if _Command.unwinds and not _Command.keeps:
        raise KeyboardInterrupt
    if not _Command.keeps:
        _end()


def _swallowed(what: "sys.UnraisableHookArgs") -> None:
    """End if a destructor or a callback from C has swallowed the interrupt; print nothing."""
    if what.exc_type is KeyboardInterrupt:
        _end()


def _end() -> "NoReturn":
    """End this process and all that descends from it, without what Python does at its exit."""
    try:
        _end_family()
        if _Command.status:
            line = f"catch-arena: {_WORDS[signal.Signals(_Command.heard).name]}"
            try:
                more = _Command.more()
            except Exception:  # noqa: BLE001 - the line is printed in any case
                more = ""
            before = "\r\x1b[K\x1b[?25h" if os.isatty(2) else ""  # a cursor that was hidden comes back
            os.write(2, f"{before}{line}{more and ': '}{more}\n".encode(errors="backslashreplace"))
    finally:
        os._exit(_Command.status)


def _end_family() -> None:
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


def _flush() -> bool:
    """Return whether all output could be written."""
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except Exception:  # noqa: BLE001 - a full disk, a reader that has gone, no stdout at all
        return False
    return True


def _exit() -> None:
    """End without taking modules down, which would take half a second and hear no signal."""
    if _flush():  # else Python tries it again, and says why it cannot
        os._exit(_Command.status)
