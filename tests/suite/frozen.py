"""Contents of each suite and its first matches, written once for each version.

`PYTHONPATH=tests python tests/suite/frozen.py NAME` writes the suite's file in tests/data. That is right while nobody
has published numbers of this version; after that, what must be otherwise goes into the next one.
"""

import json
import sys
from pathlib import Path

from catch_arena.suite.contents import suite_called
from catch_arena.suite.tournaments import tournaments
from catch_arena.tournament.match_loop import play_entrants
from catch_arena.tournament.players import enter

DATA = Path(__file__).parents[1] / "data"
STEPS = 150
"""Of the first match of each scenario."""


def file_of(suite):
    return DATA / f"{suite.name.removeprefix('catch_arena_')}.json"


def first_matches(suite):
    """By scenario: the seed and the seating of the first match of `nearest`, and the digest after so many steps."""
    (agent,) = enter(["nearest"])
    found = {}
    for one in tournaments(suite, agent, Path(), suite.blocks, None):
        match = next(iter(one.plan))
        seated = [one.worker.entrants[index] for index in match.seating]
        seeds = match.agent_seeds
        result = play_entrants(one.worker.config, match.seed, seated, None, agent_seeds=seeds, most_steps=STEPS)
        found[one.folder.name] = [match.seed, [one.name for one in seated], result.digest]
    return found


if __name__ == "__main__":
    SUITE = suite_called(sys.argv[1])
    text = json.dumps({"digest": SUITE.digest, "facts": SUITE.facts(), "first_matches": first_matches(SUITE)}, indent=1)
    file_of(SUITE).write_text(text + "\n")
    print(file_of(SUITE))  # noqa: T201 - a script
