"""How far some work is: a bar on a terminal, a line now and then elsewhere."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from catch_arena.cli.terminal import own_console

_LINE_EVERY_S: Final = 5.0
_LATE_S: Final = 2.0


@contextmanager
def progress_bar(what: str, total: int | None = None, *, late: bool = False) -> Iterator[Callable[..., None]]:
    """Show on stderr how far some work is: yields what is to be called with (done, total), and with what is done
    now if that changes.

    On a terminal it is a bar, which goes away in the end; elsewhere it is a line now and then.

    Args:
        what: is done.
        total: how much there is to do, if that is known before.
        late: whether a terminal shows nothing of work that is over soon.
    """
    console = own_console(err=True)
    began = said = time.monotonic()
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    # Rich would print on stderr what goes to a file or a pipe meanwhile
    bar = Progress(*columns, console=console, transient=True, redirect_stdout=own_console().is_terminal)
    task = bar.add_task(what, total=total)

    def show(done: int, total: int, doing: str = what) -> None:
        nonlocal said
        now = time.monotonic()
        if console.is_terminal:
            bar.update(task, completed=done, total=total, description=doing)
            if now - began >= _LATE_S:
                bar.start()
        elif now - said >= _LINE_EVERY_S:
            said = now
            left = (now - began) * (total - done) / max(done, 1)
            line = f"{doing}: {done} of {total}, {now - began:.0f} s, some {left:.0f} s left"
            console.print(line, soft_wrap=True)

    try:
        if console.is_terminal and not late:
            bar.start()
        yield show
    finally:
        if console.is_terminal:
            bar.stop()
