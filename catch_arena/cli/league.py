"""`catch-arena league`: a league that runs from a folder, once or again and again."""

import re
import time
from datetime import datetime, timezone
from pathlib import Path
from typing import Annotated, Final

import typer

from catch_arena import interrupts
from catch_arena.cli.app import describe, main, print_error
from catch_arena.cli.options import Arena, Cores, Limit, Seed, print_level, quotas_of, require_isolation
from catch_arena.cli.terminal import echo, progress_bar
from catch_arena.errors import CatchArenaError, ConfigError
from catch_arena.tournament.secret import Secret

_UNITS_S: Final = {"s": 1, "m": 60, "h": 3600, "d": 86400}


@main.command()
def league(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder with a file or sub-folder for each person.")],
    *,
    arena: Arena,
    every: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="Run again and again, such as every 15m, until Ctrl-C.", show_default="once"),
    ] = None,
    precision: Annotated[
        float,
        typer.Option(
            metavar="POINTS",
            min=1.0,
            max=1e4,
            help="A new version plays until the 95 % interval of its rating is at most this wide to either side.",
        ),
    ] = 100.0,
    max_matches: Annotated[
        int, typer.Option(metavar="N", min=1, help="Maximum number of matches of a version until then.")
    ] = 200,
    secret_opponents: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder with further opponents, whose names are not shown."),
    ] = None,
    seed: Seed = None,
    cores: Cores,
    limit: Limit = None,
) -> None:
    """Run a league: new and changed agents are checked and placed, and FOLDER/site shows the table.

    The same command goes on after a change or an interruption; no match is played twice. See `catch-arena docs league`.
    """
    from catch_arena.league.site import write_site
    from catch_arena.league.update import Rules, update_league

    require_isolation("a league")
    quotas = quotas_of(limit)
    pause_s = None if every is None else _seconds(every)
    print_level(quotas, ["an entry"])
    rules = Rules(arena.config(), arena.scenario, quotas, precision, max_matches, secret_opponents)
    secret = None if seed is None else Secret.parse(seed)
    interrupts.add_to_message("what was played is kept; the same command goes on")

    def run_once() -> None:
        now = datetime.now(timezone.utc)
        with progress_bar("playing until each has its place") as show:
            league = update_league(
                folder, rules, cores.workers, cores.of, now=now, secret=secret, report=echo, on_progress=show
            )
        page = write_site(league)
        echo(f"{league.new_matches} new matches")
        echo(f"site: {page}")

    def run_again(pause_s: float) -> None:
        while True:
            time.sleep(pause_s)
            try:
                run_once()
            except (CatchArenaError, OSError) as error:  # the next run tries again
                print_error(describe(error) if isinstance(error, OSError) else str(error))

    run_once()
    if pause_s is not None:
        interrupts.run_until_signal(lambda: run_again(pause_s))


def _seconds(text: str) -> float:
    """Return the seconds of a time such as 15m."""
    if not re.fullmatch(r"[1-9]\d{0,3}[smhd]", text):
        raise ConfigError(f"--every must be a number with s, m, h or d, such as 15m, got {text!r}")
    return float(text[:-1]) * _UNITS_S[text[-1]]
