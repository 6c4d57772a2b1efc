"""One figure over many scenarios: against rliable's own outputs, and against a second implementation."""

import json
import math
from itertools import product
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from catch_arena.tournament.statistics.aggregates import (
    FEWEST_RUNS,
    interquartile_estimate,
    interquartile_gap,
    interquartile_mean,
    performance_profile,
    probability_of_improvement,
)

RLIABLE = json.loads((Path(__file__).parents[2] / "data" / "rliable.json").read_text())
X, Y = np.array(RLIABLE["x"]), np.array(RLIABLE["y"])
NEAR = 0.006
"""Two bootstraps draw differently."""

SCORES = st.integers(1, 6).flatmap(
    lambda scenarios: st.lists(
        st.lists(st.sampled_from([0.0, 0.25, 0.3, 0.5, 0.9, 1.0]), min_size=scenarios, max_size=scenarios),
        min_size=1,
        max_size=7,
    )
)


def test_means_are_those_of_rliable():
    for name, scores in (("x", X), ("y", Y), ("x_odd", X[:7, :5])):
        assert interquartile_mean(scores) == pytest.approx(RLIABLE["iqm"][name], abs=1e-12)
    known = RLIABLE["probability_of_improvement"]
    assert probability_of_improvement(X, Y).mean == pytest.approx(known["x_over_y"], abs=1e-12)
    assert probability_of_improvement(Y, X).mean == pytest.approx(known["y_over_x"], abs=1e-12)
    profile = performance_profile(X, np.array(RLIABLE["profile"]["taus"]))
    assert [one.mean for one in profile] == pytest.approx(RLIABLE["profile"]["x"], abs=1e-12)


def test_intervals_are_those_of_rliable():
    for name, scores in (("x", X), ("y", Y)):
        found = interquartile_estimate(scores)
        assert (found.low, found.high) == pytest.approx(RLIABLE["iqm_95"][name], abs=NEAR)
    found = probability_of_improvement(X, Y)
    assert (found.low, found.high) == pytest.approx(RLIABLE["probability_of_improvement_95"], abs=NEAR)
    for side in ("low", "high"):
        profile = [getattr(one, side) for one in performance_profile(X, np.array(RLIABLE["profile"]["taus"]))]
        assert profile == pytest.approx(RLIABLE["profile"][side], abs=1 / X.size + 1e-9)


def second_iqm(rows):
    values = sorted(value for row in rows for value in row)
    cut = len(values) // 4
    middle = values[cut : len(values) - cut]
    return sum(middle) / len(middle)


def second_improvement(rows, others):
    scenarios = range(len(rows[0]))
    shares = [
        sum(1.0 if one[s] > other[s] else 0.5 if one[s] == other[s] else 0.0 for one, other in product(rows, others))
        / (len(rows) * len(others))
        for s in scenarios
    ]
    return sum(shares) / len(shares)


@settings(max_examples=30)
@given(SCORES, st.data())
def test_means_are_those_of_the_definitions(rows, data):
    assert interquartile_mean(np.array(rows)) == pytest.approx(second_iqm(rows))
    others = data.draw(st.lists(st.sampled_from(rows), min_size=1, max_size=5))
    assert probability_of_improvement(np.array(rows), np.array(others)).mean == pytest.approx(
        second_improvement(rows, others)
    )


def test_the_bootstrap_draws_the_runs_of_each_scenario_by_itself():
    """A second one, in plain Python, of a table whose scenarios lie far apart."""
    rows = [[draw.random() + 10 * scenario for scenario in range(3)] for draw in map(Random, range(6))]
    draw, found = Random(1), []
    for _ in range(4000):
        columns = [[draw.choice(column) for _ in column] for column in zip(*rows, strict=True)]
        found.append(second_iqm(columns))
    found.sort()
    estimate = interquartile_estimate(np.array(rows))
    width = found[3900] - found[100]
    assert estimate.low == pytest.approx(found[100], abs=0.1 * width)
    assert estimate.high == pytest.approx(found[3900], abs=0.1 * width)


def test_the_gap_of_a_table_to_itself_is_0_within_its_interval():
    gap = interquartile_gap(X, X)
    assert gap.mean == 0
    assert gap.low < 0 < gap.high
    alone = interquartile_estimate(X)
    assert gap.high - gap.low > alone.high - alone.low  # both are drawn, and independently


def test_with_few_runs_there_is_a_mean_and_no_interval():
    few = X[: FEWEST_RUNS - 1]
    assert not math.isnan(interquartile_estimate(few).mean)
    assert math.isnan(interquartile_estimate(few).low)
    assert math.isnan(probability_of_improvement(X, few).high)
    assert math.isnan(interquartile_gap(few, X).low)


def test_a_figure_repeats_to_the_last_bit():
    assert interquartile_estimate(X) == interquartile_estimate(X.copy())
    assert probability_of_improvement(X, Y) == probability_of_improvement(X.copy(), Y.copy())
