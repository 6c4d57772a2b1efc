"""Output files of commands; an existing file is not replaced without --force."""

from contextlib import ExitStack, suppress
from itertools import chain, count
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from catch_arena.errors import ConfigError, OutputError
from catch_arena.files import prepare_folder, regular_file, unwritable

Force = Annotated[
    bool, typer.Option("--force", help="Replace the file if it exists, and use the folder if it has other files.")
]
Junit = Annotated[Path | None, typer.Option(metavar="FILE", help="Also write the results as JUnit XML.")]
Json = Annotated[Path | None, typer.Option(metavar="FILE", help="Also write the results as JSON.")]

REPLAY: Final = ".replay"
PAGE: Final = ".html"
VIDEO: Final = (".mp4", ".webm", ".gif", ".webp")
VIDEO_HELP: Final = "Video file to write; its name ends in .mp4, .webm, .gif or .webp."
RESERVATIONS: Final = ExitStack()
"""Removes at its end the files that the running command has reserved but not written."""


def output_option(help_: str, usual: str | bool = True, metavar: str = "FILE") -> Any:
    """Return the option --output of a command; `usual` describes the name that is used without it, if there is one."""
    return typer.Option("--output", "-o", help=help_, metavar=metavar, show_default=usual)


def require_free(path: Path, *, force: bool) -> None:
    """Check that no file would be replaced without --force, and no folder or device at all."""
    if regular_file(path).exists() and not force:
        raise OutputError(f"{path}: already exists; use --force to replace it, or choose another name")


def reserve_file(path: Path | None, *endings: str, force: bool) -> None:
    """Check the ending of a file's name, and make its folder and an empty file, which blocks other commands."""
    if path is None:
        return
    ending = path.suffix.lower()
    if ending not in endings:
        *first, last = endings
        wanted = f"{', '.join(first)} or {last}" if first else last
        raise ConfigError(f"{path}: the name must end in {wanted}, got {ending or 'no ending'}")
    prepare_folder(path.parent)
    if not _reserve(regular_file(path)):
        require_free(path, force=force)


def reserve_free_file(usual: str, *, force: bool) -> Path:
    """Reserve and return the first free path of «name.end», «name-2.end» and so on; with `force`, «name.end»."""
    path = Path(usual)
    prepare_folder(path.parent)
    others = (path.with_stem(f"{path.stem}-{number}") for number in count(2))
    return next(free for free in chain([path], others) if _reserve(free) or force)


def _reserve(path: Path) -> bool:
    """Make an empty file, which blocks other commands, and return True; return False if the file exists."""
    try:
        path.touch(exist_ok=False)
    except FileExistsError:
        return False
    except OSError as error:
        raise unwritable(path, error) from None
    RESERVATIONS.callback(_remove_if_empty, path)
    return True


def _remove_if_empty(path: Path) -> None:
    with suppress(OSError):
        if not path.stat().st_size:
            path.unlink()
