"""How the core is compiled: the only place with compiler flags.

No fast-math and no fused multiply-add: the same bits compiled and interpreted (R10.1). `error_model="numpy"` drops
the test for a zero divisor, which would keep loops from becoming SIMD code; no formula of ours divides by zero.
`_nrt=False`: the core makes no arrays, so nothing is counted and freed, and code for one arena runs a third faster.

Compiled code is kept in the user's cache directory, keyed by the sources of the whole core: Numba itself looks only
at the file of the function that is called, and would miss an edit in another one.
"""

import contextlib
import hashlib
import os
import shutil
import time
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, Final, TypeVar, cast

import numba
import numba.core.config
import numba.extending
import numpy as np
import platformdirs
from numpy.typing import NDArray

_numba: Any = numba.core.config
"""Numba's settings; the module fills itself, so that type checkers see none of them."""

F = TypeVar("F", bound=Callable[..., Any])

Block = NDArray[np.float64]
"""A slice of the arena memory (core/state.py): fields lie LANES apart, one lane is one arena."""

INTERPRETED: Final = bool(_numba.DISABLE_JIT)
"""NUMBA_DISABLE_JIT=1: everything below runs as plain Python, for debuggers, coverage and doubters."""

_FLAGS: Final[dict[str, Any]] = {"nogil": True, "error_model": "numpy", "fastmath": False, "_nrt": False}
_INNER: Final[dict[str, Any]] = {**_FLAGS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""What only compiled code calls needs no door to Python: that halves the time to compile."""


_KEPT_S: Final = 30 * 24 * 3600.0


def _cache_directory() -> Path | None:
    """Where compiled code is kept: one folder for each state of the sources; None where nothing can be written."""
    package = Path(__file__).parent.parent
    sources = [*sorted((package / "core").glob("*.py")), package / "layout.py", package / "verdicts.py"]
    digest = hashlib.blake2b(digest_size=8)
    for source in sources:
        digest.update(source.name.encode())
        digest.update(source.read_bytes())
    base = os.environ.get("NUMBA_CACHE_DIR") or platformdirs.user_cache_dir("catch_arena", appauthor=False)
    checked = "-checked" if _numba.BOUNDSCHECK else ""  # NUMBA_BOUNDSCHECK=1 makes other code of the same sources
    folder = Path(base) / f"core-{digest.hexdigest()}{checked}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    if not os.access(folder, os.W_OK):
        return None
    _drop_old_folders(folder)
    return folder


def _drop_old_folders(current: Path) -> None:
    """Compiled code of sources that are long gone."""
    for folder in current.parent.glob("core-*"):
        with contextlib.suppress(OSError):  # another process may be doing the same
            if folder != current and time.time() - folder.stat().st_mtime > _KEPT_S:
                shutil.rmtree(folder)


CACHE_DIRECTORY: Final = None if INTERPRETED else _cache_directory()


def is_cached() -> bool:
    """Whether some earlier process has left the compiled step."""
    return CACHE_DIRECTORY is not None and any(CACHE_DIRECTORY.glob("*/tick.run-*.nbc"))


def rule(function: F) -> F:
    """A rule: scalars in, scalars out, branch-free where it runs in a lane loop. Compiled code has it written out where
    it is used; Python runs it as it stands, which gives the same bits.
    """
    return numba.extending.register_jitable(forceinline=True, **_INNER)(function)


def phase(function: F) -> F:
    """A phase: one block, a loop over its lanes."""
    return cast(F, numba.njit(forceinline=True, **_INNER)(function))


def passage(function: F) -> F:
    """Phases in their order, or a name for a part of the memory: copied to where it is used before anything is
    compiled, since a function of its own would be optimised once more, and without `_nrt` none may return an array.
    """
    return cast(F, numba.njit(inline="always", **_INNER)(function))


def entry(function: F) -> F:
    """What Python calls: a batch, or a rule with a door of its own. Only these are kept in the cache: they contain
    all that they call.
    """
    if INTERPRETED:
        return _with_silent_overflow(function)
    if CACHE_DIRECTORY is None:
        return cast(F, numba.njit(**_FLAGS)(function))
    before = _numba.CACHE_DIR
    _numba.CACHE_DIR = str(CACHE_DIRECTORY)  # read once, while a function is decorated
    try:
        return cast(F, numba.njit(cache=True, **_FLAGS)(function))
    finally:
        _numba.CACHE_DIR = before


def _with_silent_overflow(function: F) -> F:
    @wraps(function)
    def wrapped(*arguments: object) -> object:
        with np.errstate(over="ignore"):  # the hashes of A.5 are arithmetic modulo 2^64
            return function(*arguments)

    return cast(F, wrapped)
