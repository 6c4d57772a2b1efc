"""The help shows what is typed, at any width."""

import re

import pytest
from typer.testing import CliRunner

from catch_arena.cli import main
from catch_arena.cli.app import GROUPS

COMMANDS = [[name] for names in GROUPS.values() for name in names]


def help_of(words, columns):
    told = CliRunner().invoke(main, [*words, "--help"], env={"COLUMNS": str(columns)})
    assert told.exit_code == 0, told.output
    return told.output


@pytest.mark.parametrize("columns", [40, 80, 120])
def test_a_flag_shows_no_value_and_an_argument_is_written_as_it_is_typed(columns):
    text = " ".join(help_of(["tournament"], columns).split())
    assert "catch-arena tournament [OPTIONS] AGENT... " in text
    assert "<bool>" not in text
    assert "list[" not in text


@pytest.mark.parametrize("columns", [40, 80, 120])
def test_the_commands_stand_in_their_groups(columns):
    text = help_of([], columns)
    headings = re.findall(r"^(?:╭─ )?([A-Z][\w ]+?)(?: ─+╮|:)$", text, re.MULTILINE)
    assert headings == ["Options", *GROUPS]


def test_explanations_have_half_of_a_usual_terminal():
    for words in COMMANDS:
        (before,) = re.findall(r"^│.* --help .*(?=Show this)", help_of(words, 80), re.MULTILINE)
        assert len(before) <= 45, words
