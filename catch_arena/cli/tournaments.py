"""`catch-arena tournament` and `compare`, and `report` and `export`, which show and write a tournament's matches."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer

from catch_arena import interrupts
from catch_arena.cli.app import EXIT_NO, main
from catch_arena.cli.options import Agents, Arena, Cores, Processes, Resume, Seed, Trust, enter_agents, require_enough
from catch_arena.cli.outputs import PAGE, Force, output_option, reserve_file
from catch_arena.cli.terminal import echo, noting_kept_results, own_console, progress_bar
from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError, OutputError
from catch_arena.tournament.entrants import SHIPPED_PREY, Entrant
from catch_arena.tournament.match import MAX_FORFEITS
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.secret import Secret
from catch_arena.tournament.statistics.sprt import Sprt, share_of_elo
from catch_arena.tournament.store import STORE, Store

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a tournament, finished or running.")]
Watch = Annotated[
    bool,
    typer.Option(
        "--watch", help="Serve the report on 127.0.0.1, and update it while the tournament runs, until Ctrl-C."
    ),
]
_DUEL = Arena("duel")
_MOST_MB = 1000
_MOST_TO_SEPARATE = 100_000
_EXIT_UNDECIDED = 3


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
        typer.Option(metavar="P", help="Play until the order of all is clear with this confidence, for example 0.95."),
    ] = None,
    max_matches: Annotated[
        int | None,
        typer.Option(
            metavar="N",
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
    force: Force = False,
    record: Annotated[bool, typer.Option("--record", help="Also save a replay of each match, in DIR/replays.")] = False,
    watch: Watch = False,
) -> None:
    """Play a tournament: agents meet in all rotations of the seats, and are ranked.

    The same agents, options and seed give the same results with any --jobs and --executor.
    """
    from catch_arena.cli.tables import plan_table, print_standings
    from catch_arena.report import write_report
    from catch_arena.tournament.execution.cost import measure_cost
    from catch_arena.tournament.execution.executors import Worker
    from catch_arena.tournament.execution.runner import LOGS, Setup
    from catch_arena.tournament.plans.schedule import BUDGET, UntilSeparated, plan_of

    if until_separated is not None and rounds is not None:
        raise ConfigError(f"--rounds must be left out with --until-separated, got {rounds}: --max-matches ends it")
    budget = max_matches or BUDGET
    if until_separated is not None and budget > _MOST_TO_SEPARATE:
        raise ConfigError(f"--max-matches must be at most {_MOST_TO_SEPARATE} with --until-separated, got {budget}")
    config, quotas = arena.config(), trust.quotas()
    parties = Parties.of(config)
    given = None if seed is None else Secret.parse(seed)
    entrants = enter_agents(agents, quotas)
    require_enough(len(entrants), parties, arena.scenario, tournament=True)
    begun = Store.tournament_in(out) if resume else None
    secret = given or (begun.secret if begun else Secret.of(None))
    most = max_matches if until_separated is None else budget
    plan_with = partial(plan_of, form, len(entrants), parties, seed=secret, most=most)
    in_a_round = plan_with(1).size
    if most is not None and most < in_a_round:
        raise ConfigError(f"--max-matches must be at least {in_a_round}, so that all play equally often, got {most}")
    if until_separated is None:
        plan, bound = plan_with(rounds), ""
    else:
        plan, bound = UntilSeparated(plan_with(budget // in_a_round), entrants, parties, until_separated), "at most "
    setup = Setup(out, plan, Worker(config, entrants, record, quotas), secret, max_forfeits)
    require_own_folder(out, force=force)
    if not (out / STORE).exists():
        with own_console(err=True).status("trying some matches"):
            cost = measure_cost(setup.worker, plan)
        own_console(err=True).print(plan_table(plan, len(entrants), cost, cores.workers))

    with setup.begin(resume=resume) as store, _watched(out) if watch else nullcontext():
        echo(f"{arena.scenario}: {len(entrants)} agents, {bound}{plan.size} matches, {len(parties)} in each")
        _print_missing_prey(entrants, config)
        with (
            noting_kept_results(f"what was played is kept in {out}; the same command with --resume goes on"),
            cores.of(setup.worker) as ready,
            progress_bar("playing", plan.size) as show,
        ):
            tables = setup.play(store, ready, show)
        print_standings(tables, entrants)
        if isinstance(plan, UntilSeparated) and plan.last is not None:
            echo(f"after {store.count_played()} matches, {plan.last}")
        if (out / LOGS).exists():
            echo(f"what agents printed, and how they failed: {out / LOGS}")
        _print_seed(secret)
        echo(f"results: {out}")
        echo(f"report: {write_report(out)}")


def require_own_folder(folder: Path, *, force: bool) -> None:
    """Check that a folder is missing, empty or that of a tournament, if `force` is False."""
    if not force and not (folder / STORE).exists() and folder.is_dir() and any(folder.glob("[!.]*")):
        raise OutputError(f"{folder}: has other files; use --force to write into it, or choose another folder")


def _print_missing_prey(entrants: Sequence[Entrant], config: ArenaConfig) -> None:
    """Print the entrants without their own prey in an arena with prey, and the agent that plays prey for them."""
    if config.prey and (without := [entrant.name for entrant in entrants if entrant.needs_prey]):
        echo(f"{SHIPPED_PREY} plays the prey of agents without a class Prey: {', '.join(without)}")


def _print_seed(secret: Secret) -> None:
    """Print the seed, with which others can repeat all random draws."""
    warning = "" if secret.number is None else f" (from {secret.number}, which agents can guess)"
    echo(f"seed: {secret.digits}{warning}")


@contextmanager
def _watched(folder: Path) -> Iterator[None]:
    """Serve the report of a running tournament; after its end, serve the report until Ctrl-C."""
    from catch_arena.report.watch import LiveReport, serve

    with serve(LiveReport(folder)) as address:
        echo(f"watch: {address}")
        yield
        interrupts.wait(lambda: echo(f"the report is served at {address} until Ctrl-C"))


@main.command()
def compare(
    agents: Annotated[
        tuple[str, str], typer.Argument(metavar="A B", help="The new agent, and the agent that it should beat.")
    ],
    *,
    against: Annotated[
        list[str] | None,
        typer.Option(metavar="AGENT", help="Opponent of both A and B; may be repeated."),
    ] = None,
    arena: Arena = _DUEL,
    elo1: Annotated[
        float, typer.Option(help="H1: A is stronger by this number of rating points; H0 is that both are equal.")
    ] = 20.0,
    max_blocks: Annotated[int, typer.Option(help="Stop undecided after this number of blocks.")] = 2000,
    seed: Seed = None,
    processes: Processes,
    trust: Trust,
) -> None:
    """Play A and B until a sequential test decides which is stronger.

    The exit code is 0 if A is stronger (H1), 1 if it is not (H0), and 3 if the test is still undecided.
    """
    from catch_arena.cli.tables import share_text
    from catch_arena.tournament.comparison import compare as play_and_test

    config, quotas = arena.config(), trust.quotas()
    secret = Secret.of(None) if seed is None else Secret.parse(seed)
    if not elo1 > 0.0:
        raise ConfigError(f"--elo1 must be above 0, got {elo1:g}")
    if max_blocks < 1:
        raise ConfigError(f"--max-blocks must be at least 1, got {max_blocks}")
    test = Sprt(share_of_elo(0.0), share_of_elo(elo1))
    entrants = enter_agents([*agents, *(against or ())], quotas)
    _print_missing_prey(entrants, config)
    first, second, *_ = (entrant.name for entrant in entrants)
    low, high = test.bounds
    with progress_bar("playing") as show:

        def show_test(matches: int, most: int) -> None:
            show(matches, most, f"H0 {low:.2f} < {test.log_likelihood_ratio:+.2f} < {high:.2f} H1")

        found = play_and_test(
            config,
            entrants,
            test,
            max_blocks=max_blocks,
            seed=secret,
            jobs=processes.workers,
            quotas=quotas,
            progress=show_test,
        )
    for name, codes in found.forfeits.items():
        echo(f"{name} forfeited: {', '.join(f'{count} times {code}' for code, count in codes.items())}")
    echo(f"{found.matches} matches in {found.blocks} blocks")
    echo(f"share of {first}: {share_text(found.share)}")
    echo(
        f"log-likelihood ratio {found.log_likelihood_ratio:+.2f}, H0 at {low:.2f} and H1 at {high:.2f}: "
        f"H0 is +0 points, H1 {elo1:+.0f}"
    )
    verdict, code = {
        "H1": (f"{first} is stronger than {second} (H1)", 0),
        "H0": (f"{first} is not stronger than {second} (H0)", EXIT_NO),
        None: (f"undecided after {found.blocks} blocks", _EXIT_UNDECIDED),
    }[found.decision]
    _print_seed(secret)
    echo(f"verdict: {verdict}")
    raise typer.Exit(code)


@main.command()
def report(
    folder: Folder,
    *,
    output: Annotated[Path | None, output_option("HTML file to write.", "DIR/report.html")] = None,
    force: Force = False,
    budget: Annotated[
        float | None, typer.Option(metavar="MB", help="Maximum size of the replays in the page.", show_default="1")
    ] = None,
    match: Annotated[
        list[str] | None, typer.Option(metavar="ID", help="A recorded match to include in the page; may be repeated.")
    ] = None,
    watch: Watch = False,
) -> None:
    """Write a report: one HTML file with the standings, charts, and replays to watch; --watch serves it instead."""
    if budget is not None and not 0 <= budget <= _MOST_MB:  # NaN is refused too
        raise ConfigError(f"--budget must be from 0 to {_MOST_MB} MB, got {budget:g}")
    if watch:
        if budget is not None or match or output is not None:
            raise ConfigError("--budget, --match and --output must be left out with --watch, which shows every replay")
        from catch_arena.report.watch import LiveReport, serve

        live = LiveReport(folder)
        live.state()  # raises errors here, before a browser opens the page
        with serve(live) as address:
            interrupts.wait(lambda: echo(f"report: {address} (Ctrl-C ends)"))
        return
    from catch_arena.report import BUDGET, write_report

    reserve_file(output, PAGE, force=force)
    size = BUDGET if budget is None else round(1e6 * budget)
    echo(f"report: {write_report(folder, budget=size, matches=match or (), output=output)}")


@main.command()
def export(
    folder: Folder,
    *,
    output: Annotated[
        Path,
        output_option(
            "File to write: .jsonl with a line for each match, .csv or .parquet with a row for each seat of each match."
        ),
    ],
    force: Force = False,
    timing: Annotated[
        bool, typer.Option("--timing/--no-timing", help="Include the time per move, which differs between runs.")
    ] = True,
) -> None:
    """Write the matches of a tournament to a file, sorted by match."""
    from catch_arena.tournament.export import export as write

    with Store.read(folder) as store:
        reserve_file(output, ".jsonl", ".csv", ".parquet", force=force)
        write(store, output, timing=timing)
        echo(f"{store.count_played()} of {store.count_planned()} matches: {output}")
