"""Matches that the tests of this folder draw."""

from collections.abc import Callable

import pytest

import catch_arena
from catch_arena.replay import Replay


@pytest.fixture(scope="session")
def play() -> Callable[..., Replay]:
    """Plays a match in which everybody chases the nearest target, with any settings."""

    def played(
        scenario: str = "standard", *, seed: int = 3, names=None, title: str = "", **overrides: object
    ) -> Replay:
        env = catch_arena.parallel_env(scenario, **overrides)
        env.record(names, title)
        _, infos = env.reset(seed=seed)
        while env.agents:
            _, _, _, _, infos = env.step({agent: int(infos[agent]["action_mask"][1]) for agent in env.agents})
        return env.replay()

    return played


@pytest.fixture(scope="session")
def match(play) -> Replay:
    """Four hunters, three seconds."""
    return play(time_limit_s=3.0, names=("contested", "nearest", "patrol", "first"), title="Round 1")


@pytest.fixture(scope="session")
def worlds(match) -> list:
    """Its pictures."""
    return list(match.worlds())
