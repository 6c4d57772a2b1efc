"""Aggregate figures over many scenarios equal those of rliable."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from catch_arena.suite.aggregates import (
    FEWEST_RUNS,
    interquartile_estimate,
    interquartile_gap,
    interquartile_mean,
    performance_profile,
    probability_of_improvement,
)

RLIABLE = json.loads((Path(__file__).parents[1] / "data" / "rliable.json").read_text())
X, Y = np.array(RLIABLE["x"]), np.array(RLIABLE["y"])
NEAR = 0.006
"""Two bootstraps draw differently."""


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
