"""How a tournament looks on a terminal, 80 columns wide, or in a file that its output is sent to."""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import timedelta
from typing import Final

from rich import box
from rich.console import Console
from rich.filesize import decimal
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, TextColumn, TimeRemainingColumn
from rich.table import Table

from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution.cost import Cost, shares
from catch_arena.tournament.plans.schedule import FixedPlan, Plan
from catch_arena.tournament.sequential.until_separated import UntilSeparated
from catch_arena.tournament.statistics.intervals import Estimate
from catch_arena.tournament.statistics.standings import Standing

_KEY: Final = """grp: who shares a group cannot be told apart
rating: points, 0 is the mean; score: catches a match
wins: ties shared; cont.: of its contests, those it won"""


@contextmanager
def progress_bar(what: str, total: int | None = None, *, after_s: float = 0.0) -> Iterator[Callable[[int, int], None]]:
    """A bar on stderr, to be called with (done, total); it appears after `after_s` seconds, goes away in the end, and
    is not shown to a file.
    """
    console = Console(stderr=True)
    begin = time.monotonic()
    bar = Progress(*bar_columns(), console=console, transient=True, disable=not console.is_terminal)
    task = bar.add_task(what, total=total)

    def show(done: int, total: int) -> None:
        bar.update(task, completed=done, total=total)
        if time.monotonic() - begin >= after_s:
            bar.start()

    try:
        if not after_s:
            bar.start()
        yield show
    finally:
        bar.stop()


def bar_columns() -> tuple[ProgressColumn, ...]:
    """What stands beside and in a bar."""
    return TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()


def standings_table(table: Sequence[Standing]) -> Table:
    """The standings; margins are those of 95 % confidence."""
    forfeited = any(line.forfeits for line in table)
    shown = Table(
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 1, 0, 0),
        caption=_KEY + ("\nout: matches forfeited" if forfeited else ""),
        caption_justify="left",
    )
    shown.add_column("#", justify="right")
    shown.add_column("agent", overflow="fold")
    headings = ["grp", "played", "rating", "score", "wins", "cont."] + ["out"] * forfeited
    for heading in headings:
        shown.add_column(heading, justify="right", no_wrap=True)
    for line in table:
        cells = [
            str(line.place),
            line.name,
            line.group,
            str(line.matches),
            _with_margin(line.rating, "+.0f", 1),
            _with_margin(line.score, ".1f", 1),
            _with_margin(line.win_share, ".0f", 100) + " %",
            "-" if math.isnan(line.contest_wins) else f"{100 * line.contest_wins:.0f} %",
        ]
        if forfeited:
            cells.append(str(sum(line.forfeits.values())))
        shown.add_row(*cells, style="bold" if line.place == 1 else None)
    return shown


def plan_table(plan: Plan, entrants: Sequence[Entrant], cost: Cost, jobs: int) -> Table:
    """What would be played, and what it costs."""
    shown = Table(box=None, show_header=False, pad_edge=False)
    alone_s = plan.size * cost.seconds
    shown.add_row("plan", ", ".join(f"{name} {value}" for name, value in plan.words.items()))
    shown.add_row("matches", f"{'at most ' if isinstance(plan, UntilSeparated) else ''}{plan.size}")
    if isinstance(plan, FixedPlan):
        played, met = shares(plan, len(entrants))
        shown.add_row("an agent plays", f"{_span(*played)} matches")
        shown.add_row("a pair meets in", f"{_span(*met)} matches")
    shared = f"{_duration(alone_s / jobs)} with {jobs} processes, " if jobs > 1 else ""
    shown.add_row("time", f"about {shared}{_duration(alone_s)} with one process")
    shown.add_row("store", f"about {decimal(plan.size * cost.stored)}")
    if cost.replay:
        shown.add_row("replays", f"about {decimal(plan.size * cost.replay)}")
    shown.add_row("measured on", f"{cost.tried} of its matches, which are not kept")
    return shown


def _span(least: int, most: int) -> str:
    return f"{least}" if least == most else f"{least} to {most}"


def _duration(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds < 60 else str(timedelta(seconds=round(seconds)))


def _with_margin(estimate: Estimate, form: str, scale: int) -> str:
    margin = "?" if math.isnan(estimate.margin) else format(scale * estimate.margin, form.removeprefix("+"))
    return f"{scale * estimate.mean:{form}} ± {margin}"
