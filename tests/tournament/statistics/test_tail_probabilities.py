"""Tails of distributions equal SciPy's."""

import numpy as np
import pytest
from scipy import special

from catch_arena.tournament.statistics.tail_probabilities import (
    fair_coin_tail,
    student_critical,
    student_tail,
)

FREEDOMS = np.array([1.0, 2.0, 3.0, 7.0, 30.0, 999.0, 1e5])


def test_a_fair_coins_tail_is_a_count_of_all_throws():
    # of 2^5 throws of five coins, 10 + 5 + 1 have three heads at least
    assert fair_coin_tail(np.float64(3), np.float64(2)) == pytest.approx(16 / 32)
    assert fair_coin_tail(np.float64(5), np.float64(0)) == pytest.approx(1 / 32)
    heads, tails = np.array([1.0, 60.0, 5_000.0]), np.array([0.0, 40.0, 5_100.0])
    assert fair_coin_tail(heads, tails) == pytest.approx(special.betainc(heads, tails + 1, 0.5), rel=1e-9)


@pytest.mark.parametrize("t", [0.0, 0.1, 1.0, 3.0, 40.0, np.inf])
def test_students_tail_is_scipys(t):
    assert student_tail(FREEDOMS, np.full(len(FREEDOMS), t)) == pytest.approx(special.stdtr(FREEDOMS, -t), rel=1e-9)


@pytest.mark.parametrize("tail", [0.025, 0.005, 0.4])
def test_students_critical_value_is_scipys(tail):
    freedom = np.array([FREEDOMS, FREEDOMS[::-1]])
    assert student_critical(freedom, tail) == pytest.approx(special.stdtrit(freedom, 1 - tail), rel=1e-9)
