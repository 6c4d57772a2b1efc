"""Measure all agents that ship against each other: `python scripts/measure_field.py standard fog --matches 512`.

Each match seats different agents, drawn at random, and all matches of a scenario are played at once, in a batch of
arenas. Prints a Markdown table: for each agent and scenario the mean score, and the share of matches that it won (a win
that k hunters share counts 1 / k), with half of its 95 % interval (1.96 standard errors). Who wins most in the first
scenario comes first. Behind it come the pairs of agents that stand in another order than in the first scenario, where
both orders are sure: in each of the two scenarios the shares of wins differ by more than 1.96 standard errors of their
difference. Not for scenarios with teams or prey.
"""

import argparse
import math
import sys
from collections.abc import Mapping
from itertools import permutations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena import VectorArena, scenario
from catch_arena.cli.progress import progress_bar
from catch_arena.config import RewardWeights
from catch_arena.errors import CatchArenaError, ConfigError
from catch_arena.tournament.loading import shipped
from catch_arena.training.opponents import Opponents

NOT_HUNTERS = ("corners", "flee", "idle", "random")
"""The first two hunt as `contested` and `nearest` do."""


class Figures(NamedTuple):
    """What was measured of one agent in one scenario."""

    score: float
    """Catches a match."""
    wins: float
    """The share of its matches that it won."""
    margin: float
    """Half of the 95 % interval of `wins`."""

    def __str__(self) -> str:
        return f"{self.score:.1f}, {100 * self.wins:.0f} ± {100 * self.margin:.0f} %"

    def surely_leads(self, other: "Figures") -> bool:
        """Whether its share of wins is larger by more than the interval of the difference."""
        return self.wins - other.wins > math.hypot(self.margin, other.margin)


def scores_of(name: str, agents: list[str], matches: int, seed: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Who played, as numbers of `agents`, and how much each caught: (matches, hunters) both.

    Raises:
        ConfigError: for a scenario with teams or prey, and for too few agents.
    """
    config = scenario(name).replace(rewards=RewardWeights())  # catches alone
    if config.teams is not None or config.prey:
        raise ConfigError(f"scenarios must have no teams and no prey, got {name}")
    if len(agents) < config.hunters:
        raise ConfigError(f"agents must be at least {config.hunters} for {name}, got {len(agents)}")
    arena = VectorArena(config.replace(control="velocity"), matches, auto_reset=False, any_control=True)
    field, rng = Opponents(arena.config, matches, agents, distinct=True), np.random.default_rng(seed)
    field.begin(rng)
    who = field.draw(np.arange(matches), np.tile(np.arange(config.hunters), (matches, 1)), rng)
    observations, infos = arena.reset(seed=seed)
    arena.set_controls(field.controls[who])
    choices, commands = np.zeros(who.shape, np.int64), np.zeros((*who.shape, 2), np.float32)
    scores = np.zeros(who.shape)
    with progress_bar(name) as show:
        for step in range(config.max_steps):
            field.act(observations, infos["action_mask"], choices, commands)
            observations, caught, _, _, infos = arena.step(choices, commands)
            scores += caught
            show(step + 1, config.max_steps)
    return who, scores


def figures_of(agents: list[str], who: NDArray[np.int64], scores: NDArray[np.float64]) -> dict[str, Figures]:
    """What was measured of each agent; without those that did not play."""
    best = scores == scores.max(axis=1, keepdims=True)
    wins = best / best.sum(axis=1, keepdims=True)
    figures = {}
    for number, agent in enumerate(agents):
        own = who == number
        if own.any():
            margin = 1.96 * wins[own].std() / math.sqrt(own.sum())
            figures[agent] = Figures(float(scores[own].mean()), float(wins[own].mean()), float(margin))
    return figures


def turned(usual: Mapping[str, Figures], other: Mapping[str, Figures]) -> list[tuple[str, str]]:
    """The pairs of agents whose first surely leads in `other`, and whose second surely leads in `usual`."""
    return [
        (one, two)
        for one, two in permutations(sorted(usual.keys() & other.keys()), 2)
        if other[one].surely_leads(other[two]) and usual[two].surely_leads(usual[one])
    ]


def main() -> int:
    """The exit code: 0, or 2 with a line that says why not."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenarios", nargs="+", help="their names")
    hunters = [name for name in shipped() if name not in NOT_HUNTERS]
    parser.add_argument("--agents", nargs="+", default=hunters, help="who plays; all are trusted, and play in here")
    parser.add_argument("--matches", type=int, default=512, help="of each scenario")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    try:
        told = {
            name: figures_of(args.agents, *scores_of(name, args.agents, args.matches, args.seed))
            for name in args.scenarios
        }
    except CatchArenaError as error:
        print(error, file=sys.stderr)
        return 2
    print(f"| agent | {' | '.join(f'`{name}`' for name in args.scenarios)} |")
    print(f"|---|{'---|' * len(args.scenarios)}")
    usual, *others = args.scenarios
    for agent in sorted(told[usual], key=lambda agent: -told[usual][agent].wins):
        print(f"| `{agent}` | {' | '.join(str(figures.get(agent, '')) for figures in told.values())} |")
    for name in others:
        pairs = ", ".join(f"`{one}` before `{two}`" for one, two in turned(told[usual], told[name]))
        print(f"\n`{name}`, other than in `{usual}`: {pairs or 'none'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
