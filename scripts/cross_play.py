"""Play learned agents against each other and against scripts, and write the tables into docs/reference/card.md.

The agents are those of agents/ladder (scripts/ladder.py). In each scenario the last one of each training seed plays; in
`standard` all ages of one seed play too. The seed of the matches is fixed, so that the tables can be made again.
"""

import argparse
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from bench.machine import machine
from card import CROSS_PLAY, PAGE

from catch_arena.cli.tables import interval
from catch_arena.config import ArenaConfig
from catch_arena.files import write_whole
from catch_arena.scenarios import scenario
from catch_arena.tournament.agent_spec import LADDER, ladder_names
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.statistics.intervals import Estimate, ratios, shares
from catch_arena.tournament.statistics.outcomes import Floats
from catch_arena.training.player_batch import play_matches

SEED: Final = 51
"""Seed of all matches; it is public."""
CHASES: Final = {"tag": "intercept", "pack": "together"}
"""Scenarios in which hunters and prey have learned, and the script that hunts there."""
WINS: Final = {"partners": ("seat", ["together"]), "standard": ("seat", ["intercept", "patrol", "triage"])}
"""Scenarios in which hunters alone have learned: the side, and the scripts that it meets."""
HEAD: Final = """{heading}
[Frozen learned agents](shipped_agents.md#frozen-learned-agents) play each other and scripts. A row's *worst* entry is
its result against the opponent that is hardest for it. Entries in bold are of one training run, whose agents
have learned together; the others have never met. Each entry has {matches} matches, and each figure its 95 % interval.

Measured by `scripts/cross_play.py --matches {matches}` on {machine}.
"""


class Rung(NamedTuple):
    """A frozen learned agent."""

    name: str
    scenario: str
    side: str
    seed: int
    age: int
    """Age in thousands of decisions."""

    @property
    def label(self) -> str:
        """Short description for a row or column."""
        return f"seed {self.seed}, {self.age:,}k"


def rungs(where: str, side: str) -> list[Rung]:
    """Return the agents of a side in a scenario, by seed and age."""
    parts = (name.removeprefix(LADDER).split("_") for name in ladder_names())
    found = (Rung(LADDER + "_".join(part), *part[:2], int(part[2]), int(part[3][:-1])) for part in parts)
    return sorted((one for one in found if one[1:3] == (where, side)), key=lambda one: one[3:])


def last(found: Sequence[Rung]) -> list[Rung]:
    """Return the agent of each seed that has learned the longest."""
    return list({one.seed: one for one in found}.values())


def chase(config: ArenaConfig, hunters: Sequence[str], prey: Sequence[str], matches: int) -> Floats:
    """Return the catches of all hunters together, by agent that hunts, agent that plays prey, and match."""
    shape = len(hunters), len(prey), matches
    hunter, runner, _ = np.indices(shape).reshape(3, -1, 1)
    seated = np.where(np.arange(config.hunters + config.prey) < config.hunters, hunter, runner)
    found = play_matches(config, {"hunter": hunters, "prey": prey}, seated, SEED)
    return found["times_caught"].sum(axis=1).reshape(shape)


def wins(
    config: ArenaConfig, players: Sequence[str], home: Sequence[Sequence[int]], other: Sequence[int], matches: int
) -> Floats:
    """Return the shares of wins of a party, by pairing and match; parties that share the first rank share the win.

    Args:
        config: the settings.
        players: the agents.
        home: of each pairing, the numbers of the players in the party's seats, which change by match.
        other: of each pairing, the number of the player in all other seats.
        matches: number of matches of each pairing.
    """
    parties = np.array(Parties.of(config).seats)
    match = np.arange(len(home) * matches)[:, None]
    own = parties[match[:, 0] % len(parties)]
    seated = np.repeat(np.array(other), matches)[:, None].repeat(config.hunters, axis=1)
    seated[match, own] = np.repeat(np.array(home), matches, axis=0)
    first = play_matches(config, {"hunter": players}, seated, SEED)["rank"][:, : config.hunters] == 1
    return (first[match, own].sum(axis=1) / first.sum(axis=1)).reshape(len(home), matches)


def climb(config: ArenaConfig, players: Sequence[str], matches: int) -> list[Floats]:
    """Play matches of different players, drawn at random.

    Returns:
        for each player, by match: the share of its opponents that caught fewer than it, a tie counting one half.
    """
    rng = np.random.default_rng(SEED)
    seated = np.array([rng.permutation(len(players))[: config.hunters] for _ in range(matches)])
    score = play_matches(config, {"hunter": players}, seated, SEED)["score"]
    difference = score[:, :, None] - score[:, None, :]
    beaten = ((difference > 0) + 0.5 * (difference == 0)).sum(axis=2) - 0.5  # without the tie with itself
    return [beaten[seated == number] / (config.hunters - 1) for number in range(len(players))]


def figures(values: Floats, unit: str) -> list[Estimate]:
    """Return the means of values (figures, matches), which are shares if the unit is "%"."""
    return (shares if unit == "%" else ratios)(values.T, np.ones_like(values.T))


def text(figure: Estimate, unit: str) -> str:
    """Return a figure with its interval."""
    form, scale = (".0f", 100) if unit == "%" else (".1f", 1)
    return f"{scale * figure.mean:{form}}{' %' * (unit == '%')} ({interval(figure, form, scale)})"


