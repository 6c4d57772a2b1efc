"""The files that commands write: what stands there already is not replaced without --force."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated, Final

import typer

from catch_arena.errors import ConfigError, OutputError
from catch_arena.files import prepare_folder, regular_file, unwritable

Force = Annotated[bool, typer.Option("--force", help="Replace the file if it exists.")]

REPLAY: Final = (".replay",)
VIDEO: Final = (".mp4", ".webm", ".gif", ".webp")
_RESERVED: Final[list[Path]] = []
"""The files that the running command has reserved."""


@contextmanager
def reservations() -> Iterator[None]:
    """Remove at the end of a command the files that it has reserved and not written."""
    before = len(_RESERVED)
    try:
        yield
    finally:
        while len(_RESERVED) > before:
            path = _RESERVED.pop()
            with suppress(OSError):
                if not path.stat().st_size:
                    path.unlink()


def require_ending(path: Path, *endings: str) -> None:
    """Require that a file's name ends as its format does.

    Raises:
        ConfigError: for any other ending.
    """
    ending = path.suffix.lower()
    if ending not in endings:
        *others, last = endings
        wanted = f"{', '.join(others)} or {last}" if others else last
        raise ConfigError(f"{path}: the name must end in {wanted}, got {ending or 'no ending'}")


def require_free(path: Path, *, force: bool) -> None:
    """Require that no file is replaced without --force.

    Raises:
        OutputError: if there is a file, and for what is no file.
    """
    if regular_file(path).exists() and not force:
        raise OutputError(f"{path}: is there already: give --force to replace it, or another name")


def output_file(path: Path | None, *endings: str, force: bool, usual: str = "") -> Path:
    """Reserve the path of a file: make its folder, and an empty file against other commands.

    Args:
        path: the file to write; if None, the first free name of «name.end», «name-2.end», «name-3.end» and so on.
        endings: those of its format.
        force: whether it may replace a file.
        usual: «name.end».

    Raises:
        ConfigError: for a name that ends in none of the `endings`.
        OutputError: if it cannot be written, or is there already.
    """
    if path is None:
        return free_file(usual, force=force)
    require_ending(path, *endings)
    prepare_folder(path.parent)
    try:
        _reserve(regular_file(path))
    except FileExistsError:
        require_free(path, force=force)
    except OSError as error:
        raise unwritable(path, error) from None
    return path


def free_file(usual: str, *, force: bool) -> Path:
    """Reserve the first free name of «name.end», «name-2.end», «name-3.end» and so on.

    Args:
        usual: «name.end».
        force: whether a file may be replaced, so that no other name is needed.

    Raises:
        OutputError: for a folder that cannot be written.
    """
    prepare_folder(Path.cwd())
    free, number = Path(usual).absolute(), 1
    while not force:
        try:
            _reserve(free)
            break
        except FileExistsError:
            number += 1
            free = free.with_stem(f"{Path(usual).stem}-{number}")
    return free


def _reserve(path: Path) -> None:
    path.touch(exist_ok=False)
    _RESERVED.append(path)
