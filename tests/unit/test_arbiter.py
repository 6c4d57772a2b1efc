"""The arbiter's docket, column by column, and what no docket can show."""

import numpy as np
import pytest

from catch_arena.core.arbiter import (
    ALREADY_GONE,
    DISTANCE,
    DOCKET_COLUMNS,
    FIRST_COME,
    INACTIVE,
    NEAREST,
    NEVER_SPAWNED,
    NO_SUCH_RANK,
    REFUSED,
    SEAT,
    TARGET,
    TARGET_NUMBER,
    VERDICT,
    WINNER,
    is_preferred,
    judge,
)
from catch_arena.core.jit import entry
from catch_arena.verdicts import Verdict

TARGET_7 = {TARGET: 7, TARGET_NUMBER: 7}


def judged(*rows):
    """The docket after judgement, of requests by seat that are 100 000 micrometres from target 7 if nothing else is
    said.
    """
    docket = np.full((len(rows), DOCKET_COLUMNS), 99, dtype=np.int64)
    for seat, (line, row) in enumerate(zip(docket, rows, strict=True)):
        for column, value in ({SEAT: seat, **TARGET_7, DISTANCE: 100_000, INACTIVE: 0, REFUSED: 0} | row).items():
            line[column] = value
    judge(docket, NEAREST, np.uint64(1), 0, 300_000, False, True)
    return docket


@pytest.mark.parametrize(
    ("row", "verdict", "distance"),
    [
        ({}, Verdict.GRANTED, 100_000),
        ({DISTANCE: 299_999}, Verdict.GRANTED, 299_999),
        ({DISTANCE: 300_000}, Verdict.OUT_OF_REACH, 300_000),
        ({REFUSED: 1}, Verdict.KILL_FAILED, 100_000),
        ({INACTIVE: 1}, Verdict.HUNTER_INACTIVE, -1),
        ({TARGET: NO_SUCH_RANK}, Verdict.MALFORMED, -1),
        ({TARGET: NEVER_SPAWNED}, Verdict.UNKNOWN_TARGET, -1),
        ({TARGET: ALREADY_GONE}, Verdict.ALREADY_CAUGHT, -1),
    ],
)
def test_what_is_not_there_is_written_as_minus_one(row, verdict, distance):
    """The docket's own words: a distance that was not tested, and a winner where there was no grant and no contest."""
    (line,) = judged(row)
    assert (line[VERDICT], line[DISTANCE]) == (verdict, distance)
    assert line[WINNER] == (0 if verdict is Verdict.GRANTED else -1)


def test_a_refused_kill_is_won_by_somebody_where_it_was_contested():
    """R5.6."""
    docket = judged({REFUSED: 1}, {REFUSED: 1, DISTANCE: 200_000}, {TARGET: 8, TARGET_NUMBER: 8, REFUSED: 1})
    assert docket[:, VERDICT].tolist() == [Verdict.KILL_FAILED, Verdict.LOST_CONTEST, Verdict.KILL_FAILED]
    assert docket[:, WINNER].tolist() == [0, 0, -1]


@entry
def prefers(policy: int, one: int, other: int) -> bool:
    """A door for Python to a rule that has none."""
    return is_preferred(policy, np.uint64(5), 3, 7, one, 100_000, other, 100_000)


@pytest.mark.parametrize("policy", [NEAREST, FIRST_COME])
def test_of_two_hunters_equally_near_one_is_preferred_and_nobody_to_itself(policy):
    """R5.5, R5.9: tickets of two seats are never equal, since A.5's mix is a permutation; so nothing else shows it."""
    for one in range(16):
        for other in range(16):
            assert prefers(policy, one, other) + prefers(policy, other, one) == (one != other)
