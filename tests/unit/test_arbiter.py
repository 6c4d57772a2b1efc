"""The arbiter's request table, column by column, and what no table can show."""

import numpy as np
import pytest

from catch_arena.core.arbiter import (
    FIRST_COME,
    NEAREST,
    REQUEST_COLUMNS,
    REQUEST_DISTANCE,
    REQUEST_INACTIVE,
    REQUEST_KILL_REFUSED,
    REQUEST_NUMBER,
    REQUEST_REACH,
    REQUEST_SEAT,
    REQUEST_TARGET,
    REQUEST_VERDICT,
    REQUEST_WINNER,
    is_preferred,
    judge_alone,
)
from catch_arena.core.jit import entry
from catch_arena.core.state import ALREADY_GONE, MALFORMED_REQUEST, NEVER_SPAWNED
from catch_arena.verdicts import Verdict

COLUMNS = [
    REQUEST_SEAT,
    REQUEST_TARGET,
    REQUEST_NUMBER,
    REQUEST_DISTANCE,
    REQUEST_INACTIVE,
    REQUEST_KILL_REFUSED,
    REQUEST_REACH,
    REQUEST_VERDICT,
    REQUEST_WINNER,
]
TARGET_7 = {REQUEST_TARGET: 7, REQUEST_NUMBER: 7}


def test_each_column_of_the_table_is_its_own():
    """What is written does not take the place of what is read."""
    assert sorted(COLUMNS) == list(range(REQUEST_COLUMNS))


def judged(*rows):
    """The table after judgement, of requests by seat that are 100 000 micrometres from target 7, with a reach of
    300 000, if nothing else is said.
    """
    table = np.full((len(rows), REQUEST_COLUMNS), 99, dtype=np.int64)
    for seat, (line, row) in enumerate(zip(table, rows, strict=True)):
        usual = {REQUEST_SEAT: seat, REQUEST_DISTANCE: 100_000, REQUEST_REACH: 300_000}
        flags = {REQUEST_INACTIVE: 0, REQUEST_KILL_REFUSED: 0}
        for column, value in (usual | flags | TARGET_7 | row).items():
            line[column] = value
    judge_alone(table, NEAREST, np.uint64(1), 0, False, True)
    return table


@pytest.mark.parametrize(
    ("row", "verdict", "distance"),
    [
        ({}, Verdict.GRANTED, 100_000),
        ({REQUEST_DISTANCE: 299_999}, Verdict.GRANTED, 299_999),
        ({REQUEST_DISTANCE: 300_000}, Verdict.OUT_OF_REACH, 300_000),
        ({REQUEST_REACH: 100_001}, Verdict.GRANTED, 100_000),
        ({REQUEST_REACH: 100_000}, Verdict.OUT_OF_REACH, 100_000),
        ({REQUEST_KILL_REFUSED: 1}, Verdict.KILL_FAILED, 100_000),
        ({REQUEST_INACTIVE: 1}, Verdict.HUNTER_INACTIVE, -1),
        ({REQUEST_TARGET: MALFORMED_REQUEST}, Verdict.MALFORMED, -1),
        ({REQUEST_TARGET: NEVER_SPAWNED}, Verdict.UNKNOWN_TARGET, -1),
        ({REQUEST_TARGET: ALREADY_GONE}, Verdict.ALREADY_CAUGHT, -1),
    ],
)
def test_what_is_not_there_is_written_as_minus_one(row, verdict, distance):
    """As the table says it: a distance that was not tested, and a winner where there was no grant and no contest."""
    (line,) = judged(row)
    assert (line[REQUEST_VERDICT], line[REQUEST_DISTANCE]) == (verdict, distance)
    assert line[REQUEST_WINNER] == (0 if verdict is Verdict.GRANTED else -1)


def test_a_refused_kill_is_won_by_somebody_where_it_was_contested():
    """R5.6."""
    refused, another = {REQUEST_KILL_REFUSED: 1}, {REQUEST_TARGET: 8, REQUEST_NUMBER: 8}
    table = judged(refused, refused | {REQUEST_DISTANCE: 200_000}, refused | another)
    assert table[:, REQUEST_VERDICT].tolist() == [Verdict.KILL_FAILED, Verdict.LOST_CONTEST, Verdict.KILL_FAILED]
    assert table[:, REQUEST_WINNER].tolist() == [0, 0, -1]


@entry
def prefers(policy: int, one: int, other: int) -> bool:
    """Lets Python call a rule that only compiled code calls."""
    return is_preferred(policy, np.uint64(5), 3, 7, one, 100_000, other, 100_000)


@pytest.mark.parametrize("policy", [NEAREST, FIRST_COME])
def test_of_two_hunters_equally_near_one_is_preferred_and_nobody_to_itself(policy):
    """R5.5, R5.9: the lots of two seats are never equal, since A.5's mix is a permutation; so nothing else shows it."""
    for one in range(16):
        for other in range(16):
            assert prefers(policy, one, other) + prefers(policy, other, one) == (one != other)
