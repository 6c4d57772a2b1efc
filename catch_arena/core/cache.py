"""Cache of compiled code on the disk, in CACHE_DIRECTORY."""

import contextlib
import hashlib
import pickle
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numba.core.caching
import numba.core.serialize

from catch_arena.core.cache_folder import CACHE_DIRECTORY, on_miss
from catch_arena.core.modes import COMPILER

caching: Any = numba.core.caching
serialize: Any = numba.core.serialize


class _Place(caching.InTreeCacheLocator):  # type: ignore[misc]
    """Place of a function's code below CACHE_DIRECTORY; Numba's own places must be writable even to read from them."""

    def __init__(self, function: Any, source: str) -> None:
        super().__init__(function, source)
        self._cache_path = str(Path(str(CACHE_DIRECTORY), self.get_suitable_cache_subpath(source)))

    @classmethod
    def from_function(cls, function: Any, source: str) -> Any:
        """Return the place of a function's code."""
        return cls(function, source)


class _CheckedForm(caching.CompileResultCacheImpl):  # type: ignore[misc]
    """Content of a cache file: Numba's form of the code, and a checksum, since damaged machine code would run."""

    _locator_classes = (_Place,)

    def reduce(self, compiled: Any) -> tuple[bytes, bytes]:
        """Return the content of a cache file for this code: a checksum, and Numba's form of the code."""
        content = serialize.dumps(super().reduce(compiled))
        return hashlib.blake2b(content).digest(), content

    def rebuild(self, context: Any, kept: Any) -> Any:
        """Return the code from the content of a file."""
        checksum, content = kept
        if hashlib.blake2b(content).digest() != checksum:
            raise ValueError("damaged")
        return super().rebuild(context, pickle.loads(content))  # noqa: S301 - Numba's cache is pickled


class _Cache(caching.FunctionCache):  # type: ignore[misc]
    """Cache of one function. Code that cannot be read is compiled again; if it cannot be written, at every start."""

    _impl_class = _CheckedForm

    def load_overload(self, types: Any, context: Any) -> Any:
        """Return the code for arguments of these types, or None."""
        try:  # Numba's own method first imports the compiler's libraries: more than a third of a warm start
            found = (super().load_overload if COMPILER is None else self._load_overload)(types, context)
            if found is not None and found.signature.args != tuple(types):  # two processes saved at the same time
                raise ValueError("for other types")
        except Exception:  # noqa: BLE001 - pickle may raise any exception for a damaged file
            found = None
            with contextlib.suppress(OSError):  # `save_overload` reports if the cache cannot be written
                self.flush()  # the index may be damaged, and it is read again before anything is saved
        for callback in () if found else on_miss:
            callback()
        return found

    def save_overload(self, types: Any, compiled: Any) -> None:
        """Write the code; on a full disk Numba would raise, and the rules would not run."""
        try:
            super().save_overload(types, compiled)
        except Exception as error:  # noqa: BLE001 - a damaged index that cannot be replaced is read here again
            _warn_not_kept(getattr(error, "strerror", None) or str(error))


def kept(compiled: Any) -> Any:
    """Return a compiled function that is read from the cache, and written to it."""
    if CACHE_DIRECTORY is None:
        return compiled
    compiled._cache = _Cache(compiled.py_func)  # noqa: SLF001 - Numba has no other way in
    return compiled


@cache
def _warn_not_kept(reason: str) -> None:
    """Print once for each reason that the cache cannot be written."""
    sys.stderr.write(
        f"catch_arena: compiled rules cannot be kept in {CACHE_DIRECTORY}: {reason}; every start compiles them again, "
        "unless NUMBA_CACHE_DIR names a folder that can be written and has room\n"
    )
