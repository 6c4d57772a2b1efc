"""How the core is compiled: the only place with compiler flags.

No fast-math and no fused multiply-add: the same bits compiled and interpreted (R10.1). `error_model="numpy"` drops
the test for a zero divisor, which would keep loops from becoming SIMD code; no formula of ours divides by zero.
`_nrt=False`: the core makes no arrays, so nothing is counted and freed, and code for one arena runs a third faster.

Compiled code is kept in the user's cache directory, or where that cannot be written in a temporary folder of the
user's, keyed by the sources of the whole core: Numba itself looks only at the file of the function that is called, and
would miss an edit in another one.
"""

import contextlib
import hashlib
import logging
import os
import pickle
import shutil
import stat
import sys
import tempfile
from collections.abc import Callable, Hashable, Iterator
from functools import cache, wraps
from pathlib import Path
from typing import Any, Final, TypeVar, cast

import numba
import numba.core.caching
import numba.core.config
import numba.core.serialize
import numba.core.sigutils
import numba.extending
import numpy as np
import platformdirs
from numpy.typing import NDArray

from catch_arena.core.compiler import USABLE, OutlinedCompiler, PartCompiler, WholeCompiler

_numba: Any = numba.core.config
"""Numba's settings; the module fills itself, so that type checkers see none of them."""
_caching: Any = numba.core.caching
_serialize: Any = numba.core.serialize
_sigutils: Any = numba.core.sigutils

_logger = logging.getLogger("numba")
if _logger.level == logging.NOTSET:  # with the root logger at DEBUG each compilation writes megabytes
    _logger.setLevel(logging.WARNING)

F = TypeVar("F", bound=Callable[..., Any])

Block = NDArray[np.float64]
"""A slice of the arena memory (core/state.py): fields lie LANES apart, one lane is one arena."""

INTERPRETED: Final = bool(_numba.DISABLE_JIT)
"""NUMBA_DISABLE_JIT=1: everything below runs as plain Python, for debuggers, coverage and doubters."""
CHECKED: Final = bool(_numba.BOUNDSCHECK)
"""NUMBA_BOUNDSCHECK=1: compiled code looks whether each index is one of the array's."""

