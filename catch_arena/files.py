"""Folders made before they are needed, files that appear whole or not at all, and what is said where neither can be."""

import errno
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Final

from rich.filesize import decimal

from catch_arena.errors import OutputError

if sys.version_info >= (3, 11):  # everything that reads TOML imports it from here
    import tomllib as tomllib  # noqa: PLC0414
else:
    import tomli as tomllib  # noqa: F401

_FULL: Final = {errno.ENOSPC, errno.EDQUOT}
LEAST_FREE: Final = 1_000_000
"""Bytes: with less free, a write that failed was for want of room."""


def regular_file(path: Path) -> Path:
    """Where a file of that name is or would be, links followed.

    Raises:
        OutputError: for a device or a folder.
    """
    target = path.resolve()
    if target.exists() and not target.is_file():
        raise OutputError(f"{path}: cannot be written: is not a regular file")
    return target


def write_whole(path: Path, content: bytes) -> None:
    """Write a file of this content: whoever looks finds it whole or not at all.

    Raises:
        OutputError: where it cannot be written.
    """
    with whole_file(path, len(content)) as file:
        file.write(content)


@contextmanager
def whole_file(path: Path, size: int | None = None) -> Iterator[IO[bytes]]:
    """A file under a temporary name, which is renamed when all has been written.

    Args:
        path: where it is written.
        size: how many bytes will be, where that is known.

    Raises:
        OutputError: where it cannot be written.
    """
    target = regular_file(path)
    try:
        with tempfile.NamedTemporaryFile(dir=target.parent, prefix=f".{target.name}.", delete=False) as file:
            try:
                yield file
                file.flush()
                Path(file.name).chmod(0o644)
                Path(file.name).replace(target)
            except BaseException:
                Path(file.name).unlink(missing_ok=True)
                raise
    except OSError as error:
        raise unwritable(path, error, size) from None


def prepare_folder(folder: Path) -> Path:
    """The folder, made where it is missing and proven writable: better to fail before the play than after it.

    Raises:
        OutputError: where it cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".catch-arena-probe"
        probe.touch()
        probe.unlink()
    except (FileExistsError, NotADirectoryError):
        taken = next(path for path in (folder, *folder.parents) if os.path.lexists(path) and not path.is_dir())
        raise OutputError(f"{taken}: cannot be written: is a file, not a folder") from None
    except OSError as error:
        raise unwritable(folder, error) from None
    return folder


def unwritable(path: Path, error: Exception, size: int | None = None) -> OutputError:
    """What is said of a file that cannot be written; where the disk is full, with the room that there is.

    Args:
        path: where it is written.
        error: what was raised.
        size: how many bytes it was to have, where that is known.
    """
    full = getattr(error, "errno", None) in _FULL
    why = f"the disk is full: {room(path.parent, size)}" if full else getattr(error, "strerror", None) or error
    return OutputError(f"{path}: cannot be written: {why}")


def is_full(folder: Path, needed: int = LEAST_FREE) -> bool:
    """Whether so many bytes find no room in a folder; false where nobody knows."""
    with suppress(OSError):
        return shutil.disk_usage(folder).free < needed
    return False


def room(folder: Path, size: int | None = None) -> str:
    """How much is free in a folder, and of what `size` there must be room for, in words."""
    try:
        free = decimal(shutil.disk_usage(folder).free)
    except OSError:
        return f"nobody knows what is free in {folder}"
    return f"{free} are free in {folder}" + ("" if size is None else f", and {decimal(size)} are needed")
