"""Charts of the report have round axes, and its heading claims no more than is known."""

import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from report.synthetic import tournament

from catch_arena.report.charts import (
    Axis,
    headline,
    headline_of_sides,
    interval,
    number,
    percent,
    rating_axis,
)
from catch_arena.report.data import ReportData
from catch_arena.tournament.statistics.intervals import Estimate

NAN = math.nan


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    folder = tmp_path_factory.mktemp("synthetic")
    tournament(folder, 2, forfeits=True)
    return ReportData.of(folder)


@pytest.mark.parametrize("value", [182.63109783843828, 1e-3, 1e6])
def test_values_that_differ_by_rounding_are_equal_on_an_axis(value):
    """As ratings of agents that all forfeited."""
    low, high = value, math.nextafter(value, math.inf)
    axis = Axis.over([low, high])
    assert axis.high - axis.low == 1.0
    assert axis.at(low) == axis.at(high)


@given(st.lists(st.floats(-1e6, 1e6).map(lambda value: round(value, 6)), max_size=8))
def test_an_axis_holds_all_values_between_round_ends(values):
    axis = Axis.over([*values, NAN])
    assert axis.low < axis.high
    assert 2 <= len(axis.ticks) <= 8
    assert all(axis.low - 1e-6 <= value <= axis.high + 1e-6 for value in values)
    assert [axis.at(axis.low), axis.at(axis.high)] == [0.0, 100.0]


def test_an_interval_that_is_not_known_is_a_point():
    axis = Axis.over([0.0, 10.0])
    assert axis.whisker(Estimate(5.0, NAN, NAN)) == {"left": 50.0, "width": 0.0, "mean": 50.0}
    assert axis.whisker(Estimate(5.0, 2.0, 8.0)) == {"left": 20.0, "width": 60.0, "mean": 50.0}
    assert axis.whisker(Estimate(NAN, NAN, NAN)) is None


def test_one_that_forfeited_everything_does_not_squeeze_the_others_together(data):
    first, second, third = (
        dataclasses.replace(line, rating=Estimate(mean, mean - 50, mean + 50), forfeits={"FORFEIT_CRASH": lost})
        for line, mean, lost in zip(
            data.standings, (200.0, 0.0, -2000.0), (0, 1, data.standings[2].matches), strict=False
        )
    )
    assert rating_axis([first, second, third]).low == rating_axis([first, second]).low > -200
    assert rating_axis([third]).low < -2000  # but where there is nobody else


@pytest.mark.parametrize(
    ("groups", "ended", "expected"),
    [
        ([(1, 1), (2, 2)], True, "a comes first"),
        ([(1, 1), (2, 2)], False, "a leads so far"),
        ([(1, 1), (1, 2), (2, 2)], True, "a and b lead without a significant difference"),
        ([(1, 1), (1, 1)], True, "No difference between the agents is significant yet"),
        ([(1, 1), (1, 1), (1, 1), (1, 1), (2, 2)], True, "a leads, but 3 others do not differ significantly"),
        ([(1, 1)], True, "a played alone"),
    ],
)
def test_the_heading_says_no_more_than_is_known(data, groups, ended, expected):
    assert headline(_table(data, groups), ended=ended) == expected


def test_the_heading_of_two_sides_leaves_names_as_they_are(data):
    ann, both = _table(data, [(1, 1), (2, 2)]), _table(data, [(1, 1), (1, 1)])
    ann = [dataclasses.replace(ann[0], name="Ann"), ann[1]]
    assert headline_of_sides({"hunter": ann, "prey": ann}, ended=True) == "Ann comes first"
    assert headline_of_sides({"hunter": ann, "prey": both}, ended=True) == (
        "As hunter: Ann comes first; as prey: No difference between the agents is significant yet"
    )


def test_numbers_for_people():
    assert [number(1234567.0), number(1234.0), number(-0.004, 2), number(-3.5, 1), number(NAN)] == [
        "1\u202f234\u202f567",
        "1234",
        "0.00",
        "−3.5",
        "–",
    ]
    assert [percent(0.126), percent(NAN)] == ["13 %", "–"]
    assert interval(Estimate(0.5, -0.02, 0.6), 100) == "−2 to 60"
    assert interval(Estimate(0.5, NAN, NAN)) == "interval unknown"


def _table(data, groups):
    line = data.standings[0]
    return [
        dataclasses.replace(line, name=name, groups=belongs) for name, belongs in zip("abcdefgh", groups, strict=False)
    ]
