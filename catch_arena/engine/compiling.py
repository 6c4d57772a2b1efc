"""Compilation of the rules, once in a process, with a printed line, since it takes seconds."""

import gc
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final, NamedTuple

from catch_arena.core.cache import CACHE_DIRECTORY, on_miss
from catch_arena.core.compiler import INTERPRETED

_COMMON_S: Final = 5
_ALL_S: Final = 7
"""Approximate compile time on a machine of 2025 [s]."""
_KEPT: Final = (
    "kept for later starts"
    if CACHE_DIRECTORY
    else "again at every start, unless NUMBA_CACHE_DIR names a folder that can be written"
)


class Variant(NamedTuple):
    """Part of `tick.run` that is compiled."""

    batch: bool
    """True for many arenas, false for one."""
    options: bool
    """True for `state.ALL_OPTIONS`, false for the common rules."""

    def __str__(self) -> str:
        rules = "all rules" if self.options else "the common rules"
        return f"{rules} for {'a batch' if self.batch else 'one arena'}"


_compiled: Final[set[Variant]] = set()
"""Variants that are compiled in this process, or are being compiled; a second thread waits for Numba's own lock."""


def compile_once(variant: Variant, play: Callable[[], None]) -> None:
    """Compile, or load from the cache, all that `play` calls, once in a process; print a line if it is compiled."""
    if INTERPRETED or variant in _compiled:
        return
    _compiled.add(variant)
    try:
        with _announced(variant), _without_garbage_collection():
            play()
    except BaseException:
        _compiled.discard(variant)
        raise


@contextmanager
def _announced(variant: Variant) -> Iterator[None]:
    """Print one line when the first function is compiled, and none if all come from the cache."""
    seconds = _ALL_S if variant.options else _COMMON_S
    lines = [f"catch_arena: compiling {variant}: about {seconds} s, and longer on a slow or busy machine; {_KEPT}\n"]

    def announce() -> None:
        if lines:
            sys.stderr.write(lines.pop())

    if CACHE_DIRECTORY is None:
        announce()
    on_miss.append(announce)
    try:
        yield
    finally:
        on_miss.remove(announce)


@contextmanager
def _without_garbage_collection() -> Iterator[None]:
    """Switch the garbage collector off: it would scan the compiler's many objects again and again."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
