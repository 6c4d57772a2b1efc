"""The files that commands write: what stands there already is not replaced without --force."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Final

import typer

from catch_arena.errors import ConfigError, OutputError

Force = Annotated[bool, typer.Option("--force", help="Replace the file if it exists.")]

REPLAY: Final = (".replay",)
VIDEO: Final = (".mp4", ".webm", ".gif", ".webp")
TABLE: Final = (".jsonl", ".csv", ".parquet")
_MAKERS: Final = (
    (REPLAY, "catch-arena match"),
    (VIDEO, "catch-arena render"),
    (TABLE, "catch-arena export"),
    ((".png",), "catch-arena sheet"),
    ((".html",), "catch-arena report"),
    ((".json",), "catch-arena explain --json"),
    ((".xml",), "catch-arena grade --junit"),
    ((".mcap", ".db3"), "catch-arena ros bag"),
)
"""The endings that stand for a format, and a command that writes it."""


def require_ending(path: Path, *endings: str) -> None:
    """Require of a file's name that it does not promise another format than that of its content.

    Args:
        path: the file to write.
        endings: those of its own format; without them any will do.

    Raises:
        ConfigError: for the ending of another format, with the command that writes that one.
    """
    ending = path.suffix.lower()
    maker = next((maker for others, maker in _MAKERS if ending in others), None)
    if endings and maker is not None and ending not in endings:
        raise ConfigError(f"{path}: the name must end in {' or '.join(endings)}, got {ending}: `{maker}` writes that")


def output_file(path: Path, *endings: str, force: bool) -> Path:
    """That path, where a file can be written: its folder is made, and what stands there may be replaced.

    Args:
        path: the file to write.
        endings: see `require_ending`.
        force: whether it may replace a file.

    Raises:
        ConfigError: for the ending of another format.
        OutputError: better before the work than after it.
    """
    from catch_arena.files import prepare_folder, regular_file

    require_ending(path, *endings)
    prepare_folder(path.parent)
    if regular_file(path).exists() and not force:
        raise OutputError(f"{path}: is there already: give --force to replace it, or another name")
    return path


def output_video(path: Path, *, force: bool) -> None:
    """Require, as `output_file` does, that a video can be written, under the name that it gets without its encoder too.

    Raises:
        ConfigError: for an ending that is none of a video's.
        OutputError: better before the work than after it.
    """
    from catch_arena.render.encoders import output_path

    require_ending(path, *VIDEO)
    output_file(output_path(path), *VIDEO, force=force)


@contextmanager
def given_or_free(given: Path | None, usual: str, *, force: bool) -> Iterator[Path]:
    """The path to write: the given one, or the first free one of «name.end», «name-2.end», «name-3.end» and so on.

    An empty file reserves a free name against other processes. It is removed at the end if nothing was written there.

    Args:
        given: the path that was asked for, which `output_file` has checked.
        usual: the path without it.
        force: whether a file may be replaced, so that no other name is needed.

    Raises:
        OutputError: for a folder that cannot be written.
    """
    if given is not None or force:
        yield Path(usual) if given is None else given
        return
    path = _reserved(Path(usual))
    try:
        yield path
    finally:
        if path.is_file() and not path.stat().st_size:
            path.unlink()


def _reserved(path: Path) -> Path:
    from catch_arena.files import prepare_folder

    prepare_folder(path.parent)
    free, number = path, 1
    while True:
        try:
            free.touch(exist_ok=False)
        except FileExistsError:
            number += 1
            free = path.with_stem(f"{path.stem}-{number}")
        else:
            return free
