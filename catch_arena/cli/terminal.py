"""Output of commands on a terminal: lines, and plain tables."""

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from pathlib import Path
from typing import IO, Any, Final

import typer
from rich import box
from rich.console import Console
from rich.file_proxy import FileProxy
from rich.table import Table

from catch_arena.text import printable_lines

WIDE: Final = 80
"""Largest width of our tables and texts [columns]."""
_OWN: Final[list[IO[str] | None]] = []
"""Streams of this command, stdout and stderr; empty if no command runs."""
_FOLDER: Final[list[str]] = []
"""Folder that this command was started in; empty if it does not exist."""


def echo(text: str, *, err: bool = False) -> None:
    """Print lines, on stderr if `err`. Control characters, which a stranger's text may hold, are printed as escapes."""
    typer.echo(printable_lines(shown(text)), file=_stream(err=err), err=err)  # noqa: TID251 - here


def shown(text: str) -> str:
    """Return a text with relative paths in place of absolute paths in the working folder, as on the command line."""
    return re.sub(rf"(?<!\S){re.escape(_FOLDER[0] + os.sep)}", "", text) if _FOLDER else text


def own_console(*, err: bool = False) -> Console:
    """Return a console for tables and progress bars, on stdout or stderr, without markup: `[red]` is plain text."""
    return Console(file=_stream(err=err), markup=False, highlight=False, emoji=False)


def plain_table(*headings: str, text: str = "", **options: Any) -> Table:
    """Return a table without vertical lines, with numbers aligned to the right.

    If it is too wide for the terminal, its cells take several lines, the widest first.

    Args:
        headings: headings of the columns.
        text: heading of a column of texts in addition to the first.
        options: options of `rich.table.Table`.
    """
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title_justify="left", caption_justify="left", **options)
    for heading in headings:
        number = heading not in {headings[0], text}
        table.add_column(heading, justify="right" if number else "left", overflow="fold")
    return table


def _stream(*, err: bool) -> IO[str] | None:
    current = sys.stderr if err else sys.stdout
    # Rich's proxy prints above a bar while the bar is shown
    return _OWN[err] if _OWN and not isinstance(current, FileProxy) else current


@contextmanager
def own_streams() -> Iterator[None]:
    """Print to the present stdout and stderr in this context, even if a trusted agent replaces those in sys."""
    _OWN[:] = sys.stdout, sys.stderr
    _FOLDER.clear()
    with suppress(FileNotFoundError):
        _FOLDER.append(str(Path.cwd()))
    for stream in _OWN:
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a letter that a terminal cannot show becomes a question mark
    try:
        yield
    finally:
        _OWN.clear()
