"""Scores of shipped agents in the suite, block by block, for comparison without playing these agents again.

The file has the format of `catch-arena suite --json`; `make card` writes it.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from catch_arena.suite.contents import Suite

FILE: Final = Path(__file__).parent / "references.json"

Scores = Mapping[str, Sequence[float]]
"""Normalised scores by scenario, for each block."""


def references(suite: Suite, path: Path = FILE) -> dict[str, Scores]:
    """Return the references' scores by agent, without those of another suite, whose numbers cannot be compared."""
    return {
        agent["agent"]: {name: scenario["score_by_block"] for name, scenario in agent["scenarios"].items()}
        for agent in json.loads(path.read_text())["agents"]
        if agent["suite_digest"] == suite.digest
    }
