"""What shipped agents reached in the suite, block by block: others are compared with them without playing them anew.
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
"""The normalised scores by block, by scenario."""


def references(suite: Suite, path: Path = FILE) -> dict[str, Scores]:
    """By agent; nothing where the file is missing, or of another suite: its numbers cannot be compared then."""
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
    """The file, from what agents reached; those that are no references, or played less, are left out. No score is
    rounded: equal ones must stay equal.

    Args:
        suite: which all of them played.
        measured: the agents.
        known: scores of before, which stay in the file where nothing newer is known.
    """
    scores = {name: dict(by_scenario) for name, by_scenario in (known or {}).items()} | {
        one.agent.name: {of.name: of.by_block for of in one.scenarios}
        for one in measured
        if one.agent.name in REFERENCES and one.blocks == suite.blocks
    }
    return json.dumps({"suite": suite.name, "suite_digest": suite.digest, "scores": scores}, indent=1) + "\n"
