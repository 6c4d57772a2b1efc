"""The census of small positions: oracle, `arbitrate` and engine count the verdicts that the files say."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from rulebook.census.enumeration import Answer, Position, counted, of_the_oracle, positions

from catch_arena.arbitration import arbitrate
from catch_arena.engine import Engine

POSITIONS = positions()
IN_AN_ARENA = [position for position in POSITIONS if position.in_an_arena]


def of_arbitrate(**case: Any) -> list[tuple[int, int]]:
    return [(ruling.verdict, ruling.hunter) for ruling in arbitrate(**case)]


def answers_of_the_engine(position: Position) -> list[list[Answer]]:
    """Every step in a row of one batch."""
    steps = position.steps_by_rank()
    engine = Engine(position.config, len(steps))
    engine.reset([position.seed] * len(steps))
    for row in range(len(steps)):
        engine.place(row, position.poses, list(position.targets.values()))
        for seat in position.withdrawn:
            engine.withdraw(row, seat)
    engine.step(np.array(steps, np.int64), np.zeros((*np.shape(steps), 2), np.float32))
    return [[(ruling.hunter, ruling.verdict) for ruling in engine.world(row).rulings] for row in range(len(steps))]


def require_counts(position: Position, kind: str, answers: list[list[Answer]]) -> None:
    """Fail with the position and the counts that differ."""
    found, expected = counted(answers, len(position.hunters)), position.counts[kind]
    differing = {key: (expected.get(key), found.get(key)) for key in found | expected}
    differing = {key: pair for key, pair in differing.items() if pair[0] != pair[1]}
    assert not differing, f"{position.path.name}, {kind}: {position}: (expected, got)"


@pytest.mark.parametrize("arbiter", [of_the_oracle, of_arbitrate], ids=["oracle", "arbitrate"])
@pytest.mark.parametrize("position", POSITIONS, ids=lambda position: position.name)
def test_all_requests_by_name_have_the_counted_verdicts(position: Position, arbiter: Callable[..., Any]) -> None:
    """Each hunter asks for any of the names, in every combination."""
    require_counts(position, "by_name", position.answers_by_name(arbiter))


@pytest.mark.parametrize(
    "judge", [Position.answers_of_the_oracles_arena, answers_of_the_engine], ids=["oracle", "engine"]
)
@pytest.mark.parametrize("position", IN_AN_ARENA, ids=lambda position: position.name)
def test_all_requests_by_rank_have_the_counted_verdicts(
    position: Position, judge: Callable[[Position], list[list[Answer]]]
) -> None:
    """Each hunter in an arena asks for any rank, in every combination."""
    require_counts(position, "by_rank", judge(position))
