"""Folders that are made in advance, and files that appear whole or not at all.

All functions that write raise OutputError if they cannot.
"""

import os
import secrets
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from catch_arena.errors import ConfigError, OutputError

if sys.version_info >= (3, 11):  # all other modules import tomllib from here
    import tomllib as tomllib  # noqa: PLC0414
else:
    import tomli as tomllib  # noqa: F401


def regular_file(path: Path) -> Path:
    """Return a file's path with links followed, existing or not; raise OutputError for a device or a folder."""
    try:
        target = Path(os.path.realpath(path))
        if target.exists() and not target.is_file():
            raise OutputError(f"{path}: cannot be written: is not a regular file")
    except OSError as error:
        raise unwritable(path, error) from None
    return target


def read_text(path: Path) -> str:
    """Return the text of a UTF-8 file, with or without a byte order mark; raise ConfigError for another encoding, and
    OSError if it cannot be read.
    """
    try:
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ConfigError(
            f"{path}: must be text in UTF-8, but byte {error.start + 1} is not: save the file as UTF-8"
        ) from None


def write_whole(path: Path, content: bytes, *, private: bool = False) -> None:
    """Write a file in one piece: other processes see all of it or none. Only the owner may read a `private` file."""
    with unfinished_file(path, private=private) as unfinished:
        unfinished.write_bytes(content)


@contextmanager
def whole_file(path: Path) -> Iterator[IO[bytes]]:
    """Open a file under a temporary name, which is renamed when the block ends without an error."""
    with unfinished_file(path) as unfinished, unfinished.open("wb") as file:
        yield file


@contextmanager
def unfinished_file(path: Path, *, ending: str = "", private: bool = False) -> Iterator[Path]:
    """Create an empty file next to a file; it replaces that file at the end, or is removed after an error.

    It has the permissions of the file that it replaces, or the umask's for a new file. Its name ends in `ending`.
    """
    target = regular_file(path)
    # without a part of the file's name, which may be as long as names can be
    unfinished = target.with_name(f".catch-arena-{secrets.token_hex(4)}{ending}")
    replaced = target.exists()
    mode = 0o600 if private or replaced else 0o666
    try:
        os.close(os.open(unfinished, os.O_CREAT | os.O_EXCL | os.O_WRONLY, mode))
        yield unfinished
        if replaced and not private:
            shutil.copymode(target, unfinished)
        unfinished.replace(target)
    except OSError as error:
        raise unwritable(path, error) from None
    finally:
        with suppress(OSError):  # it has its name, or was not created
            unfinished.unlink()


def prepare_folder(folder: Path) -> Path:
    """Create a folder if it is missing, check that it is writable, and return it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".catch-arena-probe"
        probe.touch()
        probe.unlink(missing_ok=True)  # another process may probe the folder at the same time
    except (FileExistsError, NotADirectoryError):
        taken = next(path for path in (folder, *folder.parents) if os.path.lexists(path) and not path.is_dir())
        raise OutputError(f"{taken}: cannot be written: is not a folder") from None
    except OSError as error:
        raise unwritable(folder, error) from None
    return folder


def unwritable(path: Path, error: Exception) -> OutputError:
    """Return the error for a file or folder that cannot be written, with the reason of an exception."""
    return OutputError(f"{path}: cannot be written: {getattr(error, 'strerror', None) or error}")
