"""What notebooks show: a replay plays, an env shows its present."""

import base64

import cv2
import numpy as np
import pytest

import catch_arena
from catch_arena.render.view import GROUND


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
