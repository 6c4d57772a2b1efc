"""Where a command prints, and its plain tables."""

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from pathlib import Path
from typing import IO, Any, Final, cast

import typer
from rich import box
from rich.console import Console
from rich.file_proxy import FileProxy
from rich.table import Table

from catch_arena.streams import lasting
from catch_arena.text import printable_lines

WIDE: Final = 80
"""Columns that our tables and texts need at most."""
_OWN: Final[dict[bool, IO[str] | None]] = {}
"""Where this command prints, stdout at False and stderr at True: see `own_streams`."""
_FOLDER: Final[list[str]] = []
"""The folder that this command was started in."""


def say(text: str, *, err: bool = False) -> None:
    """Print lines, `err` on stderr. Control characters that a stranger's text may hold are shown, not sent."""
    typer.echo(printable_lines(shown(text)), file=_stream(err=err), err=err)  # noqa: TID251 - here


def shown(text: str) -> str:
    """Shorten paths in a text that begin with our working folder, as they may be on the command line."""
    return re.sub(rf"(?<!\S){re.escape(_FOLDER[0] + os.sep)}", "", text) if _FOLDER else text


def own_console(*, err: bool = False) -> Console:
    """Return a console for tables and progress bars, on stdout or stderr. Texts are shown as they stand: `[red]` is no
    markup in them.
    """
    return Console(file=_stream(err=err), markup=False, highlight=False, emoji=False)


def plain_table(*headings: str, text: str = "", **options: Any) -> Table:
    """Return a table without vertical lines, in which numbers stand to the right. Where it is too wide for the
    terminal, its cells take several lines, the widest first.

    Args:
        headings: of the columns.
        text: the heading of a column of texts, if it is not the first.
        options: as of `rich.table.Table`.
    """
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title_justify="left", caption_justify="left", **options)
    for heading in headings:
        number = heading not in {headings[0], text}
        table.add_column(heading, justify="right" if number else "left", overflow="fold")
    return table


def _stream(*, err: bool) -> IO[str] | None:
    current: Any = sys.stderr if err else sys.stdout
    with suppress(AttributeError, OSError, ValueError):
        current.flush()  # what a trusted agent has printed comes first
    if isinstance(current, FileProxy):  # of Rich, while it shows a bar
        return cast(IO[str], current)
    return _OWN.get(err, current)


@contextmanager
def own_streams() -> Iterator[None]:
    """Print to copies of stdout and stderr from here on: a trusted agent may close, replace or change those in sys."""
    copies = []
    _FOLDER.clear()
    with suppress(FileNotFoundError):
        _FOLDER.append(str(Path.cwd()))
    for err, stream in ((False, sys.stdout), (True, sys.stderr)):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a letter that a terminal cannot show is a question mark
        _OWN[err] = stream
        with suppress(AttributeError, OSError, ValueError):  # no stream, or one in memory
            copies.append(lasting(stream, os.dup(stream.fileno())))
            _OWN[err] = copies[-1]
    try:
        yield
    finally:
        _OWN.clear()
        for copy in copies:
            with suppress(OSError):  # of a full disk, which has been reported
                copy.close()
