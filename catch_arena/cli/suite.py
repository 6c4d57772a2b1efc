"""`catch-arena suite`: measurement of an agent under a fixed protocol, so that papers can compare their numbers."""

from itertools import chain
from json import dumps
from pathlib import Path
from typing import Annotated, Any

import typer

from catch_arena.cli.app import main
from catch_arena.cli.options import Agents, Processes, Resume, Trust, enter_agents
from catch_arena.cli.outputs import Force, Json, reserve_file
from catch_arena.cli.terminal import echo, noting_kept_results, progress_bar
from catch_arena.cli.tournaments import require_own_folder
from catch_arena.files import write_whole
from catch_arena.text import counted
from catch_arena.tournament.isolation.sandbox import sandbox_for


@main.command()
def suite(
    agents: Agents,
    *,
    name: Annotated[
        str | None,
        typer.Option("--suite", metavar="NAME", help="Suite to play.", show_default="catch_arena_suite_v1"),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Play few matches for a first look; do not publish the figures.")
    ] = False,
    runs: Annotated[
        bool,
        typer.Option("--runs", help="Treat the agents as training runs of one method, with one training seed each."),
    ] = False,
    json: Json = None,
    force: Force = False,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder for the matches, with a folder for each agent and scenario.",
            show_default="out/suite, out/NAME with --suite; with --quick also -quick",
        ),
    ] = None,
    resume: Resume = False,
    processes: Processes,
    trust: Trust,
) -> None:
    """Measure agents in training and held-out scenarios.

    Opponents, matches, seeds and statistics are fixed, so that papers can compare their numbers
    (`catch-arena docs suite`).
    """
    from catch_arena.cli.tables import PARTS, print_measures, with_interval
    from catch_arena.suite.aggregates import FEWEST_RUNS
    from catch_arena.suite.contents import QUICK_BLOCKS, suite_called
    from catch_arena.suite.measures import facts_of, measure, over_training_runs, references
    from catch_arena.suite.tournaments import cannot_play, play, tournaments
    from catch_arena.tournament.statistics.intervals import FEWEST_BLOCKS

    chosen = suite_called(name)
    out = out or Path("out", (name or "suite") + "-quick" * quick)
    quotas = trust.quotas()
    reserve_file(json, ".json", force=force)
    entered = enter_agents(agents, quotas)
    blocks = QUICK_BLOCKS if quick else chosen.blocks
    setups = [tournaments(chosen, agent, out, blocks, quotas) for agent in entered]
    for one in chain(*setups):
        require_own_folder(one.folder, force=force)
        with one.begin(resume=resume):
            pass  # errors come before the first match
    with sandbox_for(quotas) as sandbox:
        for agent in (one for one in entered if one.fault is None):
            for scenario, fault in cannot_play(chosen, agent, sandbox):
                echo(f"{agent.name} cannot play {scenario}, and forfeits there: {fault}", err=True)
    total = sum(one.plan.size for one in chain(*setups))
    echo(f"{chosen.name} (digest {chosen.digest}): {len(chosen.scenarios)} scenarios, {blocks} blocks of each")
    if quick:
        echo(
            f"--quick: a first look, NOT the protocol, which has {chosen.blocks} blocks; "
            f"intervals (? below) need {FEWEST_BLOCKS} blocks"
        )
    playing = f"{processes.workers} processes" if processes.workers > 1 else "one process"
    echo(f"{counted(len(agents), 'agent')}, {total} matches, with {playing}")

    with noting_kept_results(f"what was played is kept in {out}; the same command with --resume goes on"):
        for agent, in_scenarios in zip(entered, setups, strict=True):
            with progress_bar(agent.name) as show:
                play(in_scenarios, processes.workers, show)
    known = references(chosen)
    measured = [measure(chosen, in_scenarios) for in_scenarios in setups]
    for measures in measured:
        print_measures(measures, known)
    method = {}
    if runs:
        method = {part: over_training_runs(measured, held_out=held_out) for part, held_out in PARTS.items()}
        echo(f"training method, over {len(measured)} runs:")
        for part, estimate in method.items():
            echo(f"interquartile mean, {part}: {with_interval(estimate, '.3f')}")
        if len(measured) < FEWEST_RUNS:
            echo(f"an interval needs {FEWEST_RUNS} training runs")
    if json is not None:
        figures: dict[str, Any] = {"agents": [facts_of(chosen, measures, known) for measures in measured]}
        if runs:
            figures["method_iqm"] = {part.replace(" ", "_"): one.to_dict() for part, one in method.items()}
        write_whole(json, f"{dumps(figures, indent=1)}\n".encode())
        echo(f"figures: {json}")
    echo(f"matches: {out}")
