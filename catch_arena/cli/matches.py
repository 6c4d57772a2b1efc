"""`catch-arena tournament` and `match`: matches of agents."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from catch_arena import interrupts
from catch_arena.cli.app import main
from catch_arena.cli.options import (
    Agents,
    Arena,
    ArenaSeed,
    Cores,
    Resume,
    Seed,
    Trust,
    enter_agents,
    print_missing_prey,
    print_seed,
)
from catch_arena.cli.outputs import REPLAY, Force, output_option, reserve_file, reserve_free_file
from catch_arena.cli.progress import match_counter, noting_kept_results, progress_bar
from catch_arena.cli.terminal import echo, own_console
from catch_arena.errors import ConfigError, OutputError
from catch_arena.files import prepare_folder
from catch_arena.policy import Side
from catch_arena.seeding import arena_seed
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import MAX_FORFEITS, MatchResult
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.secret import Secret
from catch_arena.tournament.store import STORE, Store, Tournament, terms_of

if TYPE_CHECKING:  # heavy
    from catch_arena.tournament.plans.schedule import Plan
    from catch_arena.tournament.statistics.standings import Standing


@main.command()
def tournament(
    agents: Agents,
    *,
    arena: Arena,
    form: Annotated[
        Literal["round-robin", "gauntlet"],
        typer.Option(
            "--format",
            metavar="FORMAT",
            help="round-robin plays every line-up of agents; gauntlet plays those with the first agent. If they need "
            "more matches than --max-matches, a sample is played in which pairs meet about equally often.",
        ),
    ] = "round-robin",
    rounds: Annotated[
        int | None, typer.Option(help="Number of rounds.", show_default="enough for ten blocks per agent")
    ] = None,
    until_separated: Annotated[
        float | None,
        typer.Option(
            metavar="P",
            help="Play rounds until the order of all agents is clear with this confidence, for example 0.95.",
        ),
    ] = None,
    max_matches: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="Maximum number of matches in a round; with --until-separated, in all rounds together.",
            show_default="20000; 10000 with --until-separated",
        ),
    ] = None,
    seed: Seed = None,
    cores: Cores,
    trust: Trust,
    max_forfeits: Annotated[
        int,
        typer.Option(
            metavar="N",
            min=0,
            help="Exclude an agent that forfeits N matches in a row: it forfeits the rest without being started. "
            "0 excludes no agent.",
        ),
    ] = MAX_FORFEITS,
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder for the matches, the standings and the agents' logs.")
    ] = Path("out/tournament"),
    resume: Resume = False,
    force: Annotated[
        bool,
        typer.Option("--force", help="Write into DIR even if it has files of another origin."),
    ] = False,
    record: Annotated[bool, typer.Option("--record", help="Also save a replay of each match, in DIR/replays.")] = False,
    watch: Annotated[bool, typer.Option("--watch", help="Serve a live report on 127.0.0.1, until Ctrl-C.")] = False,
) -> None:
    """Play a tournament: agents meet in all rotations of the seats, and are ranked.

    The same agents, options and seed give the same results with any --jobs and --executor.
    """
    from catch_arena.cli.tables import plan_table
    from catch_arena.report import write_report
    from catch_arena.tournament.execution.cost import measure_cost
    from catch_arena.tournament.execution.executors import Worker
    from catch_arena.tournament.execution.runner import LOGS, REPLAYS, play_plan
    from catch_arena.tournament.export import write_standings
    from catch_arena.tournament.plans.schedule import UntilSeparated, require_enough
    from catch_arena.tournament.statistics.standings import standings_of_sides

    if until_separated is not None and rounds is not None:
        raise ConfigError(f"--rounds must be left out with --until-separated, got {rounds}: --max-matches ends it")
    config, quotas, jobs = arena.config(), trust.quotas(), cores.number
    parties = Parties.of(config)
    given = None if seed is None else Secret.parse(seed)
    entrants = enter_agents(agents, quotas)
    require_enough(len(entrants), config, arena.scenario, tournament=True)
    begun = Store.tournament_in(out) if resume else None
    secret = given or (begun.secret if begun else Secret.of(None))
    plan = _plan(form, entrants, parties, rounds, until_separated, max_matches, secret)
    size = f"at most {plan.size}" if isinstance(plan, UntilSeparated) else f"{plan.size}"
    worker = Worker(config, entrants, record, quotas)
    about = Tournament(config, entrants, plan.parameters, secret.text, terms_of(quotas, max_forfeits, recorded=record))
    new = not (out / STORE).exists()
    if new:
        if not force and out.is_dir() and any(out.glob("[!.]*")):
            raise OutputError(f"{out}: has other files; use --force to write into it, or choose another folder")
        cost = measure_cost(worker, plan)
        own_console(err=True).print(plan_table(plan, len(entrants), cost, jobs))
    prepare_folder(out / REPLAYS if record else out)

    with Store.begin(about, out, resume=resume) as store, _watched(out) if watch else nullcontext():
        echo(f"{arena.scenario}: {len(entrants)} agents, {size} matches, {len(parties)} in each")
        print_missing_prey(entrants, config)
        with noting_kept_results(f"what was played is kept in {out}; the same command with --resume goes on"):
            with cores.of(worker) as ready, progress_bar("playing", plan.size) as show:
                count_matches = match_counter(plan.size, show)
                play_plan(store, plan, ready, max_forfeits=max_forfeits, on_results=count_matches)
            tables = standings_of_sides(entrants, list(store.played()), parties)
            played = store.count_played()
            write_standings(out, about, played, tables)
        _print_standings(tables, entrants)
        if isinstance(plan, UntilSeparated) and plan.last is not None:
            echo(f"after {played} matches, {plan.last}")
        if (out / LOGS).exists():
            echo(f"what agents printed, and how they failed: {out / LOGS}")
        print_seed(secret)
        echo(f"results: {out}")
        echo(f"report: {write_report(out)}")


def _plan(
    form: str,
    entrants: Sequence[Entrant],
    parties: Parties,
    rounds: int | None,
    until_separated: float | None,
    max_matches: int | None,
    secret: Secret,
) -> "Plan":
    """Return the plan that the options describe.

    Raises:
        ConfigError: if even a sample has more matches in a round than --max-matches allows.
    """
    from catch_arena.tournament.plans.schedule import BUDGET, MOST_IN_A_ROUND, UntilSeparated, plan_of

    most = max_matches or (MOST_IN_A_ROUND if until_separated is None else BUDGET)

    def plan_with(number: int | None) -> "Plan":
        return plan_of(form, len(entrants), parties, number, secret, most)

    if until_separated is not None:
        return UntilSeparated(entrants, until_separated, most, plan_with, parties)
    plan = plan_with(rounds)
    if max_matches is not None and (a_round := plan.size // int(plan.parameters["rounds"])) > max_matches:
        raise ConfigError(f"--max-matches must be at least {a_round}, the matches of one round, got {max_matches}")
    return plan


def _print_standings(tables: "dict[Side, list[Standing]]", entrants: tuple[Entrant, ...]) -> None:
    """Print the standings, and the number of matches from which each excluded entrant was left out."""
    from catch_arena.cli.tables import standings_table

    for side, table in tables.items():
        own_console().print(standings_table(table, side, titled=len(tables) > 1))
    for entrant in entrants:
        lines = [one for side, table in tables.items() for one in table if one.name == entrant.on(side).name]
        if without := sum(one.forfeits.get("FORFEIT_OUT", 0) for one in lines):
            matches = sum(one.matches for one in lines)
            echo(f"{entrant.name} was excluded: {without} of its {matches} matches were played without it")


@contextmanager
def _watched(folder: Path) -> Iterator[None]:
    """Serve the report of a running tournament; after its end, serve the report until Ctrl-C."""
    from catch_arena.report.watch import LiveReport, serve

    with serve(LiveReport(folder)) as address:
        echo(f"watch: {address}")
        yield
        interrupts.wait(lambda: echo(f"the report is served at {address} until Ctrl-C"))


@main.command()
def match(
    agents: Agents,
    *,
    arena: Arena,
    seed: ArenaSeed = None,
    trust: Trust,
    output: Annotated[
        Path | None, output_option("Replay file to write.", "match.replay, or match-2.replay ...")
    ] = None,
    force: Force = False,
) -> None:
    """Play and record one match; the agents take the seats in the given order.

    Give one agent for each hunter, or for each team if there are teams, and then one for each prey.
    """
    from catch_arena.tournament.isolation.sandbox import sandbox_for
    from catch_arena.tournament.match_loop import in_parties, play_entrants
    from catch_arena.tournament.plans.schedule import require_enough

    config, quotas = arena.config(), trust.quotas()
    parties = Parties.of(config)
    reserve_file(output, REPLAY, force=force)
    target = output or reserve_free_file("match.replay", force=force)
    entrants = enter_agents(agents, quotas)
    require_enough(len(entrants), config, arena.scenario)
    if len(entrants) > len(parties):
        raise ConfigError(
            f"number of agents must be {len(parties)}, to {parties.task} of {arena.scenario}, got {len(entrants)}"
        )
    drawn = arena_seed(seed)
    steps = count()
    with sandbox_for(quotas) as sandbox, progress_bar("playing") as show:
        result = play_entrants(
            config,
            drawn,
            entrants,
            sandbox,
            title=arena.scenario,
            record=target,
            watch=lambda _: show(min(next(steps), config.max_steps), config.max_steps),
        )
    names = [entrant.name for entrant in in_parties(config, entrants)]
    print_result(parties, result, names)
    echo(f"seed: {drawn}")
    echo(f"replay: {target}")


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
