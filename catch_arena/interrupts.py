"""Ctrl-C, SIGTERM and a terminal that is closed: however many there are, and whenever, a command ends within seconds,
with one line, and leaves no process behind.

The first one raises KeyboardInterrupt where the command stands; those that follow are ignored. What this unwinds has
_UNWIND_S. Then a watchdog ends the process, though it may stand in code that swallowed the interrupt, that waits for a
lock, or that hangs while it tidies up. It waits longer only for what `keep` saves. Before a command begins and after it
has ended there is nothing to unwind, and the first signal ends the process at once.

Nothing is imported here but what Python loads by itself, since a signal before `listen` is a traceback.
"""

import _signal  # type: ignore[import-not-found]  # what the module signal is made of; that one takes 10 ms to load
import _thread
import atexit
import os
import sys
import time

TYPE_CHECKING = False  # as typing says, which takes 10 ms too
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import NoReturn

_UNWIND_S = 1.5
_KEEP_S = 60.0
"""How long saving may take, on a machine however busy."""
_LOOK_S = 0.05
_END_S = 1.0
"""How long the end itself may take: of what descends from this process, and of the last line."""
_LONG_S = 3600.0
_WORDS = {_signal.SIGINT: "interrupted", _signal.SIGTERM: "terminated"}
if hasattr(_signal, "SIGHUP"):  # Windows has none
    _WORDS[_signal.SIGHUP] = "hung up"


class _Command:
    """What this process runs, and what it has heard."""

    def __init__(self) -> None:
        self.status = 2
        """The process's, if no signal is heard; until the command has ended that of an error nobody expects."""
        self.heard: int | None = None
        """The first signal."""
        self.unwinds = False
        """Whether an interrupt can be raised: not before the command begins, and not once it has ended."""
        self.waits = False
        """Whether an interrupt is the command's normal end."""
        self.keeps = False
        """Whether it saves what must not be lost: an interrupt waits."""
        self.more: Callable[[], str] | None = None
        self.end_descendants: Callable[[], None] | None = None
        self._alarm = -1
        self._last = _thread.allocate_lock()

    def listen(self) -> None:
        """Handle signals; a watchdog learns of each at once, though this thread may be busy in compiled code."""
        watched, self._alarm = os.pipe()
        _thread.start_new_thread(self._watch, (watched,))
        if os.name == "posix":
            os.set_blocking(self._alarm, False)
            _signal.set_wakeup_fd(self._alarm, warn_on_full_buffer=False)
        for number in _WORDS:
            if _signal.getsignal(number) is not _signal.SIG_IGN:
                _signal.signal(number, self._hear)

    def end(self) -> "NoReturn":
        """End this process, and all that descend from it, without what Python does at its exit."""
        if self._last.acquire(blocking=False):
            try:
                if self.end_descendants is not None:
                    self.end_descendants()
                if self.status:
                    _tell(self._line())
            finally:
                os._exit(self.status)
        while True:  # another thread is at it
            time.sleep(_END_S)

    def _hear(self, number: int, _: object) -> None:
        if self.heard is not None:
            return
        self._take(number)
        os.write(self._alarm, bytes((number,)))  # where it is not written without Python
        if self.keeps:
            return
        if not self.unwinds:
            self.end()
        raise KeyboardInterrupt

    def _watch(self, watched: int) -> None:
        while (number := os.read(watched, 1)[0]) not in _WORDS:
            pass
        begin_s = time.monotonic()
        while time.monotonic() < begin_s + (_KEEP_S if self.keeps else _UNWIND_S):
            time.sleep(_LOOK_S)
        if self._last.locked():  # the main thread is at it
            time.sleep(_END_S)
            os._exit(self.status)
        if self.heard is None:
            self._take(number)
        self.end()

    def _take(self, number: int) -> None:
        self.heard = number
        self.status = 0 if self.waits else 128 + number
        _silence()

    def _line(self) -> str:
        word = _WORDS[self.heard]
        try:
            return f"catch-arena: {word}: {self.more()}\n" if self.more else f"catch-arena: {word}\n"
        except Exception:  # noqa: BLE001 - the line is said in any case
            return f"catch-arena: {word}\n"


_command = _Command()


def listen() -> None:
    """From here on, a signal ends this process in order; one that it was started with as ignored stays so."""
    _command.listen()
    atexit.register(_exit)  # the first that is registered is the last that is called


def run(command: "Callable[[], object]") -> "NoReturn":
    """Run this as the whole of the process, after `listen`; exit with what it returns or exits with."""
    from catch_arena import descendants

    _command.end_descendants = descendants.end_all
    status: object = None
    try:
        try:
            _command.unwinds = True
            status = command()
        finally:
            _command.unwinds = False
    except SystemExit as exit_:
        status = exit_.code
    except BaseException:
        if _command.heard is None:
            raise
    if _command.heard is not None:  # whatever the command has made of it
        _flush()
        _command.end()
    _command.status = status if isinstance(status, int) else int(status is not None)
    sys.exit(status)  # type: ignore[arg-type]


def wait(tell: "Callable[[], object]") -> None:
    """Tell that only a signal is waited for, and wait: one that comes once that is told is the normal end of the
    command, whose status is then 0.
    """

    def last() -> None:
        tell()
        while True:
            time.sleep(_LONG_S)

    linger(last)


def linger(last: "Callable[[], object]") -> None:
    """Do what may be broken off: a signal ends it, and is the normal end of the command, whose status is then 0."""
    _command.waits = True
    try:
        last()
    except KeyboardInterrupt:
        pass
    finally:
        _command.waits = False


def keep(save: "Callable[[], object]") -> None:
    """Save what must not be lost: no signal breaks it off, and one that comes meanwhile is raised after it."""
    had_heard = _command.heard
    _command.keeps = True
    try:
        save()
    finally:
        _command.keeps = False
    if _command.heard != had_heard:
        raise KeyboardInterrupt


def received() -> bool:
    """Whether a signal has come: what fails from then on is no news."""
    return _command.heard is not None


def also_say(more: "Callable[[], str]") -> None:
    """What the line is to say besides, if a signal comes from here on; any thread may ask."""
    _command.more = more


def _silence() -> None:
    """Nobody is told what threads and destructors make of an interrupt that ends them."""

    def hook(_: object) -> None:
        pass

    sys.unraisablehook = hook
    if (threading := sys.modules.get("threading")) is not None:
        threading.excepthook = hook  # type: ignore[attr-defined]


def _tell(line: str) -> None:
    """Write to descriptor 2, as the thread that hangs may hold sys.stderr; a cursor that was hidden comes back."""
    try:  # noqa: SIM105 - contextlib may be half imported
        os.write(2, (("\r\x1b[K\x1b[?25h" if os.isatty(2) else "") + line).encode(errors="backslashreplace"))
    except OSError:
        pass  # nobody is there


def _flush() -> bool:
    """Whether all that was said could be written."""
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except Exception:  # noqa: BLE001 - a full disk, a reader that has gone, no stdout at all
        return False
    return True


def _exit() -> None:
    """The last that Python calls at its exit: taking its modules down would take half a second, and hear no signal."""
    if _flush():  # else Python tries it again, and tells why it cannot
        os._exit(_command.status)
