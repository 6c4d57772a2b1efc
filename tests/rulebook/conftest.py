"""The `arena` of the rulebook's tests, and the `arbiter` that judges requests by name."""

from collections.abc import Callable
from typing import Any

import pytest
from oracle.arbiter import judge
from rulebook.adjudicators import ADJUDICATORS, Adjudicator, adjudicator

from catch_arena.arbitration import arbitrate
from catch_arena.config import ArenaConfig
from catch_arena.verdicts import Ruling, Verdict

ArenaFactory = Callable[..., Adjudicator]
Arbiter = Callable[..., list[Ruling]]


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


def oracle_arbiter(**case: Any) -> list[Ruling]:
    """The oracle's judgement as Rulings."""
    return [Ruling(Verdict(verdict), *rest, step=case.get("step", 0)) for verdict, *rest in judge(**case)]


@pytest.fixture(params=[oracle_arbiter, arbitrate], ids=["oracle", "arbitrate"])
def arbiter(request: pytest.FixtureRequest) -> Arbiter:
    """Whoever judges requests by name: `arbitrate`, and the oracle's `judge`."""
    judged: Arbiter = request.param
    return judged
