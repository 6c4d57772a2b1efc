"""The files that commands write: what stands there already is not replaced without --force."""

from itertools import count
from pathlib import Path
from typing import Annotated

import typer

from catch_arena.errors import OutputError

Force = Annotated[bool, typer.Option("--force", help="Replace the file if it exists.")]


def output_file(path: Path, *, force: bool) -> Path:
    """That path, where a file can be written: its folder is made, and what stands there may be replaced.

    Raises:
        OutputError: better before the work than after it.
    """
    from catch_arena.files import prepare_folder, regular_file

    prepare_folder(path.parent)
    if regular_file(path).exists() and not force:
        raise OutputError(f"{path}: is there already: give --force to replace it, or another name")
    return path


def free_name(path: Path) -> Path:
    """That path, or where something stands there the first free one of «name-2.end», «name-3.end» and so on."""
    if not path.exists():
        return path
    return next(other for number in count(2) if not (other := path.with_stem(f"{path.stem}-{number}")).exists())


def given_or_free(given: Path | None, usual: Path, *, force: bool) -> Path:
    """The path that was asked for; or where none was, the usual one, or the first free one like it: a command that is
    given twice does not need another name. `output_file` then looks at it.
    """
    if given is not None:
        return given
    return usual if force else free_name(usual)
