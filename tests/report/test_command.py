"""`catch-arena report` refuses wrong words in one line, and serves a page until Ctrl-C; tests/cli has its files."""

import re
import urllib.request

import pytest
from command_line import run
from interrupts.commands import Command
from report.synthetic import tournament


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["--budget", "-1"], "--budget must be from 0 to 1000 MB, got -1"),
        (["--budget", "nan"], "--budget must be from 0 to 1000 MB, got nan"),
        (["--watch", "--match", "x"], "--budget, --match and --output must be left out with --watch"),
        (["--match", "x"], "match x: cannot be shown; it must be a match that was played and recorded"),
    ],
)
def test_wrong_words_are_told_in_one_line(tmp_path, words, error):
    tournament(tmp_path, 1, most=4)
    done = run("report", str(tmp_path), *words)
    assert done.exit_code == 2
    assert error in done.output
    assert done.output.count("\n") == 1


def test_a_folder_without_a_tournament_is_told_in_one_line(tmp_path):
    for words in ([], ["--watch"]):
        done = run("report", str(tmp_path), *words)
        assert done.exit_code == 2
        assert "holds no tournament" in done.output


def fetched(address: str) -> str:
    with urllib.request.urlopen(address, timeout=60) as answer:  # noqa: S310 - ours
        return answer.read().decode()


def test_a_watched_report_is_served_until_ctrl_c(tmp_path):
    tournament(tmp_path, 1)
    command = Command(tmp_path, ["report", ".", "--watch"])
    address = re.search(r"http://127\.0\.0\.1:\d+/", command.process.stdout.readline()).group()
    assert fetched(f"{address}state") == "60 ended"
    command.interrupt()
    ended = command.ended()
    assert (ended.status, ended.errors) == (0, "")


def test_a_tournament_that_was_watched_is_served_until_ctrl_c(tmp_path):
    """All is written by then, and nothing was broken off."""
    words = [
        "tournament",
        "nearest",
        "idle",
        "-s",
        "duel",
        "--set",
        "time_limit_s=3",
        "--rounds",
        "1",
        "--jobs",
        "1",
        "--out",
        "o",
    ]
    command = Command(tmp_path, [*words, "--watch"])
    lines = iter(command.process.stdout.readline, "")
    address = next(line for line in lines if line.startswith("watch: ")).split()[1]
    assert f"the report is served at {address} until Ctrl-C\n" in lines
    assert (tmp_path / "o" / "report.html").is_file()
    assert "of 2 matches" in fetched(address)
    assert fetched(f"{address}state") == "2 ended"
    command.interrupt()
    ended = command.ended()
    assert (ended.status, ended.output, ended.errors, ended.left) == (0, "", "", [])
    assert not list(tmp_path.glob("o/*-wal"))
