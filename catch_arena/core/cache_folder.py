"""Folder of the compiled code: in the user's cache directory, or a temporary one where nothing can be written or read.

It has a folder for each state of the core's sources: Numba compares only the file of the function that is called, and
would miss an edit in another one.
"""

import contextlib
import hashlib
import os
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

import platformdirs

from catch_arena.core.modes import CHECKED, COMPILER, INTERPRETED

on_miss: Final[list[Callable[[], None]]] = []
"""Functions to call when the cache lacks code, which is then compiled."""
_MOST_KEPT: Final = 16
"""Number of states of the sources that are kept."""


def _cache_directory() -> Path | None:
    """Return the folder for this state of the sources: one that can be written, or that has code; None without one."""
    digest = _sources_digest()
    kind = f"{'-checked' if CHECKED else ''}{'-numba' if COMPILER is None else ''}"  # other code from the same sources
    for parent in _cache_parents():
        folder = parent / f"core-{digest}{kind}"
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            if os.access(folder, os.W_OK):
                _drop_old_folders(folder)
                return folder
            if any(folder.glob("*/*.nbi")):  # as in the image of a container
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
