"""Figures of an agent in a suite; docs/howto/suite.md explains how each one is computed, and why."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, islice
from pathlib import Path
from typing import Any, Final

import numpy as np

from catch_arena.suite.aggregates import (
    interquartile_estimate,
    interquartile_gap,
    performance_profile,
    probability_of_improvement,
)
from catch_arena.suite.contents import Suite, SuiteScenario
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution.runner import Setup
from catch_arena.tournament.match import MoveTimes, PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.statistics.intervals import Estimate, ratios, rounded
from catch_arena.tournament.statistics.outcomes import Floats, Outcomes, SideResults
from catch_arena.tournament.statistics.ratings import rate
from catch_arena.tournament.statistics.separation import LEVEL, holm, p_values
from catch_arena.tournament.statistics.standings import standings
from catch_arena.tournament.store import Store

PROFILE_LEVELS: Final = np.arange(20) / 20
"""Score levels of the performance profile, from 0 to 0.95."""
AGENT: Final = 0
"""The agent's index among the entrants of a suite's matches."""
REFERENCES_FILE: Final = Path(__file__).parent / "references.json"
"""Scores of shipped agents for comparison, in the format of `catch-arena suite --json`; `make card` writes it."""

Scores = Mapping[str, Sequence[float]]
"""Normalised scores by scenario, for each block."""


@dataclass(frozen=True, slots=True)
class ScenarioMeasures:
    """Figures of an agent in one scenario."""

    name: str
    held_out: bool
    by_block: tuple[float, ...]
    """The normalised score of each block, in [0, 1]; 0.5 is level with the mean opponent."""
    score: Estimate
    """Mean of `by_block`."""
    win_share: Estimate
    """Share of the matches won, in [0, 1]; parties that share the first rank share the win."""
    place: int
    """Place among the agent and its opponents by rating (docs/explanation/ratings.md), from 1, the best."""
    of: int
    """Number of entrants, of which `place` is one: the agent and its opponents."""
    first: bool | None
    """True if the agent comes first, None if that is open (`comes_first`); False if it forfeits all its matches."""
    matches: int
    forfeits: Mapping[str, int]
    """Number of forfeits by code."""
    move_ms: float
    """Mean time of a move by the wall clock [ms]; NaN if it made none."""


@dataclass(frozen=True, slots=True)
class AgentMeasures:
    """Figures of an agent in all scenarios of a suite."""

    agent: Entrant
    blocks: int
    scenarios: tuple[ScenarioMeasures, ...]

    def table(self, *, held_out: bool) -> Floats:
        """Return the normalised scores, (blocks, scenarios), in the scenarios for training or the held-out ones."""
        return np.array([one.by_block for one in self.scenarios if one.held_out == held_out]).T

    @property
    def training(self) -> Estimate:
        """Interquartile mean of the normalised scores in the scenarios for training."""
        return interquartile_estimate(self.table(held_out=False))

    @property
    def held_out(self) -> Estimate:
        """Interquartile mean of the normalised scores in the held-out scenarios."""
        return interquartile_estimate(self.table(held_out=True))

    @property
    def gap(self) -> Estimate:
        """Generalisation gap: the interquartile mean for training minus the held-out one."""
        return interquartile_gap(self.table(held_out=False), self.table(held_out=True))

    @property
    def forfeits(self) -> int:
        """Number of forfeits in all scenarios."""
        return sum(sum(one.forfeits.values()) for one in self.scenarios)

    @property
    def move_ms(self) -> float:
        """Mean of the scenarios' mean times of a move [ms], without scenarios that have no move; NaN if none has."""
        times = [one.move_ms for one in self.scenarios if not math.isnan(one.move_ms)]
        return float(np.mean(times)) if times else math.nan

    def improvement(self, reference: Scores, *, held_out: bool) -> Estimate:
        """Return the probability that a block of this agent has a higher normalised score than one of a reference.

        If the reference has more blocks, the first ones are used.
        """
        names = [one.name for one in self.scenarios if one.held_out == held_out]
        reference_table = np.array([reference[name][: self.blocks] for name in names]).T
        return probability_of_improvement(self.table(held_out=held_out), reference_table)


def measure(suite: Suite, setups: Sequence[Setup]) -> AgentMeasures:
    """Return the figures of an agent in a suite from the stores of its tournaments, which have been played."""
    scenarios = []
    for scenario, setup in zip(suite.scenarios, setups, strict=True):
        with Store.read(setup.folder) as store:  # it may have more blocks, since a plan begins with a shorter one
            played = list(islice(store.played(), setup.plan.size))
        scenarios.append(measure_scenario(scenario, setup.worker.entrants, played))
    return AgentMeasures(setups[0].worker.entrants[AGENT], len(scenarios[0].by_block), tuple(scenarios))


