"""The page of a student in a real browser: its worst moment plays, and it fits a telephone."""

import pytest
from browser.waiting import until
from command_line import run
from tournament.agents import source

SPEC = """
title = "Exercise 1"
seed = 1
[[test]]
name = "against the nearest"
scenario = "duel"
settings = { time_limit_s = 20 }
opponents = ["nearest"]
matches = 2
min_win_share = 1
"""


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("class")
    (folder / "class").mkdir()
    (folder / "class" / "ann.py").write_text(source("if self.step == 90: raise ValueError('enough')\nreturn 1"))
    (folder / "class" / "ben.py").write_text("import torch\n")
    (folder / "spec.toml").write_text(SPEC)
    words = ["grade", folder / "class", "--spec", folder / "spec.toml", "--out", folder / "out", "--jobs", "1"]
    done = run(*words)
    assert done.exit_code == 0, done.output
    return folder / "out" / "pages"


def test_the_worst_moment_is_shown_and_plays(page, pages):
    """The page shows the crash in step 90 with the student's hunter; the button plays from two seconds before."""
    page.goto((pages / "ann.html").as_uri())
    until(page, "document.getElementById('player').time === 8900")
    shown = page.evaluate("(({ replay, picked }) => replay.hunters[picked].label)(document.getElementById('player'))")
    assert shown == "ann"
    begun = page.evaluate(
        "(player => (document.querySelector('[data-plays]').click(), [player.playing, player.time]))"
        "(document.getElementById('player'))"
    )
    assert begun == [True, 6900]


@pytest.mark.parametrize("name", ["ann", "ben"])
def test_it_fits_a_telephone_and_loads_nothing(page, pages, name):
    page.set_viewport_size({"width": 390, "height": 844})
    asked, refused = [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("console", lambda message: refused.append(message.text))
    page.goto((pages / f"{name}.html").as_uri())
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    assert page.get_by_text("0 of 1 points").count()
    assert (asked[1:], refused) == ([], [])


def test_it_prints_without_the_player(page, pages):
    page.goto((pages / "ann.html").as_uri())
    page.emulate_media(media="print")
    assert not page.locator("catch-replay").is_visible()
    assert page.get_by_text("FORFEIT_CRASH in step 90").first.is_visible()
