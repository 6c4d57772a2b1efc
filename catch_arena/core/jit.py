"""Decorators of the core's functions: rules, phases and entries, with Numba's flags.

No fast-math and no fused multiply-add: the same bits compiled and interpreted (R10.1). `error_model="numpy"` drops
the test for a zero divisor, which would keep loops from becoming SIMD code; no formula of ours divides by zero.

`compiler` compiles the core as one piece, and `cache` stores it on the disk.
"""

import logging
from collections.abc import Callable
from typing import Any, Final, TypeVar, cast

import numba
import numba.extending
import numpy as np
from numpy.typing import NDArray

from catch_arena.core.modes import COMPILER, INTERPRETED

try:
    from catch_arena.core import cache
except (ImportError, AttributeError):  # this Numba lacks something that is not public
    cache = None  # type: ignore[assignment]

_logger = logging.getLogger("numba")
if _logger.level == logging.NOTSET:  # with the root logger at DEBUG each compilation writes megabytes
    _logger.setLevel(logging.WARNING)

F = TypeVar("F", bound=Callable[..., Any])

Rows = NDArray[np.float64]
"""Slice of the arena memory (core/rows.py): fields lie LANES apart, and one lane is one arena."""

_OURS: Final[dict[str, Any]] = COMPILER.FLAGS if COMPILER else {}
_FLAGS: Final[dict[str, Any]] = {"nogil": True, "error_model": "numpy", "fastmath": False, **_OURS}
WHOLE: Final[dict[str, Any]] = {**_FLAGS, "pipeline_class": COMPILER.WholeCompiler} if COMPILER else _FLAGS
"""Flags of functions that Python calls."""
_ALONE: Final[dict[str, Any]] = {**_FLAGS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Flags of functions that only compiled code calls: without an entry point for Python they compile in half the time."""
_INNER: Final[dict[str, Any]] = {**_ALONE, "pipeline_class": COMPILER.PartCompiler} if COMPILER else _ALONE
_OUTLINED: Final[dict[str, Any]] = {**_ALONE, "pipeline_class": COMPILER.OutlinedCompiler} if COMPILER else _ALONE


def rule(function: F) -> F:
    """Compile a rule: it computes one or a few values of one lane or a group of lanes, from numbers and arrays. It
    writes nothing, and is branch-free if it runs in a lane loop. Compiled code has it inline; Python runs it as it is
    written, which gives the same bits.
    """
    return numba.extending.register_jitable(forceinline=True, **_INNER)(function)


def phase(function: F) -> F:
    """Compile a phase, which works on one chunk: a loop over its lanes, or over one group, or other phases; or a name
    of a part of the memory. LLVM decides whether to inline it.
    """
    return cast(F, numba.njit(**_INNER)(function))


def outlined(function: F) -> F:
    """Compile a phase once, as small code, and call it. It suits work that few steps do. It also suits work lane by
    lane in few scenarios, which would take longer to compile and hardly be faster. Do not use it for work that all
    steps do with every lane.
    """
    return cast(F, numba.njit(forceinline=False, **_OUTLINED)(function))


def entry(function: F) -> F:
    """Compile a function that Python calls: `tick.run`, which plays the chunks of a batch, or a smaller one. The cache
    only keeps entries: they contain all that they call.
    """
    if INTERPRETED:
        return np.errstate(over="ignore")(function)  # the hashes of A.5 are arithmetic modulo 2^64
    if cache is None:
        return cast(F, numba.njit(cache=True, **WHOLE)(function))
    return cast(F, cache.kept(numba.njit(**WHOLE)(function)))