def measure_scenario(
    scenario: SuiteScenario, entrants: Sequence[Entrant], played: Sequence[PlayedMatch]
) -> ScenarioMeasures:
    """Return the figures of an agent in one scenario, from all matches of its plan, in the plan's order."""
    by_block = [_normalised(list(block)) for _, block in groupby(played, key=lambda one: one.match.block)]
    column = np.array(by_block)[:, None]
    (score,) = ratios(column, np.ones_like(column))
    results = SideResults.of(entrants, played, Parties.of(scenario.config))
    table = standings(results)
    (line,) = (line for line in table if line.name == entrants[AGENT].name)
    return ScenarioMeasures(
        name=scenario.name,
        held_out=scenario.held_out,
        by_block=tuple(by_block),
        score=score.as_share,
        win_share=line.win_share,
        place=line.place,
        of=len(table),
        first=comes_first(results.outcomes, score) if sum(line.forfeits.values()) < len(played) else False,
        matches=len(played),
        forfeits=line.forfeits,
        move_ms=MoveTimes.of_all([one.result.thinking[one.match.seating.index(AGENT)] for one in played]).mean_ms,
    )


def comes_first(outcomes: Outcomes, score: Estimate) -> bool | None:
    """Return whether the agent comes first among itself and its opponents; None if the matches cannot show it.

    True if it is significantly above each opponent. False if an opponent is significantly above it, or if its score is
    significantly below the mean opponent's (0.5). Each test may be wrong 5 % of the time. The test of the score needs
    fewer blocks, because it uses all of them, and an agent meets each opponent only in some blocks. Only the agent's
    own comparisons are corrected for here (Holm 1979), while `groups` compares every pair.
    """
    ratings = rate(outcomes)
    opponents = np.arange(outcomes.entrants) != AGENT
    differs = holm(p_values(ratings)[AGENT, opponents]) < LEVEL
    above = ratings.points[AGENT] > ratings.points[opponents]
    if (differs & above).all():
        return True
    return False if (differs & ~above).any() or score.high < 0.5 else None


def _normalised(block: Sequence[PlayedMatch]) -> float:
    """Return the agent's catches in a block, divided by its own and the mean opponent's catches together: in [0, 1].

    Its catches in a forfeited match do not count. Without any catches the score is 0.5, or 0 if it forfeited all
    matches.
    """
    own = opponents = 0
    forfeited = True
    for one in block:
        party = one.match.seating.index(AGENT)
        total = sum(one.result.scores)
        opponents += total - one.result.scores[party]
        if one.result.forfeits[party] is None:
            own += one.result.scores[party]
            forfeited = False
    mean = opponents / (len(block[0].match.seating) - 1)
    if own + mean == 0:
        return 0.0 if forfeited else 0.5
    return own / (own + mean)


def over_training_runs(runs: Sequence[AgentMeasures], *, held_out: bool) -> Estimate:
    """Return the interquartile mean of a training method, over runs and scenarios; each value is a mean over blocks.

    `runs` has one agent for each training seed. The interval covers the choice of training seeds.
    """
    return interquartile_estimate(np.array([run.table(held_out=held_out).mean(axis=0) for run in runs]))


def references(suite: Suite, path: Path = REFERENCES_FILE) -> dict[str, Scores]:
    """Return the references' scores by agent, without those of another suite, whose numbers cannot be compared."""
    return {
        agent["agent"]: {name: scenario["score_by_block"] for name, scenario in agent["scenarios"].items()}
        for agent in json.loads(path.read_text())["agents"]
        if agent["suite_digest"] == suite.digest
    }


def facts_of(suite: Suite, measures: AgentMeasures, references: Mapping[str, Scores]) -> Any:
    """Return all figures as JSON-ready values; None for a figure that needs more blocks."""
    parts = (("training", False), ("held_out", True))
    return {
        "suite": suite.name,
        "suite_digest": suite.digest,
        "is_protocol": measures.blocks == suite.blocks,
        "blocks": measures.blocks,
        "agent": measures.agent.name,
        "agent_digest": measures.agent.digest,
        "control": measures.agent.control,
        "iqm": {
            "training": measures.training.to_dict(),
            "held_out": measures.held_out.to_dict(),
            "gap": measures.gap.to_dict(),
        },
        "probability_of_improvement": {
            name: {part: measures.improvement(scores, held_out=held_out).to_dict() for part, held_out in parts}
            for name, scores in references.items()
        },
        "performance_profile": {
            "levels": PROFILE_LEVELS.tolist(),
            **{
                part: [one.to_dict() for one in performance_profile(measures.table(held_out=held_out), PROFILE_LEVELS)]
                for part, held_out in parts
            },
        },
        "scenarios": {
            one.name: {
                "held_out": one.held_out,
                "score": one.score.to_dict(),
                "score_by_block": list(one.by_block),
                "win_share": one.win_share.to_dict(),
                "place": one.place,
                "of": one.of,
                "first": one.first,
                "matches": one.matches,
                "forfeits": dict(one.forfeits),
                "move_ms": rounded(one.move_ms),
            }
            for one in measures.scenarios
        },
    }
