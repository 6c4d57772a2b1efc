"""`catch-arena agents` and `scenarios`: what there is."""

from rich.console import Console

from catch_arena.cli.app import main
from catch_arena.cli.fitted_table import FittedTable
from catch_arena.scenarios import SCENARIOS


@main.command()
def agents() -> None:
    """List the agents that come with the package."""
    from catch_arena.tournament.entrants import shipped

    listing = FittedTable("agent", "what it does", folded="what it does")
    for name, line in shipped().items():
        listing.add_row(name, line)
    Console().print(listing)


@main.command()
def scenarios() -> None:
    """List the scenarios."""
    listing = FittedTable("scenario", "hunters", "side m", "max m/s", "at start", "at most", "per s", "seconds")
    for column in listing.columns[1:]:
        column.justify = "right"
    for name, config in SCENARIOS.items():
        listing.add_row(
            name,
            str(config.hunters),
            f"{config.side_m:.1f}",
            "-".join(f"{speed:.1f}" for speed in sorted({min(config.max_speeds), max(config.max_speeds)})),
            str(config.initial_targets),
            str(config.max_targets),
            f"{1000 / config.spawn_period_ms:g}",
            f"{config.time_limit_s:g}",
        )
    Console().print(listing)
