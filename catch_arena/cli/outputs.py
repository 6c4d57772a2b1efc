"""The files that commands write: what stands there already is not replaced without --force."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated, Final

import typer

from catch_arena.errors import ConfigError, OutputError

Force = Annotated[bool, typer.Option("--force", help="Replace the file if it exists.")]

REPLAY: Final = (".replay",)
VIDEO: Final = (".mp4", ".webm", ".gif", ".webp")
TABLE: Final = (".jsonl", ".csv", ".parquet")
_MAKERS: Final = (
    (REPLAY, "`catch-arena match`"),
    (VIDEO, "`catch-arena render`"),
    (TABLE, "`catch-arena export`"),
    ((".html",), "`catch-arena report`"),
    ((".json",), "--json of grade, suite or explain"),
    ((".xml",), "--junit of grade or conformance"),
    ((".mcap", ".db3"), "`catch-arena ros bag`"),
)
"""The endings that stand for a format, and what writes it."""
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

    Args:
        path: the file to write.
        endings: those of its format.

    Raises:
        ConfigError: for any other ending; for that of another format of ours with what writes it.
    """
    ending = path.suffix.lower()
    if ending in endings:
        return
    *others, last = endings
    wanted = f"{', '.join(others)} or {last}" if others else last
    made = next((f": {maker} writes that" for known, maker in _MAKERS if ending in known), "")
    raise ConfigError(f"{path}: the name must end in {wanted}, got {ending or 'no ending'}{made}")


def require_folder_name(path: Path) -> None:
    """Require that a folder's name does not end as a file's of ours.

    Raises:
        ConfigError: if it does, with what writes such a file.
    """
    for endings, maker in _MAKERS:
        if path.suffix.lower() in endings:
            raise ConfigError(f"{path}: must name a folder, got {path.suffix}: {maker} writes that")


def require_free(path: Path, *, force: bool) -> None:
    """Require that no file is replaced without --force.

    Raises:
        OutputError: if there is a file, and for what is no file.
    """
    from catch_arena.files import regular_file

    if regular_file(path).exists() and not force:
        raise OutputError(f"{path}: is there already: give --force to replace it, or another name")


def output_file(path: Path, *endings: str, force: bool) -> Path:
    """Reserve the path of a file: make its folder, and an empty file against other commands.

    Args:
        path: the file to write.
        endings: see `require_ending`.
        force: whether it may replace a file.

    Raises:
        ConfigError: for the ending of another format.
        OutputError: if it cannot be written, or is there already.
    """
    from catch_arena.files import prepare_folder, regular_file, unwritable

    require_ending(path, *endings)
    prepare_folder(path.parent)
    target = regular_file(path)
    try:
        target.touch(exist_ok=False)
    except FileExistsError:
        require_free(path, force=force)
    except OSError as error:
        raise unwritable(path, error) from None
    else:
        _RESERVED.append(target)
    return path


def given_or_free(given: Path | None, usual: str, *, force: bool) -> Path:
    """Return the given path, or reserve the first free name of «name.end», «name-2.end», «name-3.end» and so on.

    Args:
        given: the path that was asked for, which `output_file` has reserved.
        usual: «name.end».
        force: whether a file may be replaced, so that no other name is needed.

    Raises:
        OutputError: for a folder that cannot be written.
    """
    from catch_arena.files import prepare_folder

    if given is not None:
        return given
    usual_path = Path(usual)
    prepare_folder(usual_path.parent)
    free, number = usual_path.absolute(), 1
    while not force:
        try:
            free.touch(exist_ok=False)
        except FileExistsError:
            number += 1
            free = free.with_stem(f"{usual_path.stem}-{number}")
        else:
            _RESERVED.append(free)
            break
    return free
