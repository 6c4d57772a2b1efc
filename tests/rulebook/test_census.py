"""The census of small positions: whoever judges all that can be asked in them counts as the files say."""

from collections.abc import Callable, Sequence
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
    return [[(ruling.hunter, ruling.verdict) for ruling in engine.rulings(row)] for row in range(len(steps))]


def answers_of_the_oracle(position: Position) -> list[list[Answer]]:
    return position.answers_of_the_oracles_arena()


def require_counts(
    position: Position, kind: str, answers: Sequence[Sequence[Answer]], steps: Sequence[Any], right: Any
) -> None:
    """Fails with the position, the counts, and the first step that the oracle answers otherwise."""
    found, expected = counted(answers, len(position.hunters)), position.counts[kind]
    if found == expected:
        return
    lines = [f"{position.path.name}, {kind}: {position.situation}", str(position)]
    lines += [
        f"{key}: expected {expected.get(key, 'none')}, got {found.get(key, 'none')}"
        for key in sorted({*found, *expected})
        if found.get(key) != expected.get(key)
    ]
    for step, given, should in zip(steps, answers, right(), strict=True):
        if sorted(given) != sorted(should):
            lines.append(f"first where {step} is asked: expected {words(should)}; got {words(given)}")
            break
    pytest.fail("\n".join(lines), pytrace=False)


def words(answers: Sequence[Answer]) -> str:
    return ", ".join(f"hunter {seat} {verdict.name}" for seat, verdict in answers) or "nothing"


@pytest.mark.parametrize("arbiter", [of_the_oracle, of_arbitrate], ids=["oracle", "arbitrate"])
@pytest.mark.parametrize("position", POSITIONS, ids=lambda position: position.name)
def test_all_requests_by_name_have_the_counted_verdicts(position: Position, arbiter: Callable[..., Any]) -> None:
    """Each hunter asks for any of the names, in every combination."""
    answers = position.answers_by_name(arbiter)
    require_counts(
        position, "by_name", answers, position.steps_by_name(), lambda: position.answers_by_name(of_the_oracle)
    )


@pytest.mark.parametrize("judge", [answers_of_the_oracle, answers_of_the_engine], ids=["oracle", "engine"])
@pytest.mark.parametrize("position", IN_AN_ARENA, ids=lambda position: position.name)
def test_all_requests_by_rank_have_the_counted_verdicts(
    position: Position, judge: Callable[[Position], list[list[Answer]]]
) -> None:
    """Each hunter in an arena asks for any rank, in every combination."""
    require_counts(
        position, "by_rank", judge(position), position.steps_by_rank(), lambda: answers_of_the_oracle(position)
    )


def test_a_wrong_count_shows_the_position_and_the_step() -> None:
    """An arbiter that lets both of two hunters win."""

    def generous(**case: Any) -> list[tuple[int, int]]:
        return [(11, seat) for seat, _ in case["requests"]]

    (position,) = (one for one in POSITIONS if one.name == "nearer-wins")
    with pytest.raises(pytest.fail.Exception) as failure:
        require_counts(
            position,
            "by_name",
            position.answers_by_name(generous),
            position.steps_by_name(),
            lambda: position.answers_by_name(of_the_oracle),
        )
    assert str(failure.value).splitlines() == [
        "nearer-wins.toml, by_name: Two hunters within reach of one target, 0.1 m and 0.2 m from it.",
        "hunter 0 at (5.1, 5.0); hunter 1 at (5.0, 5.2); a at (5.0, 5.0)",
        "GRANTED: expected [2, 1], got [2, 2]",
        "LOST_CONTEST: expected [0, 1], got none",
        (
            "first where [(0, 'a'), (1, 'a')] is asked: expected hunter 0 GRANTED, hunter 1 LOST_CONTEST; "
            "got hunter 0 GRANTED, hunter 1 GRANTED"
        ),
    ]
