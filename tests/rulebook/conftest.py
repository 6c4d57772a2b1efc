"""The `arena` of the rulebook's tests."""

from collections.abc import Callable

import pytest
from rulebook.adjudicators import ADJUDICATORS, Adjudicator, adjudicator

from catch_arena.config import ArenaConfig

ArenaFactory = Callable[..., Adjudicator]


@pytest.fixture(params=ADJUDICATORS)
def arena(request: pytest.FixtureRequest) -> ArenaFactory:
    """A factory of arenas, once for each adjudicator: settings as in ArenaConfig, but one hunter and no targets.

    `seed` is the episode's; the arena comes reset.
    """

    def make(*, seed: int = 1, **settings: object) -> Adjudicator:
        quiet = {"hunters": 1, "initial_targets": 0, "spawn_frequency_hz": 0.001, **settings}
        made = adjudicator(request.param, ArenaConfig().replace(**quiet))
        made.reset(seed)
        return made

    return make
