"""Measure what docs/ratings.md claims: `python scripts/measure_ratings.py`. Prints its tables, with the machine.

Tournaments of agents of known strength are simulated, without an arena: how often do the 95 % intervals hold the truth,
how often are equals told apart, how often is an order called clear that is not, how often does the sequential test err?
"""

import argparse
import math
import os
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from catch_arena.tournament.statistics.intervals import Estimate, ratios
from catch_arena.tournament.statistics.outcomes import Outcomes
from catch_arena.tournament.statistics.ratings import ELO, Ratings, fit, rate
from catch_arena.tournament.statistics.separation import groups, least_separated, level_of_look, next_look
from catch_arena.tournament.statistics.sprt import Sprt, share_of_elo

Array = NDArray[np.float64]

BLOCK_LUCK = 0.15
"""How much an agent's rate of catches differs from one block's targets to another's (standard deviation of its log)."""


@dataclass(frozen=True)
class Design:
    """A round robin: every subset of the agents that fills the seats, in every rotation."""

    agents: int
    seats: int
    rounds: int

    def seating(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """(matches, seats) who sits where, and (matches,) the blocks."""
        groups = [group for _ in range(self.rounds) for group in combinations(range(self.agents), self.seats)]
        seating = [np.roll(group, turn) for group in groups for turn in range(self.seats)]
        return np.array(seating), np.repeat(np.arange(len(groups)), self.seats)


@dataclass(frozen=True)
class World:
    """Agents of known strength, and the chance that their matches are made of."""

    name: str
    agents: int
    points: Array
    """(agents,): the true ratings, their mean 0."""
    play: Callable[[np.random.Generator, NDArray[np.int64], NDArray[np.int64]], NDArray[np.int64]]
    """The scores (matches, seats), given the seating and the blocks."""
    score: Array | None = None
    """(agents,): the true mean scores, where they do not depend on the opponents."""


def plackett_luce(agents: int, spread: float) -> World:
    """No ties: the order of log strength plus Gumbel noise, drawn for each match (Yellott 1977)."""
    strengths = np.linspace(-spread, spread, agents)

    def play(rng: np.random.Generator, seating: NDArray[np.int64], _: NDArray[np.int64]) -> NDArray[np.int64]:
        performance = strengths[seating] + rng.gumbel(size=seating.shape)
        return performance.argsort(axis=1).argsort(axis=1)

    return World(f"Plackett-Luce, {2 * spread * ELO:.0f} points from first to last", agents, strengths * ELO, play)


def davidson(agents: int, spread: float, tie: float) -> World:
    """Duels with ties, by Davidson's own probabilities."""
    strengths = np.linspace(-spread, spread, agents)

    def play(rng: np.random.Generator, seating: NDArray[np.int64], _: NDArray[np.int64]) -> NDArray[np.int64]:
        half = (strengths[seating[:, 0]] - strengths[seating[:, 1]]) / 2.0
        above, below = np.exp(half), np.exp(-half)
        draw = rng.random(len(seating)) * (above + below + tie)
        return np.stack((draw < above, (draw >= above) & (draw < above + below)), axis=1).astype(np.int64)

    return World(
        f"Davidson, {2 * spread * ELO:.0f} points, equals tie {tie / (2 + tie):.0%}", agents, strengths * ELO, play
    )


def catches(agents: int, low: float, high: float) -> World:
    """Scores as in the arena: counts, with ties, where a block's targets suit one agent more than another.

    The truth is the fit to the exact probabilities of each pair.
    """
    rates = np.geomspace(low, high, agents)

    def play(rng: np.random.Generator, seating: NDArray[np.int64], block: NDArray[np.int64]) -> NDArray[np.int64]:
        luck = np.exp(BLOCK_LUCK * rng.normal(size=(int(block.max()) + 1, agents)))
        return rng.poisson((rates * luck)[block[:, None], seating])

    nodes, weights = np.polynomial.hermite_e.hermegauss(40)
    counts = np.arange(int(6 * high) + 20)
    log_factorial = np.array([math.lgamma(count + 1) for count in counts])
    mean = rates[:, None] * np.exp(BLOCK_LUCK * nodes)
    chance = np.exp(counts * np.log(mean)[..., None] - mean[..., None] - log_factorial)
    chance = (weights[:, None] / weights.sum() * chance).sum(axis=1)
    below = np.cumsum(chance, axis=1) - chance
    wins, ties = chance @ below.T, chance @ chance.T
    for table in (wins, ties):
        np.fill_diagonal(table, 0.0)
    strengths, _, _ = fit(wins * 1e9, ties * 1e9)
    return World(
        f"catches, {low:g} to {high:g} a match",
        agents,
        np.asarray((strengths - strengths.mean()) * ELO),
        play,
        rates * math.exp(BLOCK_LUCK**2 / 2.0),
    )


def simulated(world: World, design: Design, rng: np.random.Generator) -> Outcomes:
    """One tournament."""
    seating, block = design.seating()
    scores = world.play(rng, seating, block)
    ranks = 1 + (scores[:, None, :] > scores[:, :, None]).sum(axis=2)
    return Outcomes(world.agents, block, seating, scores, ranks)


def held(estimates: list[Estimate], truth: Array) -> list[bool]:
    """Whether each interval holds the truth, where there is one: few blocks may give none."""
    return [
        estimate.low <= value <= estimate.high
        for estimate, value in zip(estimates, truth, strict=True)
        if not math.isnan(estimate.low)
    ]


def held_by_percentiles(ratings: Ratings, truth: Array, rng: np.random.Generator) -> list[bool]:
    """The same for the plain percentile bootstrap, which is not what we use."""
    blocks = len(ratings.influence)
    moved = rng.multinomial(blocks, np.full(blocks, 1 / blocks), 1000) @ ratings.influence
    low, high = ratings.points + np.quantile(moved, (0.025, 0.975), axis=0)
    return ((low <= truth) & (truth <= high)).tolist()


@dataclass
class Coverage:
    """How often intervals held the truth, in one design."""

    ratings: list[bool] = field(default_factory=list)
    margins: list[float] = field(default_factory=list)
    percentiles: list[bool] = field(default_factory=list)
    scores: list[bool] = field(default_factory=list)


def coverage(world: World, design: Design, tournaments: int, seed: int) -> Coverage:
    """Many tournaments."""
    rng, again = np.random.default_rng(seed), np.random.default_rng(seed + 1)
    found = Coverage()
    for _ in range(tournaments):
        outcomes = simulated(world, design, rng)
        ratings = rate(outcomes)
        estimates = ratings.estimates()
        found.ratings += held(estimates, world.points)
        found.margins += [estimate.margin for estimate in estimates]
        found.percentiles += held_by_percentiles(ratings, world.points, again)
        if world.score is not None:
            found.scores += held(ratios(outcomes.by_block(outcomes.scores), outcomes.by_block()), world.score)
    return found


def equals_told_apart(design: Design, tournaments: int, seed: int) -> float:
    """How often any two of equal agents have no group in common."""
    rng, world = np.random.default_rng(seed), catches(design.agents, 14.0, 14.0)
    apart = 0
    for _ in range(tournaments):
        ratings = rate(simulated(world, design, rng))
        apart += len({group for both in groups(ratings, ratings.points.argsort()[::-1].tolist()) for group in both}) > 1
    return apart / tournaments


def called_clear(world: World, seats: int, most_blocks: int, tournaments: int, seed: int) -> tuple[float, float]:
    """How often the order is called clear at some look, and how often it is so called and wrong."""
    rng = np.random.default_rng(seed)
    per_round = math.comb(world.agents, seats)
    clear = wrong = 0
    for _ in range(tournaments):
        whole = simulated(world, Design(world.agents, seats, most_blocks // per_round), rng)
        blocks = next_look(0)
        while blocks <= whole.blocks:
            now = whole.block < blocks
            outcomes = Outcomes(
                world.agents, *(part[now] for part in (whole.block, whole.seating, whole.scores, whole.ranks))
            )
            ratings = rate(outcomes)
            if least_separated(ratings)[2] < level_of_look(blocks, 0.95):
                clear += 1
                order = ratings.points.argsort()
                wrong += bool((np.diff(world.points[order]) <= 1e-6).any())
                break
            blocks = next_look(blocks)
    return clear / tournaments, wrong / tournaments


def sprt_answers(points: float, points1: float, matches: int, trials: int, seed: int) -> tuple[float, float, float]:
    """How often H0 and H1 (0 and `points1` points) are accepted, and after how many blocks on average.

    A block is so many duels of agents `points` apart; a tenth of them tie, and half of a block's luck is common to it.
    """
    rng = np.random.default_rng(seed)
    share, tie = share_of_elo(points), 0.1
    accepted = {"H0": 0, "H1": 0}
    blocks = 0
    for _ in range(trials):
        test = Sprt(share_of_elo(0.0), share_of_elo(points1))
        while (answer := test.decision) is None:
            common = rng.random()
            draws = np.where(rng.random(matches) < 0.5, common, rng.random(matches))
            won = (draws < share - tie / 2.0) + 0.5 * ((draws >= share - tie / 2.0) & (draws < share + tie / 2.0))
            test.add(float(won.mean()))
            blocks += 1
        accepted[answer] += 1
    return accepted["H0"] / trials, accepted["H1"] / trials, blocks / trials


def seconds_for_many() -> float:
    """CPU time of the fit and the intervals for 10,000 matches of 4 among 30 agents."""
    rng = np.random.default_rng(0)
    world = catches(30, 12.0, 22.0)
    groups = np.array([rng.choice(30, 4, replace=False) for _ in range(2500)])
    seating = np.stack([np.roll(groups, turn, axis=1) for turn in range(4)], axis=1).reshape(-1, 4)
    block = np.repeat(np.arange(2500), 4)
    scores = world.play(rng, seating, block)
    ranks = 1 + (scores[:, None, :] > scores[:, :, None]).sum(axis=2)
    begin = time.process_time()
    rate(Outcomes(30, block, seating, scores, ranks)).estimates()
    return time.process_time() - begin


COVERAGE = (
    (plackett_luce(6, 1.0), Design(6, 4, 1)),
    (plackett_luce(6, 1.0), Design(6, 4, 4)),
    (plackett_luce(8, 1.0), Design(8, 4, 1)),
    (plackett_luce(4, 1.0), Design(4, 4, 10)),
    (plackett_luce(6, 3.0), Design(6, 4, 4)),
    (plackett_luce(6, 1.0), Design(6, 2, 2)),
    (davidson(6, 1.0, 1.0), Design(6, 2, 4)),
    (catches(6, 10.0, 20.0), Design(6, 4, 1)),
    (catches(6, 10.0, 20.0), Design(6, 4, 4)),
    (catches(5, 2.0, 5.0), Design(5, 2, 6)),
    (catches(16, 8.0, 16.0), Design(16, 15, 2)),
    (catches(5, 10.0, 20.0), Design(5, 4, 1)),
)


def percent(held: list[bool]) -> str:
    """How many of them."""
    return f"{100 * np.mean(held):.1f} %" if held else ""


def main() -> None:
    """Measure, and print tables as docs/ratings.md has them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tournaments", type=int, default=500, help="to simulate for each line")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    many, seed = arguments.tournaments, arguments.seed
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, NumPy {np.__version__}\n")
    print("| simulated agents | seats | agents | blocks | ratings held | mean margin | by percentiles | scores held |")
    print("|---|---|---|---|---|---|---|---|")
    for world, design in COVERAGE:
        found = coverage(world, design, many, seed)
        blocks = design.rounds * math.comb(design.agents, design.seats)
        print(
            f"| {world.name} | {design.seats} | {design.agents} | {blocks} "
            f"| {percent(found.ratings)} | ± {np.mean(found.margins):.0f} | {percent(found.percentiles)} "
            f"| {percent(found.scores)} |",
            flush=True,
        )
    print("\nequals told apart (at most 5 %):")
    for design in (Design(6, 4, 1), Design(6, 4, 10), Design(10, 2, 4)):
        print(f"- {design.agents} agents, {design.seats} seats, {design.rounds} rounds: ", end="")
        print(f"{100 * equals_told_apart(design, many, seed):.1f} %", flush=True)
    print("\ncalled clear by --until-separated 0.95 within 500 blocks, and wrongly (at most 5 %):")
    for world, seats in ((catches(2, 14.0, 14.0), 2), (catches(4, 14.0, 14.0), 4), (catches(4, 10.0, 20.0), 4)):
        clear, wrong = called_clear(world, seats, 500, many, seed)
        print(f"- {world.agents} agents, {world.name}: {100 * clear:.1f} %, wrongly {100 * wrong:.1f} %", flush=True)
    print("\n| truth | H1 | matches a block | H0 accepted | H1 accepted | blocks |\n|---|---|---|---|---|---|")
    for points, points1, matches in (
        (0, 20, 2),
        (20, 20, 2),
        (0, 60, 2),
        (60, 60, 2),
        (0, 60, 4),
        (60, 60, 4),
        (200, 60, 2),
    ):
        first, second, blocks = sprt_answers(points, points1, matches, many, seed)
        print(
            f"| {points} | {points1} | {matches} | {100 * first:.1f} % | {100 * second:.1f} % | {blocks:.0f} |",
            flush=True,
        )
    print(f"\nfit and intervals of 10,000 matches of 4 among 30 agents: {seconds_for_many():.2f} s of CPU time")


if __name__ == "__main__":
    main()
