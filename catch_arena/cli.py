"""The command line. Each command checks its words, calls the library, and says where the results are."""

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from rich import box
from rich.console import Console
from rich.table import Table
from typer.core import TyperGroup

from catch_arena.config import ArenaConfig
from catch_arena.errors import CatchArenaError, ConfigError, ReplayError
from catch_arena.scenarios import SCENARIOS, scenario

# what is heavy (the engine, the renderer) is imported by the commands that need it: --help must be quick

INTERRUPTED = 130
REFUSED = 2


class _Commands(TyperGroup):
    """Turns our errors into one line and an exit code."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was named."""
        try:
            return super().invoke(ctx)
        except CatchArenaError as error:
            typer.echo(f"catch-arena: {error}", err=True)
            raise typer.Exit(REFUSED) from None
        except KeyboardInterrupt:
            typer.echo("catch-arena: interrupted", err=True)
            raise typer.Exit(INTERRUPTED) from None


main = typer.Typer(
    name="catch-arena",
    help="Hunters chase turtles, and a referee decides who caught what.",
    cls=_Commands,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

Agents = Annotated[
    list[str],
    typer.Argument(
        metavar="AGENT...",
        help="A shipped name (see `catch-arena agents`), package.module:Class, or a .py file with a class Agent.",
    ),
]
Scenario = Annotated[str, typer.Option("--scenario", "-s", help="The arena to play in (see `catch-arena scenarios`).")]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change a setting, as in time_limit_s=30 or faults.kill_down=0.2; may be repeated.",
    ),
]
Layout = Literal["broadcast", "arena"]
Seed = Annotated[int, typer.Option(help="Whatever is drawn follows from it.")]


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"catch-arena {version('catch-arena')}")
        raise typer.Exit


@main.callback()
def _common(
    *,
    version: Annotated[
        bool, typer.Option("--version", help="Show the version and exit.", callback=_show_version, is_eager=True)
    ] = False,
) -> None:
    del version


@main.command()
def tournament(
    agents: Agents,
    *,
    scenario: Scenario = "standard",
    rounds: Annotated[int, typer.Option(help="How often each group of agents meets, in every seating.")] = 1,
    seed: Seed = 0,
    jobs: Annotated[
        int | None, typer.Option("--jobs", "-j", help="Processes that play.", show_default="all cores")
    ] = None,
    out: Annotated[
        Path,
        typer.Option(help="The folder for results.jsonl, standings.csv and standings.json; older ones are replaced."),
    ] = Path("out/tournament"),
    record: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Also keep a replay of each match in this folder.")
    ] = None,
    settings: Settings = None,
) -> None:
    """Play every group of agents in every seating, and rank them.

    The same words and seed write the same bytes, whatever --jobs is.
    """
    from catch_arena.tournament import entrants, results, runner, schedule, standings
    from catch_arena.tournament.display import progress_bar, standings_table

    config = arena(scenario, settings)
    if jobs is None:
        jobs = runner.usable_cores()
    if jobs < 1:
        raise ConfigError(f"--jobs must be at least 1, got {jobs}")
    players = entrants.enter(agents)
    schedule.require_enough(len(players), config, scenario)
    plan = schedule.round_robin(len(players), config.hunters, rounds, seed)
    for folder in (out, record):
        if folder is not None:
            results.prepare_folder(folder)
    typer.echo(f"{scenario}: {len(players)} agents, {len(plan)} matches, {config.hunters} in each")
    with progress_bar("playing", len(plan)) as show:
        played = runner.run(config, players, plan, jobs=jobs, record=record, progress=show)
    table = standings.standings(players, played)
    results.write_results(out, config=config, seed=seed, entrants=players, played=played, table=table)
    Console().print(standings_table(table))
    typer.echo(f"results: {out}")
    if record is not None:
        typer.echo(f"replays: {record}")


@main.command()
def match(
    agents: Agents,
    *,
    scenario: Scenario = "standard",
    seed: Seed = 0,
    output: Annotated[Path, typer.Option("--output", "-o", help="The replay to write.")] = Path("match.replay"),
    settings: Settings = None,
) -> None:
    """Play one match, seated in the order given, and record it."""
    from catch_arena.replay import regular_file
    from catch_arena.tournament.entrants import enter
    from catch_arena.tournament.match import play
    from catch_arena.tournament.results import prepare_folder
    from catch_arena.tournament.schedule import require_enough

    config = arena(scenario, settings)
    players = enter(agents)
    require_enough(len(players), config, scenario)
    if len(players) > config.hunters:
        raise ConfigError(f"agents must be {config.hunters}, one for each hunter of {scenario}, got {len(players)}")
    prepare_folder(output.parent)
    regular_file(output)
    names = [player.name for player in players]
    result = play(config, seed, [player.create() for player in players], names, title=scenario, record=output)
    for rank, score, name in sorted(zip(result.ranks, result.scores, names, strict=True), key=lambda line: line[0]):
        typer.echo(f"{rank:>3}  {score:>3}  {name}")
    typer.echo(f"replay: {output}")


