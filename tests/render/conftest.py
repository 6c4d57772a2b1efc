"""Matches that the tests of this folder draw."""

from collections.abc import Callable

import pytest
from render.matches import played

from catch_arena.replay import Replay


@pytest.fixture(scope="session")
def play() -> Callable[..., Replay]:
    """Plays a match in which everybody chases the nearest target, with any settings."""
    return played


@pytest.fixture(scope="session")
def match(play) -> Replay:
    """Four hunters, three seconds."""
    return play(time_limit_s=3.0, names=("contested", "nearest", "patrol", "first"), title="Round 1")


@pytest.fixture(scope="session")
def worlds(match) -> list:
    """Its pictures."""
    return list(match.worlds())
