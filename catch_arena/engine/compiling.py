"""The rules are compiled once in a process; a line says so, as it takes seconds."""

import gc
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final, NamedTuple

from numba.core import event

from catch_arena.core.cache import CACHE_DIRECTORY
from catch_arena.core.compiler import INTERPRETED

_COMMON_S: Final = 5
_ALL_S: Final = 7
"""Seconds that compiling takes on a machine of 2025, about."""
_KEPT: Final = (
    "kept for later starts"
    if CACHE_DIRECTORY
    else "again at every start, unless NUMBA_CACHE_DIR names a folder that can be written"
)


class Variant(NamedTuple):
    """What of `tick.run` is compiled."""

    batch: bool
    """True for many arenas, false for one."""
    options: bool
    """True for `state.ALL_OPTIONS`, false for the common rules."""

    def __str__(self) -> str:
        rules = "all rules" if self.options else "the common rules"
        return f"{rules} for {'a batch' if self.batch else 'one arena'}"


_compiled: Final[set[Variant]] = set()
"""Variants that are compiled in this process."""
_begun: Final[set[Variant]] = set()
"""Variants that are being compiled; a second thread waits for Numba's own lock."""


def compile_once(variant: Variant, play: Callable[[], None]) -> None:
    """Compile, or load from the cache, all that `play` calls, unless this was done before; say so if it is compiled."""
    if INTERPRETED or variant in _compiled or variant in _begun:
        return
    _begun.add(variant)
    try:
        with event.install_listener("numba:compile", _Announcer(variant)), _without_garbage_collection():
            play()
    finally:
        _begun.discard(variant)
    _compiled.add(variant)


class _Announcer(event.Listener):
    """Prints one line when Numba compiles its first function, and none if all come from the cache."""

    def __init__(self, variant: Variant) -> None:
        self._line = (
            f"catch_arena: compiling {variant}: about {_ALL_S if variant.options else _COMMON_S} s, and longer on a "
            f"slow or busy machine; {_KEPT}\n"
        )

    def on_start(self, event: object) -> None:
        """Print the line, once."""
        del event
        line, self._line = self._line, ""
        sys.stderr.write(line)

    def on_end(self, event: object) -> None:
        """Print nothing."""


@contextmanager
def _without_garbage_collection() -> Iterator[None]:
    """The collector would look at the compiler's many objects again and again."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
