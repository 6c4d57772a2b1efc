"""Simulate a league with known strengths: a term of new versions, and newcomers among many (docs/howto/league.md).

A match is drawn by the model of Plackett and Luce: each player gets its strength plus Gumbel noise, and the block adds
noise of its own, since its matches share their targets. No match is played in the arena.
"""

import argparse
import math
import sys
import time

import numpy as np

from catch_arena.league.matchmaking import Evidence, next_blocks, weigh
from catch_arena.tournament.statistics.intervals import Estimate
from catch_arena.tournament.statistics.outcomes import Outcomes
from catch_arena.tournament.statistics.ratings import ELO

GROUP = 4
PRECISION, MOST_BLOCKS, KEPT = 100.0, 50, 20_000
BLOCK_NOISE = 0.3


class Matches:
    """Drawn matches: block, players by seat, and ranks."""

    def __init__(self, draw: np.random.Generator) -> None:
        self.draw = draw
        self.rows: list[tuple[int, tuple[int, ...], list[int]]] = []
        self.blocks = 0

    def play(self, groups: list[tuple[int, ...]], strengths: dict[int, float]) -> None:
        """Draw the blocks of these groups, each in all rotations of the seats."""
        for group in groups:
            luck = dict(zip(group, self.draw.normal(0.0, BLOCK_NOISE, len(group)), strict=True))
            for turn in range(len(group)):
                seats = (*group[turn:], *group[:turn])
                marks = [strengths[one] / ELO + luck[one] + self.draw.gumbel() for one in seats]
                self.rows.append((self.blocks, seats, [1 + sum(other > mark for other in marks) for mark in marks]))
            self.blocks += 1

    def outcomes(self) -> Outcomes:
        """Return the matches that a league keeps."""
        kept = self.rows[-KEPT:]
        block, seats, ranks = (np.array([row[part] for row in kept], dtype=np.int64) for part in range(3))
        return Outcomes(0, np.unique(block, return_inverse=True)[1].astype(np.int64), seats, -ranks, ranks)


def term(agents: int, days: int, seed: int) -> None:
    """Print for each day how far the table is from the truth, and how many matches were played."""
    draw = np.random.default_rng(seed)
    strengths = {0: 0.0} | {number: draw.normal(0.0, 300.0) for number in range(1, agents)}
    current, matches, evidence = list(strengths), Matches(draw), Evidence()
    print("| day | new versions | matches | error [points] | rank correlation | CPU of the fits [s] |")
    print("|---|---|---|---|---|---|")
    for day in range(1, days + 1):
        changed = [] if day == 1 else draw.choice(np.arange(1, agents), agents // 5, replace=False).tolist()
        for place in changed:  # a new version is a new entrant
            strengths[len(strengths)] = strengths[current[place]] + draw.normal(10.0, 60.0)
            current[place] = len(strengths) - 1
        before, began = len(matches.rows), time.process_time()
        while waiting := [one for one in current[1:] if is_waiting(one, evidence)]:
            waiting.sort(key=lambda one: evidence.blocks.get(one, 0))
            groups = next_blocks(waiting, current, evidence, GROUP, lambda *_: int(draw.integers(1 << 30)))
            matches.play(groups, strengths)
            evidence = weigh(matches.outcomes(), 0, current)
        truth = np.array([strengths[one] for one in current])
        found = np.array([evidence.ratings[one].mean for one in current])
        gaps = found - truth
        order = np.corrcoef(truth.argsort().argsort(), found.argsort().argsort())[0, 1]
        spent = time.process_time() - began
        print(
            f"| {day} | {len(changed) or agents} | {len(matches.rows) - before} | {gaps.std():.0f} | {order:.3f} "
            f"| {spent:.1f} |",
            flush=True,
        )


def is_waiting(one: int, evidence: Evidence) -> bool:
    """Return whether an agent has no clear place yet, as in a league."""
    return not evidence.is_placed(one, PRECISION) and evidence.blocks.get(one, 0) < MOST_BLOCKS


def newcomers(sizes: list[int], repeats: int, seed: int) -> None:
    """Print how many matches place a newcomer among agents whose strengths are known."""
    print("| agents | matches: median, 90 % | error [points] |")
    print("|---|---|---|")
    for size in sizes:
        needed, errors = [], []
        for repeat in range(repeats):
            draw = np.random.default_rng((seed, size, repeat))
            strengths = dict(enumerate(draw.normal(0.0, 300.0, size))) | {size: draw.normal(0.0, 300.0)}
            known = {one: Estimate(points, points, points) for one, points in strengths.items() if one != size}
            matches, rating, margin = Matches(draw), 0.0, math.inf
            while margin > PRECISION and matches.blocks < MOST_BLOCKS:
                evidence = Evidence(known | {size: Estimate(rating, rating, rating)}, {}, {})
                matches.play(next_blocks([size], strengths, evidence, GROUP, lambda a, b: a ^ b), strengths)
                rating, margin = place(matches, strengths, size)
            needed.append(len(matches.rows))
            errors.append(rating - strengths[size])
        middle, most = np.quantile(needed, (0.5, 0.9))
        print(f"| {size} | {middle:.0f}, {most:.0f} | {np.std(errors):.0f} |", flush=True)


def place(matches: Matches, strengths: dict[int, float], newcomer: int) -> tuple[float, float]:
    """Return the rating of a newcomer whose opponents are known, and half the width of its interval."""
    rows = [(block, seats, ranks, seats.index(newcomer)) for block, seats, ranks in matches.rows]
    games = [
        (block, strengths[other], float(ranks[own] < ranks[seat]))
        for block, seats, ranks, own in rows
        for seat, other in enumerate(seats)
        if seat != own
    ]
    block, others, won = (np.array(column) for column in zip(*games, strict=True))
    rating = 0.0
    for _ in range(50):
        chance = 1.0 / (1.0 + np.exp((others - rating) / ELO))
        own = 1.0 / (1.0 + math.exp(-rating / ELO))  # half a game won and half a game lost against 0, as in a league
        information = (chance * (1.0 - chance)).sum() + own * (1.0 - own)
        rating += ELO * float(np.clip(((won - chance).sum() + 0.5 - own) / information, -1.0, 1.0))
    pulls = np.bincount(block, won - chance)
    margin = 1.96 * ELO * math.sqrt(float((pulls**2).sum())) / information
    return rating, margin if matches.blocks >= GROUP else math.inf


def main() -> None:
    """Run the simulation that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--agents", type=int, default=200, help="agents of the term")
    parser.add_argument("--days", type=int, default=30, help="days of the term")
    parser.add_argument("--sizes", type=int, nargs="*", default=[100, 1_000, 10_000, 100_000], help="for newcomers")
    parser.add_argument("--repeats", type=int, default=10, help="number of newcomers for each size")
    parser.add_argument("--seed", type=int, default=0)
    words = parser.parse_args()
    newcomers(words.sizes, words.repeats, words.seed)
    term(words.agents, words.days, words.seed)


if __name__ == "__main__":
    sys.exit(main())
