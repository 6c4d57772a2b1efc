"""The demo: its output, and the files that it leaves alone."""

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


def test_files_of_an_earlier_demo_are_removed(tmp_path):
    out = tmp_path / "out" / "demo"
    for _ in range(2):
        DEMO["make_folder"](out)
        assert [path.name for path in out.iterdir()] == ["demo.began"]
        (out / "replays").mkdir()


@pytest.mark.parametrize("content", ["a file", "a tournament"])
def test_other_folders_stay(tmp_path, content):
    out = tmp_path / "mine"
    precious = out
    if content == "a tournament":
        out.mkdir()
        precious = out / "tournament.sqlite"
    precious.write_text("mine")
    with pytest.raises(SystemExit, match=f"{out} was not made by the demo, and stays as it is"):
        DEMO["demo"](out)
    assert precious.read_text() == "mine"


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(SystemExit, match=f"{tmp_path}/file/out: Not a directory"):
        DEMO["make_folder"](tmp_path / "file" / "out")
