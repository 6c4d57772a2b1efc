"""How a tournament looks on a terminal, 80 columns wide, or in a file that its output is sent to."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from rich import box
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from catch_arena.tournament.standings import Estimate, Standing


@contextmanager
def progress_bar(what: str, total: int | None = None) -> Iterator[Callable[[int, int], None]]:
    """A bar on stderr, to be called with (done, total); it goes away in the end, and is not shown to a file."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(what, total=total)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def standings_table(table: Sequence[Standing]) -> Table:
    """The standings; intervals are those of 95 % confidence."""
    shown = Table(
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 1, 0, 0),
        caption="score: catches a match; wins: ties shared; lost: contests lost a match",
        caption_justify="left",
    )
    shown.add_column("#", justify="right")
    shown.add_column("agent", overflow="fold")
    for heading in ("played", "score", "95 %", "wins", "95 %", "rank", "lost"):
        shown.add_column(heading, justify="right", no_wrap=True)
    for line in table:
        shown.add_row(
            str(line.place),
            line.name,
            str(line.matches),
            f"{line.score.mean:.2f}",
            _interval(line.score, 1, 1),
            f"{100 * line.win_share.mean:.0f} %",
            _interval(line.win_share, 100, 0),
            f"{line.mean_rank:.2f}",
            f"{line.contests_lost:.2f}",
            style="bold" if line.place == 1 else None,
        )
    return shown


def _interval(estimate: Estimate, scale: int, digits: int) -> str:
    if math.isnan(estimate.low):
        return "?"
    return f"{scale * estimate.low:.{digits}f} - {scale * estimate.high:.{digits}f}"
