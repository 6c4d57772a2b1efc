"""The demo replaces only files that it has made."""

import runpy
from pathlib import Path

import pytest

DEMO = runpy.run_path(str(Path(__file__).parents[2] / "scripts" / "demo.py"), run_name="loaded")


def test_what_an_earlier_demo_left_goes(tmp_path):
    out = tmp_path / "out" / "demo"
    for _ in range(2):
        DEMO["make_anew"](out)
        assert [path.name for path in out.iterdir()] == ["demo.began"]
        (out / "replays").mkdir()


@pytest.mark.parametrize("content", ["a file", "a tournament"])
def test_what_the_demo_did_not_make_stays(tmp_path, content):
    out = tmp_path / "mine"
    precious = out
    if content == "a tournament":
        out.mkdir()
        precious = out / "tournament.sqlite"
    precious.write_text("mine")
    with pytest.raises(SystemExit, match=f"{out} was not made by the demo, and is left as it is"):
        DEMO["demo"](out)
    assert precious.read_text() == "mine"
