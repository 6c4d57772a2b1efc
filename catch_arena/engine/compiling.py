"""The rules are compiled once a process, and people are told how long it takes, and how far it is."""

import gc
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, Final

from numba.core import event

from catch_arena.core.compiler import quick_typing
from catch_arena.core.jit import CACHE_DIRECTORY, INNER, INTERPRETED

_QUIET_S: Final = 1.0
"""Nothing is said of what is over sooner."""
_FRAME_S: Final = 0.2
_LINE_S: Final = 10.0
"""How often a line is printed where there is no terminal to draw a bar in."""
_INNER_SHARE: Final = 0.6
"""Of the time to compile: the rules and phases one by one. Then LLVM works on all of them together."""
_ENOUGH: Final = 0.2
"""Of the rules and phases: what it takes to judge this machine's speed."""
_FIRST_GUESS_S: Final = 20.0
"""Said where nothing is known of this machine yet."""
_WHAT: Final = "catch_arena: compiling the rules for this machine"
_OFTEN: Final = (
    "once" if CACHE_DIRECTORY else "at every start, unless NUMBA_CACHE_DIR names a folder that can be written"
)
_NOTE: Final = None if CACHE_DIRECTORY is None else CACHE_DIRECTORY.parent / "compiling-took"
"""How long it took here the last time [s]: whatever the state of the sources, it will be much the same."""
_compiled: set[str] = set()
"""What is, in this process."""


def compile_once(what: str, play: Callable[[], None]) -> None:
    """Compile, or load from the cache, all that `play` calls, where it has not been done yet under that name; and say
    so where it takes long.
    """
    if INTERPRETED or what in _compiled:
        return
    _compiled.add(what)  # first, since `play` may come here too
    with (
        progress_shown(),
        quick_typing(),
        _without_garbage_collection(),  # which would look at the compiler's many objects again and again
    ):
        play()


@contextmanager
def _without_garbage_collection() -> Iterator[None]:
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


class CompileClock(event.Listener):
    """How long compiling takes. It hears of each function that Numba compiles, and of none that comes from its cache:
    nobody else knows for certain what is kept for this Python, this Numba and this processor.

    Args:
        inner: the names of the functions that are compiled before those that call them.
        total_s: how long it took the last time, or None.
    """

    def __init__(self, inner: set[str], total_s: float | None) -> None:
        self._inner = inner
        self._done: set[str] = set()
        self._known = total_s is not None
        self._total_s = _FIRST_GUESS_S if total_s is None else total_s
        self._began_s: float | None = None

    def on_start(self, event: object) -> None:
        """Something is compiled."""
        del event
        if self._began_s is None:
            self._began_s = time.monotonic()

    def on_end(self, event: Any) -> None:
        """One function more."""
        self._done |= self._inner & {event.data["dispatcher"].py_func.__qualname__}
        share = len(self._done) / max(1, len(self._inner))
        late = self.elapsed_s > self._total_s  # others are at work on the machine
        if (late or not self._known) and share >= _ENOUGH:
            self._total_s = self.elapsed_s / (share * _INNER_SHARE)

    @property
    def elapsed_s(self) -> float:
        """Since the first function; 0 as long as nothing is compiled."""
        return 0.0 if self._began_s is None else time.monotonic() - self._began_s

    @property
    def total_s(self) -> float:
        """As well as it is known by now, and never less than has gone by."""
        return max(self._total_s, self.elapsed_s)


@contextmanager
def progress_shown() -> Iterator[None]:
    """Whoever waits for the compiler in this block reads how long, on the standard error stream."""
    clock = CompileClock(INNER, _last_time_s())
    over = threading.Event()
    teller = threading.Thread(target=_tell, args=(clock, over), daemon=True)
    teller.start()
    try:
        with event.install_listener("numba:compile", clock):
            yield
        _remember(clock.elapsed_s)
    finally:
        over.set()
        teller.join()


def _tell(clock: CompileClock, over: threading.Event) -> None:
    while clock.elapsed_s < _QUIET_S:
        if over.wait(_FRAME_S):
            return
    if sys.stderr.isatty():
        _draw(clock, over)
        return
    sys.stderr.write(f"{_WHAT} ({_OFTEN}; about {clock.total_s:.0f} s)\n")
    while not over.wait(_LINE_S):
        sys.stderr.write(f"{_WHAT}: {clock.elapsed_s:.0f} of about {clock.total_s:.0f} s\n")


def _draw(clock: CompileClock, over: threading.Event) -> None:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    console = Console(stderr=True)
    console.print(f"{_WHAT} ({_OFTEN})", highlight=False, soft_wrap=True)
    columns = BarColumn(bar_width=24), TextColumn("{task.description}")
    with Progress(*columns, console=console, auto_refresh=False, transient=True) as bar:
        task = bar.add_task("")
        while True:
            elapsed, total = clock.elapsed_s, clock.total_s
            text = f"{elapsed:.0f} of about {total:.0f} s"
            bar.update(task, total=total, completed=elapsed, description=text, refresh=True)
            if over.wait(_FRAME_S):
                return


def _last_time_s() -> float | None:
    with suppress(OSError, ValueError, AttributeError):  # of _NOTE, where nothing can be kept
        return float(_NOTE.read_text(encoding="ascii"))  # type: ignore[union-attr]
    return None


def _remember(took_s: float) -> None:
    if took_s >= _QUIET_S and _NOTE is not None:
        with suppress(OSError):
            _NOTE.write_text(f"{took_s:.1f}\n", encoding="ascii")
