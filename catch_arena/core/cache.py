"""Cache of compiled code, in the user's cache directory, or in a temporary folder if that cannot be written.

It has a folder for each state of the core's sources: Numba compares only the file of the function that is called, and
would miss an edit in another one.
"""

import contextlib
import hashlib
import os
import pickle
import shutil
import stat
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, Final

import numba.core.caching
import numba.core.serialize
import platformdirs

from catch_arena.core.modes import CHECKED, COMPILER, INTERPRETED, numba_settings

caching: Any = numba.core.caching
serialize: Any = numba.core.serialize
_MOST_KEPT: Final = 16
"""Number of states of the sources that are kept."""


def _cache_directory() -> Path | None:
    """Return the folder for this state of the sources; None if none can be written."""
    digest = _sources_digest()
    kind = f"{'-checked' if CHECKED else ''}{'-numba' if COMPILER is None else ''}"  # other code from the same sources
    for parent in _cache_parents():
        folder = parent / f"core-{digest}{kind}"
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
    """Yield the folders that may hold the cache, the best first; only NUMBA_CACHE_DIR if it is set. No other user can
    write the folder among temporary files, since code that is read from it runs.
    """
    if chosen := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(chosen)
        return
    yield Path(platformdirs.user_cache_dir("catch_arena", appauthor=False))
    with contextlib.suppress(OSError, AttributeError):  # Windows has no user ids
        folder = Path(tempfile.gettempdir()) / f"catch-arena-{os.getuid()}"
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
        if stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022:
            yield folder


def _drop_old_folders(current: Path) -> None:
    """Remove all but the _MOST_KEPT folders that were used last, whatever their age: clocks jump."""
    with contextlib.suppress(OSError):  # another process may be doing the same
        os.utime(current)
        others = set(current.parent.glob("core-*")) - {current}
        for folder in sorted(others, key=lambda folder: folder.stat().st_mtime)[: -_MOST_KEPT + 1]:
            shutil.rmtree(folder)


CACHE_DIRECTORY: Final = None if INTERPRETED else _cache_directory()
"""Folder for these sources; None if no code is kept."""


on_miss: Final[list[Callable[[], None]]] = []
"""Functions to call when the cache lacks code, which is then compiled."""


class _CheckedForm(caching.CompileResultCacheImpl):  # type: ignore[misc]
    """Content of a cache file: Numba's form of the code, and a checksum, since damaged machine code would run."""

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
    before, numba_settings.CACHE_DIR = numba_settings.CACHE_DIR, str(CACHE_DIRECTORY)  # read while the cache is made
    compiled._cache = _Cache(compiled.py_func)  # noqa: SLF001 - Numba has no other way in
    numba_settings.CACHE_DIR = before
    return compiled


@cache
def _warn_not_kept(reason: str) -> None:
    """Print once for each reason that the cache cannot be written."""
    sys.stderr.write(
        f"catch_arena: compiled rules cannot be kept in {CACHE_DIRECTORY}: {reason}; every start compiles them again, "
        "unless NUMBA_CACHE_DIR names a folder with room\n"
    )
