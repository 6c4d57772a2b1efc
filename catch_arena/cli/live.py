"""`catch-arena play` and `watch`: matches in a window."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from catch_arena.cli.app import main
from catch_arena.cli.matches import print_result
from catch_arena.cli.options import Agents, Arena, ArenaSeed, Trust, enter_agents
from catch_arena.cli.outputs import REPLAY, Force, reserve_file, reserve_free_file
from catch_arena.cli.terminal import echo
from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError, suggest
from catch_arena.files import prepare_folder
from catch_arena.seeding import arena_seed
from catch_arena.tournament.parties import Parties

if TYPE_CHECKING:
    from catch_arena.replay import Replay

_RIVALS = ("nearest", "contested_by_time", "patrol")
_SIZE = (1280, 720)


@dataclass(frozen=True)
class Window(Trust, Arena):
    """Options for a match in a window."""

    seed: ArenaSeed = None


@main.command()
def play(
    agents: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="AGENT...",
            help="Your rivals; if there are fewer rivals than seats, a rival plays several seats.",
            show_default=", ".join(_RIVALS),
        ),
    ] = None,
    *,
    seat: Annotated[str, typer.Option(help="Your seat: the number of a hunter, from 0, or prey_0, prey_1, ...")] = "0",
    window: Window,
    record: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Save the replay to this file.",
            show_default="with Ctrl-S: match.replay, or match-2.replay ...",
        ),
    ] = None,
    force: Force = False,
) -> None:
    """Play against agents yourself, with turtlesim's keys or a gamepad.

    The window shows the keys. A target within reach is requested for you.

    If there are teams, each agent plays all hunters of one team; the first plays your team-mates. If there is prey,
    agents play it too: give them after the hunters' agents.
    """
    _show(agents or list(_RIVALS), window, seat, record, force=force)


@main.command()
def watch(agents: Agents, *, window: Window) -> None:
    """Watch agents play, live; if there are fewer agents than seats, an agent plays several seats."""
    _show(agents, window, None, None, force=False)


def _show(agents: list[str], window: Window, seat: str | None, record: Path | None, *, force: bool) -> None:
    """Play a match in a window: a person takes `seat`, if any, and the agents take the other seats in turn."""
    from catch_arena.live.session import show_match

    config, quotas = window.config(), window.quotas()
    person = None if seat is None else _seat(seat, config, window.scenario)
    parties = Parties.of(config)
    free = [party for party, seats in enumerate(parties.seats) if seats != (person,)]
    if len(agents) > len(free):
        seats = "free seat" if config.teams is None else "team and prey" if config.prey else "team"
        raise ConfigError(
            f"number of agents must be at most {len(free)}, one for each {seats} of {window.scenario}, "
            f"got {len(agents)}"
        )
    entered = enter_agents([agents[index % len(agents)] for index in range(len(free))], quotas)
    entrants = dict(zip(free, entered, strict=True))
    reserve_file(record, REPLAY, force=force)
    if record is None:
        prepare_folder(Path.cwd())

    def save(replay: "Replay") -> str:
        target = record or reserve_free_file("match.replay", force=force)
        replay.save(target)
        return str(target)

    seed = arena_seed(window.seed)
    shown = show_match(config, seed, entrants, person, quotas, title=window.scenario, size=_SIZE, save=save)
    print_result(parties, shown.result, shown.names)
    if record is not None:
        echo(f"replay: {save(shown.replay)}")


def _seat(seat: str, config: ArenaConfig, scenario: str) -> int:
    """Return the number of the person's seat; seats of prey come after the seats of hunters."""
    names = (*config.hunter_names, *config.prey_names)
    name = f"hunter_{seat}" if seat.isdecimal() else seat
    if name not in names:
        raise ConfigError(f"--seat must be a seat of {scenario}, got {seat}; {suggest(seat, names)}")
    return names.index(name)
