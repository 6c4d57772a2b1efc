"""Simulated tournaments of agents of known strength: how often intervals hold the truth, equals are told apart, an
order is wrongly called clear, and the sequential test errs. docs/explanation/ratings.md has the results of long runs.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from catch_arena.tournament.statistics.outcomes import Outcomes
from catch_arena.tournament.statistics.ratings import ELO, fit, rate
from catch_arena.tournament.statistics.separation import groups, least_separated, level_of_look, next_look
from catch_arena.tournament.statistics.sprt import Sprt, share_of_elo

Array = NDArray[np.float64]

BLOCK_LUCK = 0.15
"""Standard deviation of the log of an agent's rate of catches, from one block's targets to another's."""


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

    agents: int
    points: Array
    """(agents,): the true ratings, their mean 0."""
    play: Callable[[np.random.Generator, NDArray[np.int64], NDArray[np.int64]], NDArray[np.int64]]
    """The scores (matches, seats), given the seating and the blocks."""


def plackett_luce(agents: int, spread: float) -> World:
    """No ties: the order of log strength plus Gumbel noise, drawn for each match (Yellott 1977)."""
    strengths = np.linspace(-spread, spread, agents)

    def play(rng: np.random.Generator, seating: NDArray[np.int64], _: NDArray[np.int64]) -> NDArray[np.int64]:
        performance = strengths[seating] + rng.gumbel(size=seating.shape)
        return performance.argsort(axis=1).argsort(axis=1)

    return World(agents, strengths * ELO, play)


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
    return World(agents, np.asarray((strengths - strengths.mean()) * ELO), play)


def simulated(world: World, design: Design, rng: np.random.Generator) -> Outcomes:
    """Simulate one tournament."""
    seating, block = design.seating()
    scores = world.play(rng, seating, block)
    ranks = 1 + (scores[:, None, :] > scores[:, :, None]).sum(axis=2)
    return Outcomes(world.agents, block, seating, scores, ranks)


def coverage(world: World, design: Design, tournaments: int, seed: int) -> float:
    """Return the share of intervals of ratings that hold the truth; few blocks may give none."""
    rng = np.random.default_rng(seed)
    held = [
        estimate.low <= value <= estimate.high
        for _ in range(tournaments)
        for estimate, value in zip(rate(simulated(world, design, rng)).estimates(), world.points, strict=True)
        if not math.isnan(estimate.low)
    ]
    return sum(held) / len(held)


def equals_told_apart(design: Design, tournaments: int, seed: int) -> float:
    """Return the share of tournaments of equal agents in which any two have no group in common."""
    rng, world = np.random.default_rng(seed), catches(design.agents, 14.0, 14.0)
    apart = 0
    for _ in range(tournaments):
        ratings = rate(simulated(world, design, rng))
        apart += len({group for both in groups(ratings, ratings.points.argsort()[::-1].tolist()) for group in both}) > 1
    return apart / tournaments


def called_clear(world: World, seats: int, most_blocks: int, tournaments: int, seed: int) -> tuple[float, float]:
    """Return the share of tournaments whose order is called clear at some look, and of those in which it is wrong."""
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
    """Return the shares of trials that accept H0 and H1 (0 and `points1` points), and the mean number of blocks.

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