_FLAGS: Final[dict[str, Any]] = {"nogil": True, "error_model": "numpy", "fastmath": False, "_nrt": False}
_WHOLE: Final[dict[str, Any]] = {**_FLAGS, "pipeline_class": WholeCompiler} if USABLE else _FLAGS
_ALONE: Final[dict[str, Any]] = {**_FLAGS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""What only compiled code calls needs no entry point for Python: that halves the time to compile."""
_INNER: Final[dict[str, Any]] = {**_ALONE, "pipeline_class": PartCompiler} if USABLE else _ALONE
_OUTLINED: Final[dict[str, Any]] = {**_ALONE, "pipeline_class": OutlinedCompiler} if USABLE else _ALONE
_MOST_KEPT: Final = 16
"""How many states of the sources."""


def _cache_directory() -> Path | None:
    """Where compiled code is kept: one folder for each state of the sources; None where nothing can be written."""
    digest = _sources_digest()
    checked = "-checked" if CHECKED else ""  # which is other code of the same sources
    for parent in _cache_parents():
        folder = parent / f"core-{digest}{checked}"
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            if os.access(folder, os.W_OK):
                _drop_old_folders(folder)
                return folder
    return None


def _sources_digest() -> str:
    """Return the digest of every source file that the compiled core depends on."""
    package = Path(__file__).parent.parent
    sources = [*sorted((package / "core").glob("*.py")), package / "layout.py", package / "verdicts.py"]
    digest = hashlib.blake2b(digest_size=8)
    for source in sources:
        digest.update(source.name.encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()


def _cache_parents() -> Iterator[Path]:
    """Where it could be kept, the best first: where the user says; at home; else where all temporary files are, in a
    folder that this user made and nobody else writes to, since what is read from it is run.
    """
    if chosen := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(chosen)
        return
    yield Path(platformdirs.user_cache_dir("catch_arena", appauthor=False))
    with contextlib.suppress(OSError, AttributeError):  # Windows knows no such numbers of users
        folder = Path(tempfile.gettempdir()) / f"catch-arena-{os.getuid()}"
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
        if stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022:
            yield folder


def _drop_old_folders(current: Path) -> None:
    """Keep the compiled code of the sources that were used last; how long ago that was is not asked, as clocks jump."""
    with contextlib.suppress(OSError):  # another process may be doing the same
        os.utime(current)
        others = set(current.parent.glob("core-*")) - {current}
        for folder in sorted(others, key=lambda folder: folder.stat().st_mtime)[: -_MOST_KEPT + 1]:
            shutil.rmtree(folder)


CACHE_DIRECTORY: Final = None if INTERPRETED else _cache_directory()


class _CheckedForm(_caching.CompileResultCacheImpl):  # type: ignore[misc]
    """What stands in a file: Numba's form of it, behind a checksum. A crash can leave a file whole in its length and
    not in its content, and damaged machine code would run.
    """

    def reduce(self, compiled: Any) -> tuple[bytes, bytes]:
        """For the file."""
        content = _serialize.dumps(super().reduce(compiled))
        return hashlib.blake2b(content).digest(), content

    def rebuild(self, context: Any, kept: Any) -> Any:
        """From the file."""
        checksum, content = kept
        if hashlib.blake2b(content).digest() != checksum:
            raise ValueError("damaged")
        return super().rebuild(context, pickle.loads(content))  # noqa: S301 - Numba's cache is pickled


class _Cache(_caching.FunctionCache):  # type: ignore[misc]
    """Compiled code on the disk. What cannot be read is compiled again, and takes the place of what was there; what
    cannot be written is compiled at every start.
    """

    _impl_class = _CheckedForm

    def load_overload(self, types: Any, context: Any) -> Any:
        """What is kept for arguments of these types, or None."""
        try:
            kept = self._load(types, context)
            # two processes that save at once can leave code for other types under this name
            if kept is None or kept.signature.args == _sigutils.normalize_signature(types)[0]:
                return kept
        except Exception:  # noqa: BLE001, S110 - a damaged file makes pickle raise whatever it likes
            pass
        with contextlib.suppress(OSError):  # what cannot be written is told where it is saved
            self.flush()  # the index may be what is damaged, and it is read again before anything is saved
        return None

    def _load(self, types: Any, context: Any) -> Any:
        if not USABLE:
            return super().load_overload(types, context)
        # Numba would first import its libraries for the compiler, which machine code does not need: that is more than a
        # third of a warm start
        with self._guard_against_spurious_io_errors():
            return self._load_overload(types, context)

    def save_overload(self, types: Any, compiled: Any) -> None:
        """Keep it, where there is room: on a full disk Numba would raise, and not play."""
        try:
            super().save_overload(types, compiled)
        except Exception as error:  # noqa: BLE001 - a damaged index that cannot be replaced is read here again
            _tell_not_kept(getattr(error, "strerror", None) or str(error))


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
    compiled = unkept_entry(function)
    if CACHE_DIRECTORY is None:
        return compiled
    before = _numba.CACHE_DIR
    _numba.CACHE_DIR = str(CACHE_DIRECTORY)  # read once, while the cache is made
    try:
        cast(Any, compiled)._cache = _Cache(function)  # noqa: SLF001 - Numba has no other way in
    finally:
        _numba.CACHE_DIR = before
    return compiled


_MACHINE_CODE: Final[dict[Hashable, Any]] = {}


def machine_code(function: F, types: Hashable, *arguments: object) -> F:
    """An entry for arguments of exactly these types. Called itself, it would look at the types each time, which takes
    a third of a microsecond; what this returns does not look, and must be given no others.

    Args:
        function: the entry.
        types: what tells these types from others: numba looks at them once, which takes as long as 20 steps.
        arguments: some of these types.
    """
    if INTERPRETED:
        return function
    key = function, types
    if key not in _MACHINE_CODE:
        _MACHINE_CODE[key] = cast(Any, function).compile(tuple(map(numba.typeof, arguments)))
    return cast(F, _MACHINE_CODE[key])


@cache
def _tell_not_kept(reason: str) -> None:
    """Once for each reason."""
    sys.stderr.write(
        f"catch_arena: compiled rules cannot be kept in {CACHE_DIRECTORY}: {reason}; every start compiles them anew, "
        "unless NUMBA_CACHE_DIR names a folder with room\n"
    )


def _with_silent_overflow(function: F) -> F:
    @wraps(function)
    def wrapped(*arguments: object) -> object:
        with np.errstate(over="ignore"):  # the hashes of A.5 are arithmetic modulo 2^64
            return function(*arguments)

    return cast(F, wrapped)
