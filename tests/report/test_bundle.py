"""A replay's bundle for web pages is small and always the same; test_bundle_in_javascript.py reads its contents."""

import base64
import gzip

from render.matches import played

from catch_arena.player.bundle import bundle_text, encode_bundle


def test_the_text_unpacks_to_the_bundle_and_is_the_same_at_any_time(monkeypatch):
    """Gzip writes the time of day into a file by default."""
    replay = played("duel", time_limit_s=1.0)
    text = bundle_text(replay)
    assert gzip.decompress(base64.b64decode(text)) == encode_bundle(replay)
    monkeypatch.setattr("time.time", lambda: 2e9)
    assert bundle_text(replay) == text


def test_a_minute_of_targets_that_flee_takes_less_than_four_times_that_of_still_ones():
    """In the page: packed, as text. What moves is told by the differences of its differences."""
    sizes = {}
    for motion in ("still", "flee"):
        sizes[motion] = len(bundle_text(played(target_motion=motion)))
    assert sizes["still"] < 16_000
    assert sizes["flee"] < 30_000
