"""The demo: its output, and a folder that it leaves alone."""

import runpy
from pathlib import Path

import pytest

DEMO = runpy.run_path(str(Path(__file__).parents[2] / "scripts" / "demo.py"), run_name="loaded")


def test_a_command_that_fails_ends_the_demo(capfd):
    with pytest.raises(SystemExit) as ended:
        DEMO["run"]("match", "nobody")
    assert ended.value.code != 0
    printed = capfd.readouterr()
    assert printed.out == "\n$ catch-arena match nobody\n"
    assert "nobody" in printed.err


def test_a_tournament_that_is_kept_in_the_folder_stays(tmp_path, capfd):
    (kept := tmp_path / "tournament.sqlite").write_text("mine")
    with pytest.raises(SystemExit):
        DEMO["demo"](tmp_path)
    assert kept.read_text() == "mine"
    assert str(kept) in capfd.readouterr().err
