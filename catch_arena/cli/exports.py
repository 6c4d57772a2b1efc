"""`catch-arena export`: file with a tournament's matches for other tools."""

from pathlib import Path
from typing import Annotated, Literal, get_args

import typer

from catch_arena.cli.app import main
from catch_arena.cli.outputs import Force, output_file
from catch_arena.cli.terminal import echo
from catch_arena.errors import ConfigError

Format = Literal["jsonl", "csv", "parquet"]


@main.command()
def export(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a tournament, finished or running.")],
    *,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="File to write.")],
    form: Annotated[
        Format | None,
        typer.Option(
            "--format",
            metavar="FORMAT",
            help="jsonl has a line for each match; csv and parquet have a row for each seat of each match.",
            show_default="the ending of FILE, or jsonl",
        ),
    ] = None,
    force: Force = False,
    timing: Annotated[
        bool, typer.Option("--timing/--no-timing", help="Include the time per move, which differs between runs.")
    ] = True,
) -> None:
    """Write the matches of a tournament to a file, sorted by match."""
    from catch_arena.tournament.export import export as write
    from catch_arena.tournament.store import Store

    with Store.read(folder) as store:
        ending = output.suffix.lower().removeprefix(".")
        named = next((one for one in get_args(Format) if one == ending), None)
        if form is not None and named not in {form, None}:
            raise ConfigError(
                f"--format must match the ending of the file's name, or be left out, got {form} for {output.name}"
            )
        output_file(output, *(f".{one}" for one in get_args(Format)), ".json", force=force)
        write(store, form or named or "jsonl", output, timing=timing)
        echo(f"{store.count_played()} of {store.count_planned()} matches: {output}")
