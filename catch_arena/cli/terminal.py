"""Output of commands on a terminal: lines, and plain tables."""

from typing import Any, Final

import typer
from rich import box
from rich.console import Console
from rich.table import Table

from catch_arena.text import printable_lines

WIDE: Final = 80
"""Largest width of our tables and texts [columns]."""


def echo(text: str, *, err: bool = False) -> None:
    """Print lines, on stderr if `err`. Control characters, which a stranger's text may hold, are printed as escapes."""
    typer.echo(printable_lines(text), err=err)  # noqa: TID251 - here


def own_console(*, err: bool = False) -> Console:
    """Return a console for tables and progress bars, on stdout or stderr, without markup: `[red]` is plain text."""
    return Console(stderr=err, markup=False, highlight=False, emoji=False)


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
