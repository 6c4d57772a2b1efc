"""Matches that the tests of this folder draw."""

import catch_arena
from catch_arena.replay import Replay


def played(scenario: str = "standard", *, seed: int = 3, names=None, title: str = "", **overrides: object) -> Replay:
    """A match in which everybody chases the nearest target, with any settings."""
    env = catch_arena.parallel_env(scenario, **overrides)
    env.record(names, title)
    _, infos = env.reset(seed=seed)
    while env.agents:
        _, _, _, _, infos = env.step({agent: int(infos[agent]["action_mask"][1]) for agent in env.agents})
    return env.replay()
