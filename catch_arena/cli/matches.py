"""`catch-arena match`, `play` and `watch`: single matches, recorded or in a window."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from catch_arena.cli.app import main
from catch_arena.cli.options import Agents, Arena, ArenaSeed, Trust, enter_agents, require_enough
from catch_arena.cli.outputs import REPLAY, Force, output_option, reserve_file, reserve_free_file
from catch_arena.cli.terminal import echo, progress_bar
from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError, suggest
from catch_arena.files import prepare_folder
from catch_arena.seeding import arena_seed
from catch_arena.tournament.isolation.sandbox import sandbox_for
from catch_arena.tournament.match import MatchResult
from catch_arena.tournament.parties import Parties

if TYPE_CHECKING:
    from catch_arena.replay import Replay

_RIVALS = ("nearest", "contested_by_time", "patrol")
_SIZE = (1280, 720)


@dataclass(frozen=True)
class OneMatch(Trust, Arena):
    """Options for a single match."""

    seed: ArenaSeed = None


@main.command()
def match(
    agents: Agents,
    *,
    options: OneMatch,
    output: Annotated[
        Path | None, output_option("Replay file to write.", "match.replay, or match-2.replay ...")
    ] = None,
    force: Force = False,
) -> None:
    """Play and record one match; the agents take the seats in the given order.

    Give one agent for each hunter, or for each team if there are teams, and then one for each prey.
    """
    from catch_arena.tournament.execution.block_queue import do_here
    from catch_arena.tournament.match_loop import play_entrants

    config, quotas = options.config(), options.quotas()
    parties = Parties.of(config)
    reserve_file(output, REPLAY, force=force)
    target = output or reserve_free_file("match.replay", force=force)
    entrants = enter_agents(agents, quotas)
    require_enough(len(entrants), parties, options.scenario)
    if len(entrants) > len(parties):
        raise ConfigError(
            f"number of agents must be {len(parties)}, to {parties.task} of {options.scenario}, got {len(entrants)}"
        )
    drawn = arena_seed(options.seed)
    steps = count()
    with sandbox_for(quotas) as sandbox, progress_bar("playing") as show:
        result = do_here(
            play_entrants,
            config,
            drawn,
            entrants,
            sandbox,
            title=options.scenario,
            record=target,
            watch=lambda _: show(min(next(steps), config.max_steps), config.max_steps),
        )
    names = [entrant.on(parties.side_of(party)).name for party, entrant in enumerate(entrants)]
    print_result(parties, result, names)
    echo(f"seed: {drawn}")
    echo(f"replay: {target}")


@main.command()
def play(
    agents: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="AGENT",
            help="Your rivals; if there are fewer rivals than seats, a rival plays several seats.",
            show_default=", ".join(_RIVALS),
        ),
    ] = None,
    *,
    seat: Annotated[str, typer.Option(help="Your seat: the number of a hunter, from 0, or prey_0, prey_1, ...")] = "0",
    options: OneMatch,
    record: Annotated[
        Path | None,
        typer.Option(help="File for the replay.", show_default="with Ctrl-S: match.replay, match-2.replay ..."),
    ] = None,
    force: Force = False,
) -> None:
    """Play against agents yourself, with turtlesim's keys or a gamepad.

    The window shows the keys. A target within reach is requested for you.

    If there are teams, each agent plays all hunters of one team; the first plays your team-mates. If there is prey,
    agents play it too: give them after the hunters' agents.
    """
    _show(agents or list(_RIVALS), options, seat, record, force=force)


@main.command()
def watch(agents: Agents, *, options: OneMatch) -> None:
    """Watch agents play, live; if there are fewer agents than seats, an agent plays several seats."""
    _show(agents, options, None, None, force=False)


def _show(agents: list[str], options: OneMatch, seat: str | None, record: Path | None, *, force: bool) -> None:
    """Play a match in a window: a person takes `seat`, if any, and the agents take the other seats in turn."""
    from catch_arena.live.session import show_match

    config, quotas = options.config(), options.quotas()
    person = None if seat is None else _seat(seat, config, options.scenario)
    parties = Parties.of(config)
    free = [party for party, seats in enumerate(parties.seats) if seats != (person,)]
    if len(agents) > len(free):
        seats = "free seat" if config.teams is None else "team and prey" if config.prey else "team"
        raise ConfigError(
            f"number of agents must be at most {len(free)}, one for each {seats} of {options.scenario}, "
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

    seed = arena_seed(options.seed)
    shown = show_match(config, seed, entrants, person, quotas, title=options.scenario, size=_SIZE, save=save)
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


def print_result(parties: Parties, result: MatchResult, names: Sequence[str]) -> None:
    """Print the result of a match by side: ranks, scores, forfeits, and the catches of a team's hunters.

    What the agents printed goes to stderr.
    """
    from catch_arena.explanation.seats import with_seat

    for name, log in zip(names, result.logs, strict=True):
        if log:
            echo(f"{name} printed:\n{log}", err=True)
    rows = []
    for party, (name, seats) in enumerate(zip(names, parties.seats, strict=True)):
        if parties.side_of(party) == "prey":
            shown = f"{name} (prey_{party - parties.hunting})"
        elif result.catches:
            shown = f"{name} ({' + '.join(f'hunter_{seat} {result.catches[seat]}' for seat in seats)})"
        else:
            shown = with_seat(name, seats[0])
        forfeit = result.forfeits[party]
        rows.append((result.ranks[party], result.scores[party], f"{shown}: {forfeit}" if forfeit else shown))
    for side in parties.sides:
        if side == "prey":
            echo("prey, by number of times caught:")
        print_ranking(rows[parties.on(side)])


def print_ranking(rows: Iterable[tuple[int, int, str]]) -> None:
    """Print the rank, the score and the name in each row, the best first."""
    for rank, score, name in sorted(rows, key=lambda row: row[0]):
        echo(f"{rank:>3}  {score:>3}  {name}")