@main.command()
def render(
    replay: Annotated[Path, typer.Argument(help="A recorded match.")],
    *,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The MP4 file to write.", show_default="beside the replay")
    ] = None,
    size: Annotated[str, typer.Option(metavar="WIDTHxHEIGHT", help="Of the picture, in pixels.")] = "1280x720",
    fps: Annotated[int, typer.Option(help="Frames per second.")] = 60,
    layout: Annotated[Layout, typer.Option(help="With the scores, or the arena alone.")] = "broadcast",
) -> None:
    """Turn a recorded match into a video."""
    from catch_arena.render.video import render_replay
    from catch_arena.replay import Replay
    from catch_arena.tournament.display import progress_bar
    from catch_arena.tournament.results import prepare_folder

    recorded = Replay.load(replay)
    target = replay.with_suffix(".mp4") if output is None else output
    prepare_folder(target.parent)
    with progress_bar("rendering") as show:
        report = render_replay(recorded, target, size=width_and_height(size), fps=fps, layout=layout, progress=show)
    if report.notice:
        typer.echo(report.notice, err=True)
    typer.echo(f"video: {target} ({report.frames} frames, {report.seconds:g} s)")


@main.command()
def verify(replays: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Recorded matches.")]) -> None:
    """Play recorded matches again, and compare every step's digest."""
    from catch_arena.replay import Replay

    bad = 0
    for path in replays:
        try:
            replay = Replay.load(path)
            for _ in replay.worlds():
                pass
        except ReplayError as error:
            bad += 1
            text = str(error)
            typer.echo(text if text.startswith(str(path)) else f"{path}: {text}", err=True)
        else:
            typer.echo(f"{path}: all of {replay.steps} steps play as recorded")
    if bad:
        raise ReplayError(f"{bad} of {len(replays)} replays failed")


@main.command()
def agents() -> None:
    """List the agents that come with the package."""
    from catch_arena.tournament.entrants import shipped

    table = _table("agent", "what it does")
    for name, line in shipped().items():
        table.add_row(name, line)
    Console().print(table)


@main.command()
def scenarios() -> None:
    """List the scenarios."""
    table = _table("scenario", "hunters", "side m", "max m/s", "at start", "at most", "per s", "seconds")
    for column in table.columns[1:]:
        column.justify = "right"
    for name, config in SCENARIOS.items():
        table.add_row(
            name,
            str(config.hunters),
            f"{config.side_m:.1f}",
            f"{config.max_speed_mps:.1f}",
            str(config.initial_targets),
            str(config.max_targets),
            f"{1000 / config.spawn_period_ms:g}",
            f"{config.time_limit_s:g}",
        )
    Console().print(table)


def arena(name: str, settings: list[str] | None) -> ArenaConfig:
    """The scenario with the changes of --set. Raises: ConfigError."""
    overrides: dict[str, Any] = {}
    for word in settings or ():
        key, equals, text = word.partition("=")
        if not equals or not key:
            raise ConfigError(f"--set must be KEY=VALUE, got {word!r}")
        if key == "control":
            raise ConfigError("--set control=... must be left to the agents: each states its own control")
        try:
            value = json.loads(text)
        except ValueError:
            value = text  # a bare word
        group, dot, part = key.partition(".")
        if not dot:
            overrides[key] = value
        elif isinstance(parts := overrides.setdefault(group, {}), dict):
            parts[part] = value
        else:
            raise ConfigError(f"--set {group}=... and --set {key}=... must not both be given")
    return scenario(name, **overrides)


def width_and_height(text: str) -> tuple[int, int]:
    """«1280x720» as two numbers. Raises: ConfigError."""
    width, cross, height = text.lower().partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise ConfigError(f"size must be WIDTHxHEIGHT as in 1280x720, got {text!r}")
    return int(width), int(height)


def _table(*headings: str) -> Table:
    return Table(*headings, box=box.SIMPLE_HEAD, pad_edge=False)
