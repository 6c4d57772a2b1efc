"""The tails of distributions, beside SciPy's."""

import numpy as np
import pytest
from scipy import special

from catch_arena.tournament.statistics.tail_probabilities import (
    fair_coin_tail,
    incomplete_beta,
    student_critical,
    student_tail,
)

SEED = 20261122
FREEDOMS = np.array([1.0, 2.0, 3.0, 7.0, 30.0, 999.0, 1e5])


def test_the_incomplete_beta_function_is_scipys_from_tenths_to_ten_thousands():
    random = np.random.default_rng(SEED)
    a, b, x = 10 ** random.uniform(-1, 4, 5000), 10 ** random.uniform(-1, 4, 5000), random.uniform(0, 1, 5000)
    expected = special.betainc(a, b, x)
    assert incomplete_beta(a, b, x) == pytest.approx(expected, rel=1e-9, abs=1e-200)


def test_at_its_ends_the_incomplete_beta_function_is_zero_and_one():
    assert incomplete_beta(np.float64(3), np.float64(0.5), np.array([0.0, 1.0])).tolist() == [0.0, 1.0]


def test_what_is_no_number_stays_none_and_does_not_keep_the_others_waiting():
    found = incomplete_beta(np.array([2.0, np.nan]), np.float64(3), np.float64(0.25))
    assert found[0] == pytest.approx(special.betainc(2, 3, 0.25))
    assert np.isnan(found[1])


def test_a_fair_coins_tail_is_a_count_of_all_throws():
    # of 2^5 throws of five coins, 10 + 5 + 1 have three heads at least
    assert fair_coin_tail(np.float64(3), np.float64(2)) == pytest.approx(16 / 32)
    assert fair_coin_tail(np.float64(5), np.float64(0)) == pytest.approx(1 / 32)


@pytest.mark.parametrize("t", [0.0, 0.1, 1.0, 3.0, 40.0, np.inf])
def test_students_tail_is_scipys(t):
    assert student_tail(FREEDOMS, np.full(len(FREEDOMS), t)) == pytest.approx(special.stdtr(FREEDOMS, -t), rel=1e-9)


@pytest.mark.parametrize("tail", [0.025, 0.005, 0.4])
def test_students_critical_value_is_scipys(tail):
    freedom = np.array([FREEDOMS, FREEDOMS[::-1]])
    assert student_critical(freedom, tail) == pytest.approx(special.stdtrit(freedom, 1 - tail), rel=1e-9)
