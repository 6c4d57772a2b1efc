"""Line that is printed while the rules are compiled, since it takes seconds."""

import gc
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache, partial
from typing import Final

from catch_arena.core.cache_folder import CACHE_DIRECTORY, on_miss
from catch_arena.core.modes import COMPILER, INTERPRETED

ARBITER_S, COMMON_S, ALL_S = (1, 5, 7) if COMPILER else (2, 20, 25)
"""Approximate compile time of the arbiter alone, of the common rules, and of all [s], on a machine of 2025."""
_KEPT: Final = (
    "kept for later starts"
    if CACHE_DIRECTORY and os.access(CACHE_DIRECTORY, os.W_OK)
    else "again at every start, unless NUMBA_CACHE_DIR names a folder that can be written"
)


@cache
def _announce(rules: str, seconds: int) -> None:
    """Print the line, once in a process."""
    sys.stderr.write(
        f"catch_arena: compiling {rules}: about {seconds} s, and longer on a slow or busy machine; {_KEPT}\n"
    )


@contextmanager
def announced(rules: str, seconds: int) -> Iterator[None]:
    """Print one line if something is compiled in this context, with the garbage collector off: it would scan the
    compiler's many objects again and again. `seconds` is the approximate compile time.
    """
    announce = partial(_announce, rules, seconds)
    if CACHE_DIRECTORY is None and not INTERPRETED:
        announce()
    on_miss.append(announce)
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        on_miss.remove(announce)
        if enabled:
            gc.enable()
