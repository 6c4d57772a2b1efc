"""Contents of the suite's version and its first matches, written once for each version.

`PYTHONPATH=tests python tests/suite/frozen.py` writes tests/data/suite_v1.json. That is right while nobody has
published numbers of this version; after that, what must be otherwise goes into the next one.
"""

import json
from pathlib import Path

from catch_arena.suite.contents import SUITE
from catch_arena.suite.evaluation import Evaluation, enter_opponents
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.isolation.playing import play_entrants

FILE = Path(__file__).parents[1] / "data" / "suite_v1.json"
STEPS = 150
"""Of the first match of each scenario."""


def first_matches():
    """By scenario: the seed and the seating of the first match of `nearest`, and the digest after so many steps."""
    (agent,) = enter(["nearest"])
    evaluation = Evaluation(SUITE, agent, enter_opponents(SUITE), Path(), SUITE.blocks, None, 0)
    found = {}
    for scenario in SUITE.scenarios:
        match = next(iter(SUITE.plan(scenario, 1)))
        entrants = evaluation.entrants(scenario)
        seated = [entrants[index] for index in match.seating]
        seeds = match.agent_seeds
        result = play_entrants(scenario.config, match.seed, seated, None, agent_seeds=seeds, most_steps=STEPS)
        found[scenario.name] = [match.seed, [one.name for one in seated], result.digest]
    return found


if __name__ == "__main__":
    text = json.dumps({"digest": SUITE.digest, "facts": SUITE.facts(), "first_matches": first_matches()}, indent=1)
    FILE.write_text(text + "\n")
    print(FILE)  # noqa: T201 - a script
