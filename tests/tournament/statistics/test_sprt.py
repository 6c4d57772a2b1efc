"""The sequential test of `compare` equals Wald's test, and errs as rarely as promised."""

import math

import pytest
import simulated_tournaments as simulations

from catch_arena.tournament.statistics.sprt import Sprt, elo_of_share, share_of_elo


def test_with_two_outcomes_it_is_walds_test():
    """Wins and defeats only: the ratio is that of two binomials."""
    test = Sprt(0.5, 0.6)
    for outcome in [1.0] * 30 + [0.0] * 20:
        test.add(outcome)
    assert test.log_likelihood_ratio == pytest.approx(30 * math.log(0.6 / 0.5) + 20 * math.log(0.4 / 0.5), abs=1e-3)
    assert test.bounds == pytest.approx((-math.log(19), math.log(19)))
    assert test.decision is None


def test_with_many_close_outcomes_it_is_the_normal_approximation():
    """N (s1 - s0) (2 mean - s0 - s1) / (2 variance), as engines' testers first used it."""
    test = Sprt(0.50, 0.52)
    for outcome, count in ((0.25, 100), (0.5, 220), (0.75, 120)):
        for _ in range(count):
            test.add(outcome)
    mean = (0.25 * 100 + 0.5 * 220 + 0.75 * 120) / 440
    variance = (100 * (0.25 - mean) ** 2 + 220 * (0.5 - mean) ** 2 + 120 * (0.75 - mean) ** 2) / 440
    assert test.log_likelihood_ratio == pytest.approx(440 * 0.02 * (2 * mean - 1.02) / (2 * variance), rel=0.03)


def test_a_few_outcomes_all_alike_decide_nothing():
    test = Sprt(0.5, 0.53)
    for _ in range(5):
        test.add(1.0)
    assert test.decision is None


@pytest.mark.parametrize(("truth", "wrong"), [(0, "H1"), (100, "H0")])
def test_it_errs_as_seldom_as_is_said(truth, wrong):
    """5 % of 150 trials, but for three standard errors."""
    first, second, _ = simulations.sprt_answers(truth, 100, 2, 150, 11)
    assert {"H0": first, "H1": second}[wrong] <= 0.05 + 3 * math.sqrt(0.05 * 0.95 / 150)


def test_points_and_shares_are_one_scale():
    assert share_of_elo(0) == 0.5
    assert share_of_elo(400) == pytest.approx(10 / 11)
    assert elo_of_share(share_of_elo(-123.0)) == pytest.approx(-123.0)
    assert (elo_of_share(1.0), elo_of_share(0.0)) == (math.inf, -math.inf)
