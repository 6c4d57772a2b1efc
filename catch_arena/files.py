"""Folders made before they are needed, files that appear whole or not at all, and what is said where neither can be."""

import codecs
import errno
import os
import secrets
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Final

from rich.filesize import decimal

from catch_arena.errors import ConfigError, OutputError

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
        OutputError: for a device or a folder, and a link that leads to itself.
    """
    try:
        target = Path(os.path.realpath(path))
        if target.is_symlink():
            raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
        if target.exists() and not target.is_file():
            raise OutputError(f"{path}: cannot be written: is not a regular file")
    except OSError as error:
        raise unwritable(path, error) from None
    return target


def read_text(path: Path) -> str:
    """Return the text of a file that a person wrote: UTF-8, with or without a byte order mark.

    Raises:
        OSError: if it cannot be read.
        ConfigError: for another encoding.
    """
    content = path.read_bytes()
    if (fault := wide_text_fault(content)) is not None:
        raise ConfigError(f"{path}: {fault}")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: must be text in UTF-8, and byte {error.start + 1} is none") from None


def wide_text_fault(content: bytes) -> str | None:
    """What is wrong with text in UTF-16 or UTF-32, with or without a byte order mark; None for all else."""
    if len(content) % 4 == 0 and b"\0\0" in (content[:2], content[2:4]):
        return "is text in UTF-32: save it as UTF-8"
    two_bytes_each = len(content) % 2 == 0 and b"\0" in content[:2]
    if two_bytes_each or content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "is text in UTF-16: save it as UTF-8"
    return None


def is_loop(path: Path) -> bool:
    """Return if a path is a link that leads to itself, also by way of others."""
    return Path(os.path.realpath(path)).is_symlink()


def write_whole(path: Path, content: bytes, *, private: bool = False) -> None:
    """Write a file of this content: whoever looks finds it whole or not at all.

    Args:
        path: where it is written.
        content: all of it.
        private: whether only its owner may read it.

    Raises:
        OutputError: where it cannot be written.
    """
    with whole_file(path, len(content), private=private) as file:
        file.write(content)


@contextmanager
def whole_file(path: Path, size: int | None = None, *, private: bool = False) -> Iterator[IO[bytes]]:
    """A file under a temporary name, which is renamed when all has been written.

    Args:
        path: where it is written.
        size: how many bytes will be, where that is known.
        private: see `write_whole`.

    Raises:
        OutputError: where it cannot be written.
    """
    target = regular_file(path)
    try:
        with unfinished_file(target, private=private) as unfinished, unfinished.open("wb") as file:
            yield file
    except OSError as error:
        raise unwritable(path, error, size) from None


@contextmanager
def unfinished_file(target: Path, *, ending: str = "", private: bool = False) -> Iterator[Path]:
    """Create an empty file next to the target, which replaces the target at the end, or is removed after an error.

    It has the permissions of the file that it replaces, or those that the umask leaves.

    Args:
        target: a regular file, or none yet.
        ending: of the temporary name, which holds nothing of the target's: a name may be as long as the disk allows.
        private: see `write_whole`.

    Raises:
        OSError: where it cannot be created or renamed.
    """
    unfinished = target.with_name(f".catch-arena-{secrets.token_hex(4)}{ending}")
    replaced = target.exists()
    mode = 0o600 if private or replaced else 0o666
    try:
        os.close(os.open(unfinished, os.O_CREAT | os.O_EXCL | os.O_WRONLY, mode))
        yield unfinished
        if replaced and not private:
            shutil.copymode(target, unfinished)
        unfinished.replace(target)
    except BaseException:
        unfinished.unlink(missing_ok=True)
        raise


def prepare_folder(folder: Path) -> Path:
    """The folder, made where it is missing and proven writable: better to fail before the play than after it.

    Raises:
        OutputError: where it cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".catch-arena-probe"
        probe.touch()
        probe.unlink(missing_ok=True)  # another process may probe the folder at the same time
    except (FileExistsError, NotADirectoryError):
        taken = next(path for path in (folder, *folder.parents) if os.path.lexists(path) and not path.is_dir())
        is_what = "a link that leads to itself" if is_loop(taken) else "a file, not a folder"
        raise OutputError(f"{taken}: cannot be written: is {is_what}") from None
    except OSError as error:
        raise unwritable(folder, error) from None
    return folder


def require_folder(folder: Path) -> None:
    """Require that a folder can be made, without making it.

    Raises:
        OutputError: if it cannot be written.
    """
    there = next(path for path in (folder.absolute(), *folder.absolute().parents) if os.path.lexists(path))
    if not there.is_dir() or not os.access(there, os.W_OK):
        prepare_folder(folder)  # says why


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
