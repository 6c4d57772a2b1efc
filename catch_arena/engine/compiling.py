"""The rules are compiled once a process, and people are told how long it takes, and how far it is."""

import gc
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, ClassVar, Final, NamedTuple

from numba.core import event

from catch_arena.core.compiler import quick_typing
from catch_arena.core.jit import CACHE_DIRECTORY, INTERPRETED

if TYPE_CHECKING:
    from rich.console import Console

_QUIET_S: Final = 1.0
"""Nothing is said of what is over sooner."""
_FRAME_S: Final = 0.2
_LINE_S: Final = 5.0
"""How often a line is printed where there is no terminal to draw a bar in."""
_SAMPLE: Final = 30
"""Functions: what it takes to judge this machine's speed."""
_SAMPLE_S: Final = 0.34
"""How long the second to the last of them take on the machine on which `_Usual` was measured."""
_KEPT: Final = (
    "kept for later starts"
    if CACHE_DIRECTORY
    else "again at every start, unless NUMBA_CACHE_DIR names a folder that can be written"
)


class _Usual(NamedTuple):
    """How long it takes where a sample takes `_SAMPLE_S`."""

    first_s: float
    """Where nothing has been compiled in this process yet."""
    later_s: float
    """After another variant, which shares many functions with this one."""


_COMMON: Final = _Usual(first_s=3.8, later_s=2.2)
_ALL: Final = _Usual(first_s=5.6, later_s=3.5)


class Variant(NamedTuple):
    """What of `tick.run` is compiled."""

    batch: bool
    """For many arenas, or for one."""
    options: bool
    """Whether with `state.ALL_OPTIONS`."""

    def __str__(self) -> str:
        rules = "all rules" if self.options else "the common rules"
        return f"{rules} for {'a batch' if self.batch else 'one arena'}"


_compiled: Final[set[Variant]] = set()
"""What is, in this process."""
_begun: Final[set[Variant]] = set()
"""What is being compiled."""


def compile_once(variant: Variant, play: Callable[[], None]) -> None:
    """Compile, or load from the cache, all that `play` calls, where that has not been done yet for this variant; and
    say so where it takes long.
    """
    if INTERPRETED or variant in _compiled:
        return
    with quick_typing():  # here a thread waits for another one
        if variant in _compiled or variant in _begun:  # the other thread has done it, or this is called by `play`
            return
        _begun.add(variant)
        try:
            with (
                progress_shown(variant),
                _without_garbage_collection(),  # which would look at the compiler's many objects again and again
            ):
                play()
        finally:
            _begun.remove(variant)
        _compiled.add(variant)


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
    """

    pace: ClassVar[float | None] = None
    """How many times as long as usual it takes on this machine, as far as is known; None until the first functions
    have told.
    """

    def __init__(self, variant: Variant) -> None:
        usual = _ALL if variant.options else _COMMON
        self._usual_s = usual.first_s if self.pace is None else usual.later_s
        self._functions = 0
        self._began_s: float | None = None
        self._sample_began_s = 0.0

    def on_start(self, event: object) -> None:
        """Something is compiled."""
        del event
        if self._began_s is None:
            self._began_s = time.monotonic()

    def on_end(self, event: object) -> None:
        """One function more."""
        del event
        self._functions += 1
        if self._functions == 1:  # before it Numba has imported what it needs, which says nothing of the rest
            self._sample_began_s = self.elapsed_s
        elif self._functions == _SAMPLE and self.pace is None:
            CompileClock.pace = (self.elapsed_s - self._sample_began_s) / _SAMPLE_S

    def finish(self) -> None:
        """All is compiled, which tells more than the first functions of how long the next variant will take."""
        if self.elapsed_s > _QUIET_S:
            CompileClock.pace = self.elapsed_s / self._usual_s

    @property
    def elapsed_s(self) -> float:
        """Since the first function; 0 as long as nothing is compiled."""
        return 0.0 if self._began_s is None else time.monotonic() - self._began_s

    @property
    def total_s(self) -> float | None:
        """How long it will take; None until that is known, and then the same to the end."""
        return None if self.pace is None else self._usual_s * self.pace


@contextmanager
def progress_shown(variant: Variant) -> Iterator[None]:
    """Whoever waits for the compiler in this block reads how long, on the standard error stream."""
    clock = CompileClock(variant)
    over = threading.Event()
    teller = threading.Thread(target=_tell, args=(variant, clock, over), daemon=True)
    teller.start()
    try:
        with event.install_listener("numba:compile", clock):
            yield
    finally:
        over.set()
        teller.join()
    clock.finish()


def _tell(variant: Variant, clock: CompileClock, over: threading.Event) -> None:
    while (total_s := clock.total_s) is None or clock.elapsed_s < _QUIET_S:
        if over.wait(_FRAME_S):
            return
    sys.stderr.write(f"catch_arena: compiling {variant} (about {total_s:.0f} s; {_KEPT})\n")
    if sys.stderr.isatty():
        from rich.console import Console

        console = Console(stderr=True)
        if not console.is_dumb_terminal:
            _draw(console, clock, total_s, over)
            return
    while not over.wait(_LINE_S):
        sys.stderr.write(f"catch_arena: compiling: {_told(clock.elapsed_s, total_s)}\n")


def _draw(console: "Console", clock: CompileClock, total_s: float, over: threading.Event) -> None:
    from rich.progress import BarColumn, Progress, TextColumn

    columns = BarColumn(bar_width=24), TextColumn("{task.description}")
    with Progress(*columns, console=console, auto_refresh=False, transient=True) as bar:
        task = bar.add_task("", total=total_s)
        while True:
            elapsed_s = clock.elapsed_s
            bar.update(task, completed=elapsed_s, description=_told(elapsed_s, total_s), refresh=True)
            if over.wait(_FRAME_S):
                return


def _told(elapsed_s: float, total_s: float) -> str:
    if round(elapsed_s) <= round(total_s):
        return f"{elapsed_s:.0f} of about {total_s:.0f} s"
    return f"{elapsed_s:.0f} s instead of about {total_s:.0f}"
