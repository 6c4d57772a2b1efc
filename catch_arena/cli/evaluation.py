"""`catch-arena compare`: test for the stronger one of two agents."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from catch_arena.cli.app import main
from catch_arena.cli.options import (
    Arena,
    Jobs,
    Scenario,
    Seed,
    Trust,
    enter_agents,
    print_missing_prey,
    print_seed,
)
from catch_arena.cli.progress import progress_bar
from catch_arena.cli.terminal import echo
from catch_arena.errors import ConfigError
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.secret import Secret

if TYPE_CHECKING:
    from catch_arena.tournament.statistics.intervals import Estimate

_EXIT_CODES = {"H1": 0, "H0": 1, None: 3}


@dataclass(frozen=True)
class Duel(Arena):
    """Options for the arena of a comparison."""

    scenario: Scenario = "duel"


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
    arena: Duel,
    elo0: Annotated[float, typer.Option(help="H0: A is stronger by this number of rating points.")] = 0.0,
    elo1: Annotated[float, typer.Option(help="H1: A is stronger by this number of rating points.")] = 20.0,
    max_blocks: Annotated[int, typer.Option(help="Stop undecided after this number of blocks.")] = 2000,
    seed: Seed = None,
    jobs: Jobs = None,
    trust: Trust,
) -> None:
    """Play A and B until a sequential test decides which is stronger.

    The exit code is 0 if A is stronger (H1), 1 if it is not (H0), and 3 if the test is still undecided.
    """
    from catch_arena.tournament.comparison import compare as play_and_test
    from catch_arena.tournament.execution.executors import usable_cores
    from catch_arena.tournament.statistics.sprt import Sprt, share_of_elo

    config, quotas = arena.config(), trust.quotas()
    secret = Secret.of(None) if seed is None else Secret.parse(seed)
    if not elo0 < elo1:
        raise ConfigError(f"--elo1 must be above --elo0, got {elo1:g} and {elo0:g}")
    test = Sprt(share_of_elo(elo0), share_of_elo(elo1))
    entrants = enter_agents([*agents, *(against or ())], quotas)
    print_missing_prey(entrants, config)
    first, second, *field = (entrant.name for entrant in entrants)
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
            jobs=jobs or usable_cores(),
            quotas=quotas,
            progress=show_test,
        )
    for name, codes in found.forfeits.items():
        echo(f"{name} forfeited: {', '.join(f'{count} times {code}' for code, count in codes.items())}")
    order = "in turn" if Parties.of(config).group == len(entrants) - 1 else "together"
    field_text = f"{order} against {', '.join(field)}" if field else "against each other"
    echo(f"{found.matches} matches in {found.blocks} blocks, {field_text}")
    echo(f"share of {first}: {_describe(found.share)}")
    echo(
        f"log-likelihood ratio {found.log_likelihood_ratio:+.2f}, H0 at {low:.2f} and H1 at {high:.2f}: "
        f"H0 is {elo0:+.0f} points, H1 {elo1:+.0f}"
    )
    verdicts = {
        "H1": f"{first} is stronger than {second} (H1)",
        "H0": f"{first} is not stronger than {second} (H0)",
        None: f"undecided after {found.blocks} blocks",
    }
    print_seed(secret)
    echo(f"verdict: {verdicts[found.decision]}")
    raise typer.Exit(_EXIT_CODES[found.decision])


def _describe(share: "Estimate") -> str:
    """Return a share in per cent and in points, each with its interval if there is one."""
    from catch_arena.tournament.statistics.intervals import FEWEST_BLOCKS
    from catch_arena.tournament.statistics.sprt import elo_of_share

    if math.isnan(share.margin):
        points = elo_of_share(share.mean)
        return f"{100 * share.mean:.1f} %, {points:+.0f} points; an interval needs {FEWEST_BLOCKS} blocks"
    mean, low, high = (f"{elo_of_share(one):+.0f}" for one in (share.mean, share.low, share.high))
    return (
        f"{100 * share.mean:.1f} % ({100 * share.low:.1f} to {100 * share.high:.1f}), {mean} points ({low} to {high})"
    )
