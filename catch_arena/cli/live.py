"""`catch-arena play` and `watch`: matches in a window."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from catch_arena.cli.app import (
    Agents,
    ArenaSeed,
    LimitOption,
    Scenario,
    SettingOption,
    Trusted,
    arena,
    enter_agents,
    limits_or_trust,
    main,
)
from catch_arena.cli.matches import print_logs, print_result
from catch_arena.cli.outputs import REPLAY, Force, given_or_free, output_file
from catch_arena.cli.terminal import say
from catch_arena.cli.videos import width_and_height
from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError

if TYPE_CHECKING:
    from catch_arena.replay import Replay
    from catch_arena.tournament.isolation.limits import AgentLimits

_RIVALS = ("nearest", "contested_by_time", "patrol")

Record = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Where to save the replay.",
        show_default="with Ctrl-S: match.replay, or match-2.replay ...",
    ),
]
Size = Annotated[str, typer.Option(metavar="WIDTHxHEIGHT", help="Size of the window; it can be resized.")]


@main.command()
def play(
    agents: Annotated[
        list[str] | None,
        typer.Argument(metavar="[AGENT...]", help="Rivals too, the same as after --against.", show_default=False),
    ] = None,
    *,
    against: Annotated[
        list[str] | None,
        typer.Option(
            metavar="AGENT...",
            help="Your rivals; if there are fewer rivals than seats, a rival plays several seats.",
            show_default=", ".join(_RIVALS),
        ),
    ] = None,
    scenario: Scenario = "standard",
    seat: Annotated[str, typer.Option(help="Your seat: the number of a hunter, from 0, or prey_0 ...")] = "0",
    seed: ArenaSeed = None,
    trusted: Trusted = False,
    limits: LimitOption = None,
    record: Record = None,
    force: Force = False,
    size: Size = "1280x720",
    settings: SettingOption = None,
) -> None:
    """Take a seat yourself, with turtlesim's keys or a gamepad, against agents.

    The keys are shown in the window. A target within reach is requested for you.

    Where there are teams, an agent plays all hunters of one; the first plays your team-mates. Where there is prey,
    agents play that too, after the hunters.
    """
    config = arena(scenario, settings)
    person = _seat(seat, config, scenario)
    rivals = [*(against or ()), *(agents or ())] or list(_RIVALS)
    allowed = limits_or_trust(limits, trusted=trusted)
    _show(rivals, allowed, person, _WindowOptions(scenario, config, seed, record, size, force))


@main.command()
def watch(
    agents: Agents,
    *,
    scenario: Scenario = "standard",
    seed: ArenaSeed = None,
    trusted: Trusted = False,
    limits: LimitOption = None,
    record: Record = None,
    force: Force = False,
    size: Size = "1280x720",
    settings: SettingOption = None,
) -> None:
    """Watch agents play, live; if there are fewer agents than seats, an agent plays several seats."""
    allowed = limits_or_trust(limits, trusted=trusted)
    config = arena(scenario, settings)
    _show(agents, allowed, None, _WindowOptions(scenario, config, seed, record, size, force))


def _seat(seat: str, config: ArenaConfig, scenario: str) -> int:
    """The person's, where the prey's come after the hunters'."""
    agents = [*config.hunter_names, *config.prey_names]
    numbers = {str(number): number for number in range(config.hunters)}
    named = {name: place for place, name in enumerate(agents)}
    if seat not in numbers | named:
        prey = (
            f", or {' to '.join(dict.fromkeys((config.prey_names[0], config.prey_names[-1])))}" if config.prey else ""
        )
        raise ConfigError(f"--seat must be from 0 to {config.hunters - 1}{prey} in {scenario}, got {seat}")
    return (numbers | named)[seat]


class _WindowOptions(NamedTuple):
    """What match is shown, how large, and where it is saved."""

    scenario: str
    config: ArenaConfig
    seed: int | None
    record: Path | None
    size: str
    force: bool


def _show(agents: list[str], limits: "AgentLimits | None", person: int | None, options: _WindowOptions) -> None:
    """Seat the agents, one after the other and over again, and play in a window."""
    from catch_arena.files import prepare_folder
    from catch_arena.live.session import free_parties, line_up, show_match
    from catch_arena.render.renderer import checked_size
    from catch_arena.seeding import arena_seed
    from catch_arena.tournament.parties import Parties

    scenario, config, seed, record, size, force = options
    free = len(free_parties(config, person))
    if len(agents) > free:
        seats = "free seat" if config.teams is None else "team and prey" if config.prey else "team"
        raise ConfigError(f"agents must be {free} at most, one for each {seats} of {scenario}, got {len(agents)}")
    window = checked_size(width_and_height(size))
    players = enter_agents([agents[index % len(agents)] for index in range(free)], limits)
    lineup = line_up(config, players, person)
    if record is not None:
        output_file(record, *REPLAY, force=force)
    else:
        prepare_folder(Path.cwd())

    def save(replay: "Replay") -> str:
        target = given_or_free(record, "match.replay", force=force)
        replay.save(target)
        return str(target)

    shown = show_match(config, arena_seed(seed), lineup, limits, title=scenario, size=window, save=save)
    print_logs(shown.replay.names, shown.logs)
    print_result(Parties.of(config), shown, shown.names)
    if record is not None:
        say(f"replay: {save(shown.replay)}")
