"""Tables that become lists where they do not fit."""

import io
import re
from math import nan
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console

from catch_arena.cli.fitted_table import FittedTable
from catch_arena.cli.tables import standings_table
from catch_arena.tournament.statistics.intervals import Estimate

WORDS = st.text("abcxyz019ß +-%", min_size=1, max_size=12).map(lambda text: " ".join(text.split()) or "x")


def printed(table: FittedTable, width: int) -> str:
    console = Console(file=io.StringIO(), width=width)
    console.print(table)
    return console.file.getvalue()


def letters(text: str) -> str:
    return re.sub(r"\s", "", text)


def standings_like(name: str) -> FittedTable:
    headings = ("#", "agent", "played", "rating", "score")
    table = FittedTable(*headings, folded="agent", named_by=2, caption="wins: ties shared")
    table.add_row("1", name, "160", "+378 ± 12", "18.7 ± 1.2")
    return table


@settings(max_examples=60, deadline=None)
@given(st.integers(2, 8), st.lists(st.lists(WORDS, min_size=8, max_size=8), min_size=1, max_size=4), st.data())
def test_nothing_is_cut_off_at_any_width(count, rows, data):
    """A cell of a table stands whole in one line, but for the column that may be folded; in a list all follow each
    other.
    """
    headings = [f"{name} of it" for name in "abcdefgh"[:count]]
    folded = data.draw(st.sampled_from(["", *headings]))
    table = FittedTable(*headings, folded=folded)
    for row in rows:
        table.add_row(*row[:count])
    width = data.draw(st.integers(20, 160))
    text = printed(table, width)
    assert max(map(len, text.splitlines())) <= width
    for row in rows:
        if "─" in text:
            whole = [cell for heading, cell in zip(headings, row, strict=False) if heading != folded]
            assert any(all(cell in line for cell in whole) for line in text.splitlines())
        else:
            told = ",".join(f"{heading}{cell}" for heading, cell in zip(headings[1:], row[1:], strict=False))
            assert letters(row[0] + told) in letters(text)


def test_a_table_that_fits_is_a_table():
    assert printed(standings_like("nearest"), 80).splitlines()[3].split() == [
        *("1", "nearest", "160", "+378", "±", "12", "18.7", "±", "1.2"),
    ]


def test_a_table_that_does_not_is_a_list_with_a_row_for_each_name():
    """A heading and its cell stay together, where a line holds them."""
    assert [line.rstrip() for line in printed(standings_like("nearest"), 30).splitlines()] == [
        "1  nearest",
        "  played 160,",
        "  rating +378 ± 12,",
        "  score 18.7 ± 1.2",
        "",
        "wins: ties shared",
    ]


@pytest.mark.parametrize("width", [60, 80])
def test_a_long_name_is_folded_before_the_table_becomes_a_list(width):
    name = "abcdefghij" * 14
    rows = printed(standings_like(name), width).rpartition("─")[2].partition("wins:")[0]
    assert "".join(re.findall("[a-j]+", rows)) == name


def test_a_rating_that_rounds_to_zero_has_no_minus():
    even = Estimate(0.5, nan, nan)
    line = SimpleNamespace(
        place=1,
        name="nearest",
        group="1",
        matches=2,
        forfeits={},
        lost_to_mates=0.0,
        contest_win_share=nan,
        rating=Estimate(-0.2, nan, nan),
        score=even,
        win_share=even,
    )
    assert " +0 ± ? " in printed(standings_table([line]), 80)
