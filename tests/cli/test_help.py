"""The help of every command is complete at any width of the terminal."""

import re
from inspect import cleandoc
from pathlib import Path

import pytest
from command_line import commands, run
from typer.main import get_command

from catch_arena.cli import main
from catch_arena.cli.app import GROUPS

ROOT = Path(__file__).parents[2]


def help_of(words, columns):
    result = run(*words, "--help", columns=columns)
    assert result.exit_code == 0, result.output
    return result.output


ALL = list(commands())


@pytest.mark.parametrize("columns", [40, 80, 120])
@pytest.mark.parametrize(("words", "command"), ALL, ids=[" ".join(words) for words, _ in ALL])
def test_the_help_of_a_command_cuts_no_word_off(words, command, columns):
    """Each option and its explanation stand there, with line breaks in them on a narrow terminal."""
    text = help_of(words, columns)
    assert max(map(len, text.splitlines())) <= max(50, min(80, columns))
    assert f"catch-arena {' '.join(words)} [OPTIONS]" in " ".join(text.split())
    letters = re.sub(r"\s", "", text)
    for parameter in command.params:
        assert re.sub(r"\s", "", parameter.help) in letters
        if parameter.param_type_name == "option":
            assert max(parameter.opts, key=len) in text
    assert "<bool>" not in text


@pytest.mark.parametrize("columns", [40, 80, 120])
def test_the_commands_stand_in_their_groups(columns):
    text = help_of([], columns)
    assert re.findall(r"^([A-Z][\w ]+):$", text, re.MULTILINE) == ["Options", *GROUPS]
    for name, command in get_command(main).commands.items():
        assert re.search(rf"^  {name} +\w", text, re.MULTILINE)
        assert " ".join(cleandoc(command.help).partition("\n\n")[0].split()) in " ".join(text.split())


def test_the_commands_of_a_group_are_listed_with_their_whole_sentences():
    lines = " ".join(help_of(["ros"], 80).split())
    for name, command in get_command(main).commands["ros"].commands.items():
        assert f" {name} {command.get_short_help_str(200)} " in f"{lines} "


def test_every_page_of_the_documentation_is_listed_and_printed():
    listed = run("docs", columns=120).output
    for path in (ROOT / "docs").rglob("*.md"):
        assert re.search(rf"^ *{path.stem} ", listed, re.MULTILINE)
    page = (ROOT / "docs" / "howto" / "grading.md").read_text()
    for name in ("grading", "howto/grading.md", "docs/howto/grading.md", "GRADING"):
        printed = run("docs", name)
        assert (printed.exit_code, printed.stdout) == (0, page)
    refused = run("docs", "gradign")
    assert (refused.exit_code, refused.stderr) == (2, "error: unknown page 'gradign': did you mean grading?\n")


def test_what_users_read_names_pages_as_the_command_that_prints_them():
    """A user of the wheel has no folder docs/. Docstrings of modules and functions are for readers of the sources."""
    helps = "".join(help_of(words, 120) for words in [["ros"], *(words for words, _ in ALL)])
    assert "docs/" not in helps
    sources = "".join(path.read_text() for path in (ROOT / "catch_arena").rglob("*.py"))
    named = set(re.findall(r"`catch-arena docs (\w+)`", sources))
    assert {"agents", "isolation", "grading", "ros2"} <= named
    assert not [name for name in named if not list((ROOT / "docs").rglob(f"{name}.md"))]
