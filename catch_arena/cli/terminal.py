"""Output of commands on a terminal: lines, plain tables, and the progress of long work.

Progress is a bar on a terminal, a line every few seconds elsewhere, and a line if the work is interrupted.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Final

import typer
from rich import box
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from catch_arena import interrupts
from catch_arena.errors import DamagedStoreError, MatchFailedError, OutputError, StoreError
from catch_arena.text import printable_lines

WIDE: Final = 80
"""Largest width of our tables and texts [columns]."""
_LINE_EVERY_S: Final = 5.0


def echo(text: str, *, err: bool = False) -> None:
    """Print lines, on stderr if `err`. Control characters, which a stranger's text may hold, are printed as escapes."""
    typer.echo(printable_lines(text), err=err)  # noqa: TID251 - here


def own_console(*, err: bool = False) -> Console:
    """Return a console for tables and progress bars, on stdout or stderr, without markup: `[red]` is plain text."""
    return Console(stderr=err, markup=False, highlight=False, emoji=False)


def plain_table(*headings: str, text: str = "", **options: Any) -> Table:
    """Return a table without vertical lines, with numbers aligned to the right.

    If it is too wide for the terminal, its cells take several lines, the widest first. The first column has texts, and
    so has the one with the heading `text`. The other options are those of `rich.table.Table`.
    """
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title_justify="left", caption_justify="left", **options)
    for heading in headings:
        number = heading not in {headings[0], text}
        table.add_column(heading, justify="right" if number else "left", overflow="fold")
    return table


@contextmanager
def progress_bar(description: str, total: int | None = None) -> Iterator[Callable[..., None]]:
    """Show the progress of work on stderr, and yield the function that reports it.

    The function is called with (done, total), and with a new description of the work if that changes. A terminal shows
    a bar, which disappears at the end; other outputs get a line every few seconds.
    """
    console = own_console(err=True)
    began_s = last_line_s = time.monotonic()
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    # with redirection, Rich would print stdout's text on stderr even if stdout is a file or a pipe
    redirected = own_console().is_terminal
    bar = Progress(
        *columns, console=console, transient=True, redirect_stdout=redirected, disable=not console.is_terminal
    )
    task = bar.add_task(description, total=total)

    def show(done: int, total: int, doing: str = description) -> None:
        nonlocal last_line_s
        now = time.monotonic()
        if console.is_terminal:
            bar.update(task, completed=done, total=total, description=doing)
        elif now - last_line_s >= _LINE_EVERY_S:
            last_line_s = now
            left = f", about {(now - began_s) * (total - done) / done:.0f} s left" if done else ""
            line = f"{doing}: {done} of {total}, {now - began_s:.0f} s{left}"
            console.print(line, soft_wrap=True)

    with bar:
        yield show


@contextmanager
def noting_kept_results(kept: str) -> Iterator[None]:
    """Append the text `kept`, about what is kept and how it continues, to the line about an interrupt or an error."""
    interrupts.add_to_message(kept)
    try:
        yield
    except DamagedStoreError:
        raise
    except (MatchFailedError, OutputError, StoreError) as error:
        error.args = (f"{error}; {kept}",)
        raise
