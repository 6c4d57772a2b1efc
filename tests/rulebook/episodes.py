"""Episodes of random actions, as their digests; as a script, in a process of its own: `episodes.py faulty 600`."""

import sys
from random import Random

import numpy as np

from catch_arena.config import ArenaConfig
from catch_arena.engine import Engine
from catch_arena.scenarios import scenario

SEED = 2026


def config_of(name: str) -> ArenaConfig:
    """Return a scenario, with hunters that drive and ask."""
    return scenario(name, control=("target", "full") * 8 if name == "crowd" else "full")


def digests(name: str, steps: int) -> list[str]:
    """The digest after each step."""
    config = config_of(name)
    engine = Engine(config)
    engine.reset([SEED])
    source = Random(SEED)
    found = []
    for _ in range(steps):
        choices = np.array([[int(3 * source.random()) for _ in range(config.hunters)]])
        commands = [[2 * source.random() - 1, 2 * source.random() - 1] for _ in range(config.hunters)]
        engine.step(choices, np.array([commands], np.float32))
        found.append(engine.digest(0).hex())
    return found


if __name__ == "__main__":
    sys.stdout.write("\n".join(digests(sys.argv[1], int(sys.argv[2]))))
