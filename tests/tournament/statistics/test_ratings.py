"""Ratings equal hand-computed cases and SciPy's, and recover the strengths of simulated agents."""

import math

import numpy as np
import pytest
import simulated_tournaments as simulations

from catch_arena.tournament.statistics.intervals import ratios
from catch_arena.tournament.statistics.outcomes import Outcomes
from catch_arena.tournament.statistics.ratings import ELO, fit, rate


def outcomes(entrants, *matches):
    """Each match: its block, its seating, its ranks."""
    block, seating, ranks = (np.array(part) for part in zip(*matches, strict=True))
    return Outcomes(entrants, block, seating, 10 - ranks, ranks)


def test_davidsons_estimate_for_two_by_hand():
    """60 wins, 30 ties, 10 defeats: strengths as 6 to 1, and v = 30 / sqrt(60 * 10). Against so many matches the
    imagined games count for nothing.
    """
    wins, ties = np.array([[0, 60], [10, 0]]) * 1e9, np.array([[0, 30], [30, 0]]) * 1e9
    strengths, log_tie, _ = fit(wins, ties)
    assert strengths[0] - strengths[1] == pytest.approx(math.log(6))
    assert math.exp(log_tie) == pytest.approx(30 / math.sqrt(600))


def test_the_fit_is_the_most_likely_one():
    """One of three never lost to another; the numbers are those of SciPy's minimiser on docs/explanation/ratings.md."""
    wins, ties = np.array([[0, 7, 12], [3, 0, 9], [0, 4, 0]]), np.array([[0, 2, 0], [2, 0, 5], [0, 5, 0]])
    strengths, log_tie, _ = fit(wins.astype(float), ties.astype(float))
    assert [*strengths, log_tie] == pytest.approx([1.407047, -0.112547, -1.237868, -0.547447], abs=1e-5)


def test_an_entrant_that_never_lost_has_the_rating_and_the_margin_that_the_imagined_games_leave_it():
    """Twenty blocks that are all alike tell nothing of how much blocks vary: the standard error is that of the imagined
    games, which count as whole ones, and Student's t has 19 degrees of freedom. The numbers are SciPy's again.
    """
    first, second = rate(outcomes(2, *((block, (0, 1), (1, 2)) for block in range(20)))).estimates()
    assert (first.mean, second.mean) == pytest.approx((395.786, -395.786), abs=0.01)
    assert (first.margin, second.margin) == pytest.approx((450.392, 450.392), abs=0.01)


def test_ratings_have_mean_zero_over_those_who_played():
    ratings = rate(outcomes(4, (0, (0, 1, 3), (1, 2, 3)), (1, (1, 0, 3), (1, 1, 3))))
    assert math.isnan(ratings.points[2])
    assert np.nansum(ratings.points) == pytest.approx(0.0)
    assert ratings.points[0] > ratings.points[1] > ratings.points[3]
    assert math.isnan(ratings.estimates()[2].low)


def test_an_entrant_of_one_block_has_no_interval_however_many_there_are():
    matches = [(block, (0, 1), (1 + block % 2, 2 - block % 2)) for block in range(40)]
    first, _, third = rate(outcomes(3, *matches, (40, (0, 2), (1, 2)))).estimates()
    assert math.isnan(third.low)
    assert 150 < first.margin < 350


def test_many_matches_find_the_true_strengths():
    world = simulations.plackett_luce(5, 1.5)
    ratings = rate(simulations.simulated(world, simulations.Design(5, 4, 2000), np.random.default_rng(1)))
    np.testing.assert_allclose(ratings.points, np.linspace(-1.5, 1.5, 5) * ELO, atol=6)


@pytest.mark.parametrize(
    ("world", "seats"), [(simulations.plackett_luce(5, 1.0), 4), (simulations.catches(5, 8.0, 16.0), 3)]
)
def test_the_intervals_hold_the_truth_as_often_as_they_say(world, seats):
    """Intervals of 95 %, in 150 tournaments of five agents."""
    assert 0.925 <= simulations.coverage(world, simulations.Design(5, seats, 4), 150, 7) <= 0.98


def test_very_many_blocks_are_drawn_by_the_bag_and_give_the_same_interval():
    random = np.random.default_rng(0)
    sums = random.normal(size=(9000, 1))
    (found,) = ratios(sums, np.ones_like(sums))
    assert found.margin == pytest.approx(1.96 * sums.std() / math.sqrt(9000), rel=0.03)
