"""`catch-arena compare`: which of two agents is stronger."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from catch_arena.cli.app import (
    MAX_FORFEITS,
    Jobs,
    LimitOption,
    MaxForfeits,
    Scenario,
    Seed,
    SettingOption,
    Trusted,
    arena,
    enter_agents,
    jobs_or_all,
    limits_or_trust,
    main,
    say_who_needs_prey,
    secret_of,
    seed_told,
)
from catch_arena.cli.terminal import own_console, plain, say
from catch_arena.errors import ConfigError

if TYPE_CHECKING:
    from catch_arena.tournament.entrants import Entrant
    from catch_arena.tournament.statistics.intervals import Estimate

_EXIT_CODES = {"H1": 0, "H0": 1, None: 3}


@main.command()
def compare(
    agents: Annotated[list[str], typer.Argument(metavar="A B", help="The new agent, and the one that it should beat.")],
    *,
    against: Annotated[
        list[str] | None,
        typer.Option(metavar="AGENT", help="One more agent of the field that both play against; may be repeated."),
    ] = None,
    scenario: Scenario = "duel",
    elo0: Annotated[float, typer.Option(help="H0: A is stronger by this many points.")] = 0.0,
    elo1: Annotated[float, typer.Option(help="H1: A is stronger by this many points.")] = 20.0,
    share0: Annotated[float | None, typer.Option(help="H0 as A's share instead, 0.5 being equal.")] = None,
    share1: Annotated[float | None, typer.Option(help="H1 as A's share instead.")] = None,
    alpha: Annotated[float, typer.Option(help="How often H1 may be accepted wrongly.")] = 0.05,
    beta: Annotated[float, typer.Option(help="How often H0 may be accepted wrongly.")] = 0.05,
    max_blocks: Annotated[int, typer.Option(help="Give up after this many blocks.")] = 2000,
    seed: Seed = None,
    jobs: Jobs = None,
    trusted: Trusted = False,
    limits: LimitOption = None,
    max_forfeits: MaxForfeits = MAX_FORFEITS,
    settings: SettingOption = None,
) -> None:
    """Play A and B until a sequential test knows which is stronger.

    Exits with 0 if A is stronger (H1), 1 if it is not (H0), 3 if the blocks ran out.
    """
    from catch_arena.cli.progress import progress_lines
    from catch_arena.tournament.comparison import compare as play_and_test
    from catch_arena.tournament.parties import Parties
    from catch_arena.tournament.statistics.sprt import Sprt, elo_of_share, share_of_elo

    config, secret = arena(scenario, settings), secret_of(seed)
    if len(agents) != 2:
        raise ConfigError(f"agents must be two, A and B, got {len(agents)}; the field is named by --against")
    if (share0 is None) != (share1 is None):
        raise ConfigError("--share0 and --share1 must be given together")
    test = Sprt(
        share_of_elo(elo0) if share0 is None else share0, share_of_elo(elo1) if share1 is None else share1, alpha, beta
    )
    everybody = [*agents, *(against or ())]
    allowed = limits_or_trust(limits, trusted=trusted)
    entrants = enter_agents(everybody, allowed)
    if config.prey:
        say_who_needs_prey(entrants)
    first, second = entrants[:2]
    low, high = test.bounds
    console = own_console(err=True)
    with console.status(plain(f"{first.name} against {second.name}: the first blocks")) as status:

        def show(blocks: int, test: Sprt) -> None:
            ratio = test.log_likelihood_ratio
            status.update(f"{blocks} of at most {max_blocks} blocks; H0 {low:.2f} < {ratio:+.2f} < {high:.2f} H1")

        found = play_and_test(
            config,
            entrants,
            test,
            max_blocks=max_blocks,
            seed=secret,
            jobs=jobs_or_all(jobs),
            limits=allowed,
            max_forfeits=max_forfeits,
            progress=show,
            on_played=None if console.is_terminal else progress_lines("playing", console),
        )
    for name, codes in found.forfeits.items():
        say(f"{name} forfeited: {', '.join(f'{count} times {code}' for code, count in codes.items())}")
    say(f"{found.matches} matches in {found.blocks} blocks, {_opponents(Parties.of(config).group, entrants)}")
    say(f"share of {first.name}: {_in_words(found.share)}")
    say(
        f"log-likelihood ratio {found.log_likelihood_ratio:+.2f}, H0 at {low:.2f} and H1 at {high:.2f}: "
        f"H0 is {elo_of_share(test.share0):+.0f} points, H1 {elo_of_share(test.share1):+.0f}"
    )
    verdicts = {
        "H1": f"{first.name} is stronger than {second.name} (H1)",
        "H0": f"{first.name} is not stronger than {second.name} (H0)",
        None: f"undecided after {found.blocks} blocks",
    }
    say(seed_told(secret))
    say(f"verdict: {verdicts[found.decision]}")
    raise typer.Exit(_EXIT_CODES[found.decision])


def _in_words(share: "Estimate") -> str:
    """A share, and as points; each with its interval, where it has one."""
    from catch_arena.tournament.statistics.intervals import FEWEST_BLOCKS
    from catch_arena.tournament.statistics.sprt import elo_of_share

    if math.isnan(share.margin):
        points = elo_of_share(share.mean)
        return f"{100 * share.mean:.1f} %, {points:+.0f} points; an interval needs {FEWEST_BLOCKS} blocks"
    mean, low, high = (f"{elo_of_share(one):+.0f}" for one in (share.mean, share.low, share.high))
    return (
        f"{100 * share.mean:.1f} % ({100 * share.low:.1f} to {100 * share.high:.1f}), {mean} points ({low} to {high})"
    )


def _opponents(group: int, entrants: Sequence["Entrant"]) -> str:
    field = ", ".join(entrant.name for entrant in entrants[2:])
    if not field:
        return "against each other"
    return f"{'in turn' if group == len(entrants) - 1 else 'together'} against {field}"
