"""A replay plays in a notebook, and an env shows its present state."""

import base64
import subprocess
import sys

import cv2
import numpy as np
import pytest

import catch_arena
from catch_arena.render.viewport import GROUND


def test_a_replay_is_the_reports_player(match):
    html = match._repr_html_()
    assert "<catch-replay" in html
    assert len(html) < 200_000


def test_a_replay_that_does_not_play_as_recorded_says_so_and_its_names_are_no_markup(play):
    broken = play("duel", time_limit_s=1.0, names=("<b>ann</b>", "bob"))
    broken.digests[3] = b"12345678"
    html = broken._repr_html_()
    assert "does not play as it was recorded" in html
    assert "<b>" not in html


@pytest.mark.parametrize(
    "get",
    [
        "import catch_arena; replay = catch_arena.Replay.load(sys.argv[1])",
        "from catch_arena import Replay; replay = Replay.load(sys.argv[1])",
        "import catch_arena; env = catch_arena.parallel_env('duel'); env.record(); env.reset(); replay = env.replay()",
    ],
)
def test_a_replay_plays_in_a_notebook_that_imports_nothing_else(play, tmp_path, get):
    play("duel", time_limit_s=1.0).save(tmp_path / "match.replay")
    code = f"import sys; {get}; sys.exit('<catch-replay' not in replay._repr_html_())"
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "match.replay")], check=True)


def test_a_replay_without_the_player_says_what_it_needs(tmp_path, play):
    play("duel", time_limit_s=1.0).save(tmp_path / "match.replay")
    code = (
        "import sys; from catch_arena.replay import Replay; shown = Replay.load(sys.argv[1])._repr_html_(); "
        "assert 'catch_arena.player' not in sys.modules; print(shown)"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "match.replay")]
    shown = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert shown == "<p>A replay of 10 steps; it plays here after <code>import catch_arena.player</code></p>\n"


@pytest.mark.parametrize("make", [catch_arena.parallel_env, catch_arena.env])
def test_an_env_shows_its_present(make):
    env = make("duel")
    assert "no episode has begun" in env._repr_html_()
    env.reset(seed=1)
    head, _, data = env._repr_html_().partition("base64,")
    assert 'alt="Catch Arena, step 0, 0.0 s"' in head
    picture = cv2.imdecode(np.frombuffer(base64.b64decode(data.partition('"')[0]), np.uint8), cv2.IMREAD_COLOR_RGB)
    assert picture.shape == (450, 800, 3)
    assert (np.abs(picture[:, :450].astype(int) - GROUND).max(axis=2) < 10).mean() > 0.5


def test_an_env_that_records_plays_what_was_played():
    env = catch_arena.parallel_env("duel")
    env.record()
    env.reset(seed=1)
    assert "<img" in env._repr_html_()
    env.step(dict.fromkeys(env.agents, 1))
    assert "<catch-replay" in env._repr_html_()
