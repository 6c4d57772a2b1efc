"""Text from strangers becomes text that every terminal, file and page can hold."""

import csv
import io
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from catch_arena.cli import terminal
from catch_arena.errors import reason
from catch_arena.text import (
    LONGEST_LINE,
    LONGEST_NAME,
    last_lines,
    name_fault,
    one_line,
    printable,
    printable_lines,
    shortened,
    spreadsheet_cell,
)

ANY = st.text(st.characters(codec=None, exclude_categories=()))
"""Surrogates, control characters and all."""


@given(ANY)
def test_any_text_becomes_printable_and_printable_text_stays(text):
    shown = printable(text)
    assert shown.isprintable()
    assert printable(shown) == shown
    assert (shown == text) == text.isprintable()
    assert len(one_line(text)) <= LONGEST_LINE
    assert one_line(text).isprintable()
    assert not [line for line in printable_lines(text).replace("\t", "").split("\n") if not line.isprintable()]
    assert printable_lines(text).count("\n") == text.count("\n")


@given(ANY)
def test_every_sink_takes_it(text):
    """A file in UTF-8, XML 1.0, a CSV file, a table on the terminal."""
    shown = printable_lines(text)
    assert shown.encode().decode() == shown
    case = ET.Element("case", name=printable(text))
    case.text = shown
    read = ET.fromstring(ET.tostring(case))  # noqa: S314 - ours
    assert (read.get("name"), read.text or "") == (printable(text), shown)
    file = io.StringIO()
    csv.writer(file).writerow([spreadsheet_cell(printable(text)), "x"])
    ((cell, _),) = csv.reader(io.StringIO(file.getvalue()))
    assert cell.removeprefix("'") == printable(text).removeprefix("'")
    assert not cell.startswith(("=", "+", "-", "@", "\t", "\r"))


@given(st.just("[red]x[/red] :smile:") | ANY)
def test_the_tables_of_the_terminal_show_it_as_it_stands(text):
    table = terminal.plain_table("name", text="name")
    table.add_row(printable(text))
    console = terminal.own_console()
    console.file, console.width = io.StringIO(), 10_000
    console.print(table)
    assert printable(text) in console.file.getvalue()


class LyingError(Exception):
    def __str__(self):
        raise ValueError


class Odd:
    def __repr__(self):
        raise ValueError


def test_what_cannot_even_be_written_is_named_by_its_kind():
    assert reason(LyingError()) == "LyingError: its message cannot be read"
    assert shortened(10**9999) == "<int>"
    deep = []
    for _ in range(100_000):
        deep = [deep]
    assert len(shortened(deep)) < 200
    assert "Odd" in shortened(Odd())
    assert shortened("\ud800\x1b") == r"'\ud800\x1b'"
    assert shortened({1: "a\nb"}) == r"{1: 'a\nb'}"


@given(ANY)
def test_a_name_is_printable_and_short_or_the_fault_says_so_in_one_line(text):
    fault = name_fault(text)
    assert (fault is None) == (text.isprintable() and 1 <= len(text) <= LONGEST_NAME)
    assert fault is None or fault.isprintable()


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@x"])
def test_what_begins_like_a_formula_is_text_to_a_spreadsheet(text):
    assert spreadsheet_cell(text) == f"'{text}"
    assert spreadsheet_cell(f"x{text}") == f"x{text}"


@pytest.mark.parametrize(
    ("log", "shown"),
    [
        ("", ""),
        ("\n \n", ""),
        ("one\n\ntwo\nthree\n\n", "two\nthree"),
        ("one\n" + "x" * 200, "one\n" + "x" * 200),
        ("one\n" + "x" * 201, "one\n" + "x" * 200 + " …"),
    ],
)
def test_the_last_lines_of_a_log_are_whole_unless_one_is_very_long(log, shown):
    assert last_lines(log, 2) == shown
