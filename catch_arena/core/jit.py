"""Decorators of the core's functions: rules, phases and entries, with Numba's flags.

No fast-math and no fused multiply-add: the same bits compiled and interpreted (R10.1). `error_model="numpy"` drops
the test for a zero divisor, which would keep loops from becoming SIMD code; no formula of ours divides by zero.
`_nrt=False`: the core makes no arrays, so nothing is counted and freed, and code for one arena runs a third faster.

`compiler` compiles the core as one piece, and `cache` stores it on the disk.
"""

import logging
from collections.abc import Callable
from functools import wraps
from typing import Any, Final, TypeVar, cast

import numba
import numba.extending
import numpy as np
from numpy.typing import NDArray

from catch_arena.core.cache import kept
from catch_arena.core.compiler import INTERPRETED, USABLE, OutlinedCompiler, PartCompiler, WholeCompiler

_logger = logging.getLogger("numba")
if _logger.level == logging.NOTSET:  # with the root logger at DEBUG each compilation writes megabytes
    _logger.setLevel(logging.WARNING)

F = TypeVar("F", bound=Callable[..., Any])

Block = NDArray[np.float64]
"""A slice of the arena memory (core/state.py): fields lie LANES apart, one lane is one arena."""

_FLAGS: Final[dict[str, Any]] = {"nogil": True, "error_model": "numpy", "fastmath": False, "_nrt": False}
_WHOLE: Final[dict[str, Any]] = {**_FLAGS, "pipeline_class": WholeCompiler} if USABLE else _FLAGS
_ALONE: Final[dict[str, Any]] = {**_FLAGS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""What only compiled code calls needs no entry point for Python: that halves the time to compile."""
_INNER: Final[dict[str, Any]] = {**_ALONE, "pipeline_class": PartCompiler} if USABLE else _ALONE
_OUTLINED: Final[dict[str, Any]] = {**_ALONE, "pipeline_class": OutlinedCompiler} if USABLE else _ALONE


def rule(function: F) -> F:
    """A rule: a value, or a few, of one lane or a group of lanes, from numbers or from what it reads in arrays; it
    writes nothing, and is branch-free where it runs in a lane loop. Compiled code has it written out where it is used;
    Python runs it as it stands, which gives the same bits.
    """
    return numba.extending.register_jitable(forceinline=True, **_INNER)(function)


def phase(function: F) -> F:
    """A phase: one block, a loop over its lanes, or one group of them; or phases in their order, or a name for a part
    of the memory. LLVM decides whether it is written out where it is called.
    """
    return cast(F, numba.njit(**_INNER)(function))


def outlined(function: F) -> F:
    """A phase that is compiled once, small, and called: since few steps come to it; or since few scenarios have it, and
    it goes lane by lane, so that it would take longer to compile and hardly be faster. Not for what all steps do with
    every lane.
    """
    return cast(F, numba.njit(forceinline=False, **_OUTLINED)(function))


def unkept_entry(function: F) -> F:
    """What Python calls, compiled in each process anew: for where nothing can be kept, and for experiments."""
    return cast(F, numba.njit(**_WHOLE)(function))


def entry(function: F) -> F:
    """What Python calls: `tick.run`, which plays the blocks of a batch, or something smaller. Only entries are kept in
    the cache: they contain all that they call.
    """
    if INTERPRETED:
        return _with_silent_overflow(function)
    return cast(F, kept(unkept_entry(function)))


def _with_silent_overflow(function: F) -> F:
    @wraps(function)
    def wrapped(*arguments: object) -> object:
        with np.errstate(over="ignore"):  # the hashes of A.5 are arithmetic modulo 2^64
            return function(*arguments)

    return cast(F, wrapped)
