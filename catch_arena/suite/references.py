"""Scores of shipped agents in the suite, block by block, for comparison without playing these agents again.

`make card` writes the file.
"""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Final

from catch_arena.suite.contents import REFERENCES, Suite
from catch_arena.suite.measures import AgentMeasures

FILE: Final = Path(__file__).parent / "references.json"

Scores = Mapping[str, tuple[float, ...]]
"""Normalised scores by scenario, for each block."""


def references(suite: Suite, path: Path = FILE) -> dict[str, Scores]:
    """Return the references' scores by agent.

    Empty if the file is missing, or if it is of another suite, whose numbers cannot be compared.
    """
    try:
        found = json.loads(path.read_text())
    except FileNotFoundError:
        return {}
    if found["suite_digest"] != suite.digest:
        return {}
    return {
        name: {scenario: tuple(scores) for scenario, scores in by_scenario.items()}
        for name, by_scenario in found["scores"].items()
    }


def references_text(suite: Suite, measured: Iterable[AgentMeasures], known: Mapping[str, Scores] | None = None) -> str:
    """Return the text of the file from the figures of agents; agents that are no references are left out.

    Agents that played fewer blocks than the suite has are left out too. Scores are not rounded, so that equal scores
    stay equal.

    Args:
        suite: the suite that all of them played.
        measured: the agents' figures.
        known: earlier scores, which stay in the file if there are no newer ones.
    """
    scores = {name: dict(by_scenario) for name, by_scenario in (known or {}).items()} | {
        one.agent.name: {of.name: of.by_block for of in one.scenarios}
        for one in measured
        if one.agent.name in REFERENCES and one.blocks == suite.blocks
    }
    return json.dumps({"suite": suite.name, "suite_digest": suite.digest, "scores": scores}, indent=1) + "\n"
