"""A replay's bundle for web pages is small and always the same; test_bundle_in_javascript.py reads its contents."""

import base64
import gzip

import catch_arena
from catch_arena.player import bundle_text
from catch_arena.player.bundle import encode_bundle


def test_the_text_unpacks_to_the_bundle_and_is_the_same_at_any_time(monkeypatch):
    """Gzip writes the time of day into a file by default."""
    env = catch_arena.parallel_env("duel", time_limit_s=1.0)
    env.record()
    env.reset(seed=1)
    replay = env.replay()
    text = bundle_text(replay)
    assert gzip.decompress(base64.b64decode(text)) == encode_bundle(replay)
    monkeypatch.setattr("time.time", lambda: 2e9)
    assert bundle_text(replay) == text


def test_a_minute_of_targets_that_flee_takes_less_than_four_times_that_of_still_ones():
    """In the page: packed, as text. What moves is told by the differences of its differences."""
    sizes = {}
    for motion in ("still", "flee"):
        env = catch_arena.parallel_env("standard", target_motion=motion)
        env.record()
        env.reset(seed=1)
        while env.agents:
            env.step(dict.fromkeys(env.agents, 1))
        sizes[motion] = len(bundle_text(env.replay()))
    assert sizes["still"] < 16_000
    assert sizes["flee"] < 30_000
