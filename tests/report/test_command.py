"""`catch-arena report`, as people type it."""

import re
import signal
import subprocess
import sys
import urllib.request

import pytest
from report.synthetic import tournament
from typer.testing import CliRunner

from catch_arena.cli import main


def test_a_report_is_written_beside_its_tournament(tmp_path):
    tournament(tmp_path, 1)
    done = CliRunner().invoke(main, ["report", str(tmp_path)])
    assert (done.exit_code, done.output) == (0, f"report: {tmp_path / 'report.html'}\n")
    assert (tmp_path / "report.html").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--budget", "-1"], "--budget must be from 0 to 1000 MB, got -1"),
        (["--budget", "nan"], "--budget must be from 0 to 1000 MB, got nan"),
        (["--port", "80"], "--port must come with --watch"),
        (["--watch", "--match", "x"], "--budget and --match must be left out with --watch"),
        (["--match", "x"], "match x: must be one that was played and recorded"),
        (["--watch", "--port", "70000"], "port must be from 0 to 65535, got 70000"),
    ],
)
def test_wrong_words_are_told_in_one_line(tmp_path, words, said):
    tournament(tmp_path, 1, most=4)
    done = CliRunner().invoke(main, ["report", str(tmp_path), *words])
    assert done.exit_code == 2
    assert said in done.output
    assert done.output.count("\n") == 1


def test_a_folder_without_a_tournament_is_told_in_one_line(tmp_path):
    for words in ([], ["--watch"]):
        done = CliRunner().invoke(main, ["report", str(tmp_path), *words])
        assert done.exit_code == 2
        assert "holds no tournament" in done.output


def test_a_watched_report_is_served_until_ctrl_c(tmp_path):
    tournament(tmp_path, 1)
    command = [sys.executable, "-c", "from catch_arena.cli import main; main()"]
    with subprocess.Popen([*command, "report", str(tmp_path), "--watch"], stdout=subprocess.PIPE, text=True) as process:
        address = re.search(r"http://127\.0\.0\.1:\d+/", process.stdout.readline()).group()
        with urllib.request.urlopen(f"{address}state", timeout=30) as answer:  # noqa: S310 - ours
            assert answer.read() == b"60"
        process.send_signal(signal.SIGINT)
        try:
            assert process.wait(timeout=60) == 0
        finally:
            process.kill()
