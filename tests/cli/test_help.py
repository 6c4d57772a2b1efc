"""The help shows what is typed, at any width."""

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from catch_arena.cli import main
from catch_arena.cli.app import GROUPS

ROOT = Path(__file__).parents[2]
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


def test_every_page_of_the_documentation_is_listed_and_printed():
    listed = CliRunner(env={"COLUMNS": "120"}).invoke(main, ["docs"]).output
    for path in (ROOT / "docs").glob("*.md"):
        assert re.search(rf"^ *{path.stem} ", listed, re.MULTILINE)
    page = (ROOT / "docs" / "grading.md").read_text()
    for name in ("grading", "docs/grading.md", "GRADING"):
        printed = CliRunner().invoke(main, ["docs", name])
        assert (printed.exit_code, printed.stdout) == (0, page)
    refused = CliRunner().invoke(main, ["docs", "gradign"])
    assert (refused.exit_code, refused.stderr) == (2, "error: unknown page 'gradign': did you mean grading?\n")


def test_what_users_read_names_pages_as_the_command_that_prints_them():
    """A user of the wheel has no folder docs/. Docstrings of modules and functions are for readers of the sources."""
    helps = "".join(help_of(words, 120) for words in [*COMMANDS, ["ros", "serve"], ["ros", "bag"], ["ros", "spawner"]])
    assert "docs/" not in helps
    sources = "".join(path.read_text() for path in (ROOT / "catch_arena").rglob("*.py"))
    named = set(re.findall(r"`catch-arena docs (\w+)`", sources))
    assert {"agents", "isolation", "grading", "ros2"} <= named
    assert not [name for name in named if not (ROOT / "docs" / f"{name}.md").is_file()]
