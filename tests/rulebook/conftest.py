"""The `arena` of the rulebook's tests, and the `court` that judges requests by name."""

from collections.abc import Callable
from typing import Any

import pytest
from oracle.arena import judge
from rulebook.adjudicators import ADJUDICATORS, Adjudicator, adjudicator

from catch_arena.arbitration import arbitrate
from catch_arena.config import ArenaConfig
from catch_arena.verdicts import Ruling, Verdict

ArenaFactory = Callable[..., Adjudicator]
Court = Callable[..., list[Ruling]]


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


def oracle_court(**case: Any) -> list[Ruling]:
    """The oracle's judgement as Rulings."""
    return [Ruling(Verdict(verdict), *rest, step=case.get("step", 0)) for verdict, *rest in judge(**case)]


@pytest.fixture(params=[oracle_court, arbitrate], ids=["oracle", "arbitrate"])
def court(request: pytest.FixtureRequest) -> Court:
    """Whoever judges requests by name: `arbitrate`, and the oracle's `judge`."""
    judged: Court = request.param
    return judged
