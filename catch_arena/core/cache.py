"""Compiled code on the disk: the only place that knows how Numba keeps it.

It is kept in the user's cache directory, or if that cannot be written in a temporary folder of the user's, by the
sources of the whole core: Numba itself looks only at the file of the function that is called, and would miss an edit in
another one.
"""

import contextlib
import hashlib
import os
import pickle
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, Final

import numba.core.caching
import numba.core.serialize
import numba.core.sigutils
import platformdirs

from catch_arena.core.compiler import CHECKED, INTERPRETED, USABLE, numba_settings

_caching: Any = numba.core.caching
_serialize: Any = numba.core.serialize
_sigutils: Any = numba.core.sigutils
_MOST_KEPT: Final = 16
"""Number of states of the sources that are kept."""


def _cache_directory() -> Path | None:
    """Where compiled code is kept: one folder for each state of the sources; None where nothing can be written."""
    digest = _sources_digest()
    kind = f"{'-checked' if CHECKED else ''}{'' if USABLE else '-numba'}"  # other code of the same sources
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
"""The folder for these sources; None if nothing is kept."""


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


def kept(compiled: Any) -> Any:
    """Return a compiled function that is read from the cache, and written to it."""
    if CACHE_DIRECTORY is None:
        return compiled
    before = numba_settings.CACHE_DIR
    numba_settings.CACHE_DIR = str(CACHE_DIRECTORY)  # read once, while the cache is made
    try:
        compiled._cache = _Cache(compiled.py_func)  # noqa: SLF001 - Numba has no other way in
    finally:
        numba_settings.CACHE_DIR = before
    return compiled


@cache
def _tell_not_kept(reason: str) -> None:
    """Once for each reason."""
    sys.stderr.write(
        f"catch_arena: compiled rules cannot be kept in {CACHE_DIRECTORY}: {reason}; every start compiles them anew, "
        "unless NUMBA_CACHE_DIR names a folder with room\n"
    )
