"""`catch-arena agents`, `scenarios` and `docs`: lists of the agents, scenarios and pages in the package."""

import json
from pathlib import Path
from typing import Annotated, Final

import typer

from catch_arena.cli.app import main
from catch_arena.cli.terminal import echo, own_console, plain_table
from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError, suggest
from catch_arena.scenarios import SCENARIOS
from catch_arena.tournament.loading import shipped

_LISTED: Final = {"hunters", "side_m", "spawn_frequency_hz"}
"""Settings with a separate column."""


@main.command()
def agents(
    *, ladder: Annotated[bool, typer.Option("--ladder", help="List the frozen learned agents instead.")] = False
) -> None:
    """List the agents that come with the package."""
    listing = plain_table("agent", "what it does", text="what it does")
    for name, line in shipped(ladder=ladder).items():
        listing.add_row(name, line)
    own_console().print(listing)


@main.command()
def scenarios() -> None:
    """List the scenarios."""
    listing = plain_table("scenario", "hunters", "side m", "per s", "other settings", text="other settings")
    usual = ArenaConfig().to_flat_dict()
    for name, config in SCENARIOS.items():
        numbers = (str(config.hunters), f"{config.side_m:.1f}", f"{1000 / config.spawn_period_ms:g}")
        others = [  # as --set takes them
            f"{setting}={value if isinstance(value, str) else json.dumps(value, separators=(',', ':'))}"
            for setting, value in config.to_flat_dict().items()
            if setting not in _LISTED and value != usual[setting]
        ]
        listing.add_row(name, *numbers, ", ".join(others))
    own_console().print(listing)


@main.command()
def docs(
    page: Annotated[
        str | None,
        typer.Argument(metavar="PAGE", help="The page to print, for example agents.", show_default=False),
    ] = None,
) -> None:
    """Print a page of the documentation, or list the pages."""
    package = Path(__file__).parents[1]
    inside = package / "docs"  # the place in a wheel
    folder = inside if inside.is_dir() else package.parent / "docs"
    pages = {path.stem: path.read_text(encoding="utf-8") for path in sorted(folder.rglob("*.md"))}
    if page is None:
        listing = plain_table("page", "title", text="title")
        for name, text in pages.items():
            listing.add_row(name, text.partition("\n")[0].removeprefix("# "))
        own_console().print(listing)
        return
    name = page.lower().rpartition("/")[2].removesuffix(".md")
    if name not in pages:
        raise ConfigError(f"unknown page {page!r}: {suggest(name, pages)}")
    echo(pages[name].rstrip("\n"))