def table(
    corner: str,
    rows: Sequence[str],
    columns: Sequence[str],
    values: Floats,
    unit: str = "%",
    worst: Callable[..., Any] = min,
) -> Iterator[str]:
    """Yield the lines of a table with a result of each row against each column.

    Args:
        corner: heading of the rows.
        rows: the agents whose results these are, as `seed 1, 400k` or the name of a script.
        columns: their opponents or team-mates.
        values: the results, (rows, columns, matches).
        unit: "%" for shares.
        worst: the function that chooses the worst entry of a row.
    """
    yield f"| {corner} | {' | '.join(columns)} | mean | worst |"
    yield "|---" * (len(columns) + 3) + "|"
    for row, of in zip(rows, values, strict=True):
        *cells, mean = figures(np.concatenate((of, of.mean(axis=0, keepdims=True))), unit)
        texts = [text(cell, unit) for cell in cells]
        for place, column in enumerate(columns):
            if row.startswith("seed") and row.split(",")[0] == column.split(",")[0]:
                texts[place] = f"**{texts[place]}**"
        least = worst(cells, key=lambda cell: cell.mean)
        yield f"| {row} | {' | '.join(texts)} | {text(mean, unit)} | {text(least, unit)} |"
    yield ""


def of_chase(where: str, matches: int) -> Iterator[str]:
    """Yield the lines about a scenario in which hunters and prey have learned."""
    hunters, prey, script = last(rungs(where, "hunters")), last(rungs(where, "prey")), CHASES[where]
    names = [*(one.name for one in hunters), script], [*(one.name for one in prey), "flee"]
    labels = [*(one.label for one in hunters), f"`{script}`"], [*(one.label for one in prey), "`flee`"]
    values = chase(scenario(where), *names, matches)
    yield f"### Hunters and prey in `{where}`\n"
    yield "Catches in a match, by all hunters together. For prey, fewer are better.\n"
    yield from table("hunters, by prey", *labels, values, "catches")
    yield from table("prey, by hunters", *reversed(labels), values.swapaxes(0, 1), "catches", max)


def of_wins(where: str, matches: int) -> Iterator[str]:
    """Yield the lines about a scenario in which hunters alone have learned."""
    config, (side, scripts) = scenario(where), WINS[where]
    found = last(rungs(where, side))
    labels, players = [one.label for one in found], [*(one.name for one in found), *scripts]
    parties = Parties.of(config).seats
    size, learned, every = len(parties[0]), range(len(found)), range(len(players))
    values = wins(config, players, [(row,) * size for row in learned for _ in every], [*every] * len(found), matches)
    yield f"### {'A hunter' if size == 1 else 'A team'} in `{where}`\n"
    yield f"Share of wins. The opponent plays all other seats; {100 / len(parties):.0f} % is level.\n"
    columns = [*labels, *(f"`{name}`" for name in scripts)]
    yield from table("agent, by opponent", labels, columns, values.reshape(len(found), -1, matches))
    if size == 2:
        pairs = [(row, column) for row in learned for column in learned]
        values = wins(config, players, pairs, [len(found)] * len(pairs), matches)
        yield f"Share of wins with a team-mate. `{scripts[0]}` plays the other team.\n"
        yield from table("agent, by team-mate", labels, labels, values.reshape(len(found), -1, matches))


def of_ages(where: str, matches: int) -> Iterator[str]:
    """Yield the lines about agents of one training run at different ages."""
    found = rungs(where, WINS[where][0])
    seeds = [one.seed for one in found]
    ages = [one for one in found if one.seed == max(seeds, key=seeds.count)]
    played = climb(scenario(where), [one.name for one in ages], matches)
    shown = [figures(one[None], "%")[0] for one in played]
    yield f"### The ladder of seed {ages[0].seed} in `{where}`\n"
    yield f"{matches:,} matches, each of different ages of one training run, drawn at random. The share is that of"
    yield "the opponents that caught fewer than the agent; a tie counts one half. Ages are separated if their intervals"
    yield "do not overlap.\n"
    yield "| decisions | matches | share | separated from the age before |\n|---|---|---|---|"
    for place, (age, of, figure) in enumerate(zip(ages, played, shown, strict=True)):
        apart = "" if not place else "yes" if figure.low > shown[place - 1].high else "no"
        yield f"| {age.age:,}k | {len(of)} | {text(figure, '%')} | {apart} |"
    yield ""


def section(matches: int) -> str:
    """Return the part of the card about cross-play, with this number of matches for each entry of a table."""
    lines = [HEAD.format(heading=CROSS_PLAY, matches=matches, machine=machine())]
    for where in CHASES:
        lines += of_chase(where, matches)
    for where in WINS:
        lines += of_wins(where, matches)
    lines += of_ages("standard", 16 * matches)
    return "\n".join(lines)


def main() -> None:
    """Write the section."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--matches", type=int, default=128, help="number of matches for each entry of a table")
    tables = section(parser.parse_args().matches)
    card = PAGE.read_text(encoding="utf-8").partition(CROSS_PLAY)[0].rstrip()  # after minutes, it may be a new one
    write_whole(PAGE, f"{card}\n\n{tables}".encode())
    print(PAGE)


if __name__ == "__main__":
    main()
