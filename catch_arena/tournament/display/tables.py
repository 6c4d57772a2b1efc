"""How a tournament looks on a terminal, usually 80 columns wide, or in a file that its output is sent to."""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import timedelta
from typing import Final

from rich.console import Console
from rich.filesize import decimal
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, TextColumn, TimeRemainingColumn
from rich.table import Table

from catch_arena.tournament.display.fitted import FittedTable
from catch_arena.tournament.execution.cost import Cost, delay, shares
from catch_arena.tournament.execution.worker import Worker
from catch_arena.tournament.plans.schedule import FixedPlan, Plan
from catch_arena.tournament.plans.until_separated import UntilSeparated
from catch_arena.tournament.statistics.intervals import Estimate
from catch_arena.tournament.statistics.standings import Standing

_KEY: Final = """grp: who shares a group cannot be told apart
rating: points, 0 is the mean; score: catches a match
wins: ties shared; cont.: of its contests, those it won"""

_LINE_EVERY_S: Final = 10.0


@contextmanager
def progress_bar(what: str, total: int | None = None, *, after_s: float = 0.0) -> Iterator[Callable[[int, int], None]]:
    """How far it is, on stderr, to be called with (done, total).

    On a terminal it is a bar, which appears after `after_s` seconds and goes away in the end; elsewhere it is a line
    now and then.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        yield progress_lines(what, console)
        return
    begin = time.monotonic()
    bar = Progress(*bar_columns(), console=console, transient=True)
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


def progress_lines(
    what: str, console: Console, clock: Callable[[], float] = time.monotonic
) -> Callable[[int, int], None]:
    """For logs and pipes: says how far it is, to be called with (done, total), in a line every ten seconds."""
    began = clock()
    said = began

    def show(done: int, total: int) -> None:
        nonlocal said
        now = clock()
        if now - said >= _LINE_EVERY_S:
            said = now
            console.print(f"{what}: {done} of {total}, {now - began:.0f} s", highlight=False, soft_wrap=True)

    return show


def bar_columns() -> tuple[ProgressColumn, ...]:
    """What stands beside and in a bar."""
    return TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()


def standings_table(table: Sequence[Standing]) -> Table:
    """The standings; margins are those of 95 % confidence."""
    forfeited = any(line.forfeits for line in table)
    shown = FittedTable(
        *("#", "agent", "grp", "played", "rating", "score", "wins", "cont."),
        *["forf."] * forfeited,
        folded="agent",
        named_by=2,
        padding=(0, 1, 0, 0),
        caption=_KEY + ("\nforf.: matches forfeited" if forfeited else ""),
    )
    for column in shown.columns:
        column.justify = "left" if column.header == "agent" else "right"
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


def plan_table(plan: Plan, worker: Worker, cost: Cost, jobs: int, max_forfeits: int) -> Table:
    """What would be played, and what it costs."""
    shown = Table(box=None, show_header=False, pad_edge=False)
    alone_s = plan.size * cost.seconds
    shown.add_row("plan", ", ".join(f"{name} {value}" for name, value in plan.parameters.items()))
    shown.add_row("matches", f"{'at most ' if isinstance(plan, UntilSeparated) else ''}{plan.size}")
    most = plan.size
    if isinstance(plan, FixedPlan):
        played, met = shares(plan, len(worker.entrants))
        most = played[1]
        shown.add_row("an agent plays", f"{_span(*played)} matches")
        shown.add_row("a pair meets in", f"{_span(*met)} matches")
    shared = f"{_duration(alone_s / jobs)} with {jobs} processes, " if jobs > 1 else ""
    shown.add_row("time", f"about {shared}{_duration(alone_s)} with one process")
    shown.add_row("store", f"about {decimal(plan.size * cost.stored)}")
    if cost.replay:
        shown.add_row("replays", f"about {decimal(plan.size * cost.replay)}")
    shown.add_row("measured on", f"{cost.tried} of its matches, which are not kept")
    for name, forfeit in cost.forfeits.items():
        shown.add_row("", f"{name} forfeited there: {forfeit}")
    worst = delay(worker, most, max_forfeits)
    if worst is not None:
        once, all_s = _duration(worst.hanging_s), worst.matches * worst.hanging_s
        then = ", then it is out" if worst.matches < most else ""
        shown.add_row("an agent that hangs", f"may take {once} a match: {_duration(all_s)} for {worst.matches}{then}")
        if worst.agents > 1:
            shown.add_row(f"all {worst.agents} that could", f"{_duration(worst.agents * all_s)} with one process")
        once, all_s = _duration(worst.slow_s), most * worst.slow_s
        shown.add_row("a slow agent", f"may take {once} a match: {_duration(all_s)} for {most}, no forfeit")
    return shown


def _span(least: int, most: int) -> str:
    return f"{least}" if least == most else f"{least} to {most}"


def _duration(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds < 60 else str(timedelta(seconds=round(seconds)))


def _with_margin(estimate: Estimate, form: str, scale: int) -> str:
    margin = "?" if math.isnan(estimate.margin) else format(scale * estimate.margin, form.removeprefix("+"))
    return f"{scale * estimate.mean:{form}} ± {margin}"
