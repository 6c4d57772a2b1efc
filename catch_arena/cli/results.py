"""`catch-arena report` and `export`: the page of a tournament, and a file with its matches for other tools."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from catch_arena import interrupts
from catch_arena.cli.app import main
from catch_arena.cli.outputs import PAGE, Force, output_option, reserve_file
from catch_arena.cli.terminal import echo
from catch_arena.errors import ConfigError
from catch_arena.tournament.store import Store

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a tournament, finished or running.")]
_MOST_MB = 1000


@main.command()
def report(
    folder: Folder,
    *,
    output: Annotated[Path | None, output_option("HTML file to write.", "DIR/report.html")] = None,
    force: Force = False,
    budget: Annotated[
        float | None, typer.Option(metavar="MB", help="Maximum size of the replays in the page.", show_default="1")
    ] = None,
    match: Annotated[
        list[str] | None, typer.Option(metavar="ID", help="A recorded match to include in the page; may be repeated.")
    ] = None,
    watch: Annotated[
        bool,
        typer.Option(
            "--watch",
            help="Serve the page on 127.0.0.1 instead, and update it while the tournament runs, until Ctrl-C.",
        ),
    ] = False,
) -> None:
    """Write a report: one HTML file with the standings, charts, and replays to watch."""
    if budget is not None and not 0 <= budget <= _MOST_MB:  # NaN is refused too
        raise ConfigError(f"--budget must be from 0 to {_MOST_MB} MB, got {budget:g}")
    if watch:
        if budget is not None or match or output is not None:
            raise ConfigError("--budget, --match and --output must be left out with --watch, which shows every replay")
        from catch_arena.report.watch import LiveReport, serve

        live = LiveReport(folder)
        live.state()  # raises errors here, before a browser opens the page
        with serve(live) as address:
            interrupts.wait(lambda: echo(f"report: {address} (Ctrl-C ends)"))
        return
    from catch_arena.report import BUDGET, write_report

    reserve_file(output, PAGE, force=force)
    size = BUDGET if budget is None else round(1e6 * budget)
    echo(f"report: {write_report(folder, budget=size, matches=match or (), output=output)}")


@main.command()
def export(
    folder: Folder,
    *,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="File to write.")],
    form: Annotated[
        Literal["jsonl", "csv", "parquet"] | None,
        typer.Option(
            "--format",
            metavar="FORMAT",
            help="jsonl has a line for each match; csv and parquet have a row for each seat of each match.",
            show_default="the ending of FILE",
        ),
    ] = None,
    force: Force = False,
    timing: Annotated[
        bool, typer.Option("--timing/--no-timing", help="Include the time per move, which differs between runs.")
    ] = True,
) -> None:
    """Write the matches of a tournament to a file, sorted by match."""
    from catch_arena.tournament.export import export as write

    with Store.read(folder) as store:
        reserve_file(output, ".jsonl", ".csv", ".parquet", force=force)
        named = output.suffix.lower().removeprefix(".")
        if form not in {named, None}:
            raise ConfigError(
                f"--format must match the ending of the file's name, or be left out, got {form} for {output.name}"
            )
        write(store, named, output, timing=timing)
        echo(f"{store.count_played()} of {store.count_planned()} matches: {output}")
