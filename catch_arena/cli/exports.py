"""`catch-arena export`: a tournament's matches for other tools."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from catch_arena.cli.app import main
from catch_arena.cli.outputs import Force, output_file


@main.command()
def export(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a tournament, ended or not.")],
    *,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="The file to write.")],
    form: Annotated[
        Literal["jsonl", "csv", "parquet"],
        typer.Option(
            "--format", help="jsonl: a line for each match; csv and parquet: a row for each seat of each match."
        ),
    ] = "jsonl",
    force: Force = False,
    timing: Annotated[
        bool, typer.Option("--timing/--no-timing", help="With the time per move, which no other run repeats.")
    ] = True,
) -> None:
    """Write the matches of a tournament to a file, sorted by match."""
    from catch_arena.tournament.records.export import export as write
    from catch_arena.tournament.records.store import Store

    with Store.read(folder) as store:
        output_file(output, force=force)
        write(store, form, output, timing=timing)
        typer.echo(f"{store.count_played()} of {store.count_planned()} matches: {output}")
