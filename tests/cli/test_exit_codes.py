"""Errors of usage have one style: an error line, a hint, and exit code 2."""

import re

import pytest
from command_line import commands, run

COMMANDS = [["ros"], *(words for words, _ in commands())]


@pytest.mark.parametrize("columns", [40, 100])
@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_a_wrong_option_of_any_command_is_an_error_and_a_hint(words, columns):
    result = run(*words, "--no-such-option", columns=columns)
    assert (result.exit_code, result.stdout) == (2, "")
    error, hint = result.stderr.splitlines()
    assert re.match(r"error: no such (option|command): --no-such-option", error)
    assert hint == f"hint: catch-arena {' '.join(words)} --help"


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["tournament"], "missing argument 'AGENT'"),
        (["grade", "x"], "missing option '--spec'"),
        (["tournament", "a", "--rounds", "abc"], "invalid value for '--rounds': "),
        (["tournament", "a", "--jobs", "1.5"], "invalid value for '--jobs' / '-j': "),
        (["tournament", "a", "--format", "x"], "invalid value for '--format': 'x' is not one of 'round-robin', "),
        (["tournament", "a", "--secnario", "duel"], "no such option: --secnario"),
        (["tornament"], "no such command 'tornament'. Did you mean 'tournament'?"),
        (["render", "a", "--speed", "fast"], "invalid value for '--speed': "),
        (["highlights", "a", "--count", "0"], "invalid value for '--count': "),
        (["match", "a", "--output"], "option '--output' requires an argument"),
        (["diff", "a", "b", "c\x1b[2J"], r"got unexpected extra argument(s) (c\x1b[2J)"),
    ],
)
def test_wrong_usage_names_the_option_in_one_line(words, error):
    result = run(*words)
    assert (result.exit_code, result.stdout) == (2, "")
    first, *hint = result.stderr.splitlines()
    assert first.startswith(f"error: {error}")
    assert all(re.fullmatch(r"hint: catch-arena( \w+)? --help", line) for line in hint)


def test_a_command_without_any_word_shows_the_help():
    for words in ([], ["ros"]):
        for columns in (40, 100):
            result = run(*words, columns=columns)
            assert (result.exit_code, result.stderr) == (2, "")
            assert "Usage: catch-arena" in result.stdout
