"""How far some work is: a bar on a terminal, a line now and then elsewhere."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, TextColumn, TimeRemainingColumn

from catch_arena.cli.terminal import own_console

_LINE_EVERY_S: Final = 5.0
_LATE_S: Final = 2.0


@contextmanager
def progress_bar(what: str, total: int | None = None, *, late: bool = False) -> Iterator[Callable[[int, int], None]]:
    """Show on stderr how far some work is: yields what is to be called with (done, total).

    On a terminal it is a bar, which goes away in the end; elsewhere it is a line now and then.

    Args:
        what: is done.
        total: how much there is to do, if that is known before.
        late: whether a terminal shows nothing of work that is over soon.
    """
    console = own_console(err=True)
    if not console.is_terminal:
        yield progress_lines(what, console)
        return
    begin = time.monotonic()
    # Rich would print on stderr what goes to a file or a pipe meanwhile
    bar = Progress(*bar_columns(), console=console, transient=True, redirect_stdout=sys.stdout.isatty())
    task = bar.add_task(what, total=total)

    def show(done: int, total: int) -> None:
        bar.update(task, completed=done, total=total)
        if time.monotonic() - begin >= _LATE_S or not late:
            bar.start()

    try:
        if not late:
            bar.start()
        yield show
    finally:
        bar.stop()


def progress_lines(
    what: str, console: Console, clock: Callable[[], float] = time.monotonic
) -> Callable[[int, int], None]:
    """Return what prints a line every few seconds for logs and pipes, to be called with (done, total)."""
    began = said = clock()

    def show(done: int, total: int) -> None:
        nonlocal said
        now = clock()
        if now - said >= _LINE_EVERY_S:
            said = now
            left = (now - began) * (total - done) / max(done, 1)
            console.print(f"{what}: {done} of {total}, {now - began:.0f} s, some {left:.0f} s left", soft_wrap=True)

    return show


def bar_columns() -> tuple[ProgressColumn, ...]:
    """Return what stands next to and in a bar."""
    return TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
