"""A bundle holds what the replay holds, read back by a second implementation."""

import base64
import gzip
import json
import math

import pytest
from report.decoder import decoded

import catch_arena
from catch_arena.explanation import explain
from catch_arena.player import bundle_text
from catch_arena.player.bundle import GRID, TURN, encode_bundle
from catch_arena.render.match_info import MatchInfo


@pytest.fixture(scope="module")
def replay():
    """Six seeds of a crowd, until one has contests, a withdrawal among them."""
    env = catch_arena.parallel_env("crowd", time_limit_s=6.0)
    env.record([f"<b>{seat}</b>" for seat in range(16)], "a crowd")
    _, infos = env.reset(seed=5)
    step = 0
    while env.agents:
        if step == 30:
            env.withdraw("hunter_3")
        _, _, _, _, infos = env.step({agent: int(infos[agent]["action_mask"][1]) for agent in env.agents})
        step += 1
    return env.replay()


@pytest.fixture(scope="module")
def content(replay):
    """(facts, each body's x, y and theta)."""
    return decoded(encode_bundle(replay))


def test_everybody_is_where_it_was_within_a_part_of_the_grid(replay, content):
    facts, bodies = content
    targets = {number: (first, body) for (number, first, _), body in zip(facts["targets"], bodies[16:], strict=True)}
    for state, world in enumerate(replay.worlds()):
        pairs = [(hunter, body[:, state]) for hunter, body in zip(world.hunters, bodies, strict=False)]
        for target in world.targets:
            first, body = targets[target.number]
            pairs.append((target, body[:, state - first]))
        for one, (x, y, theta) in pairs:
            assert abs(one.x - x) <= 0.51 * facts["side"] / GRID
            assert abs(one.y - y) <= 0.51 * facts["side"] / GRID
            assert abs(math.remainder(one.theta - theta, 2 * math.pi)) <= 0.51 * 2 * math.pi / TURN
        shown = {number for number, first, length in facts["targets"] if first <= state < first + length}
        assert shown == {target.number for target in world.targets}


def test_every_ruling_is_told(replay, content):
    facts, _ = content
    rulings = [(state - 1, ruling) for state, world in enumerate(replay.worlds()) for ruling in world.rulings]
    assert len(rulings) > 20
    for told, (state, ruling) in zip(facts["rulings"], rulings, strict=True):
        number = None if ruling.target is None else int(str(ruling.target).removeprefix("target_turtle_"))
        assert told == [state, ruling.hunter, ruling.verdict.name, number]


def test_contests_are_those_that_explain_tells(replay, content):
    facts, _ = content
    contests = explain(replay).contests
    assert len(contests) >= 3
    assert [(one["state"] + 1, one["target"], one["clause"]) for one in facts["contests"]] == [
        (one.step, one.target, one.clause) for one in contests
    ]
    for told, one in zip(facts["contests"], contests, strict=True):
        assert told["claims"] == [[claim.seat, claim.verdict.name, claim.distance_um] for claim in one.claims]


def test_hunters_have_the_colours_and_the_names_of_the_videos(replay, content):
    facts, _ = content
    info = MatchInfo.of(replay.config)
    colors = [tuple(int(one["color"][at : at + 2], 16) for at in (1, 3, 5)) for one in facts["hunters"]]
    assert colors == [info.color(seat) for seat in range(16)]
    assert [one["name"] for one in facts["hunters"]] == list(replay.names)
    assert facts["withdrawals"] == [[30, 3]]


def test_the_text_unpacks_to_the_bundle_and_is_the_same_at_any_time(replay, monkeypatch):
    """Gzip writes the time of day into what it packs, unless it is told not to."""
    text = bundle_text(replay)
    assert gzip.decompress(base64.b64decode(text)) == encode_bundle(replay)
    monkeypatch.setattr("time.time", lambda: 2e9)
    assert bundle_text(replay) == text


def test_a_match_before_its_first_step_is_a_bundle_too():
    env = catch_arena.parallel_env("standard")
    env.record()
    env.reset(seed=1)
    facts = json.loads(encode_bundle(env.replay()).split(b"\n", 1)[0])
    assert (facts["steps"], facts["rulings"], len(facts["targets"])) == (0, [], 8)


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
    assert sizes["flee"] < 28_000


def test_dropouts_are_told_beside_withdrawals():
    """R1.7: with the step before which they left, and once each."""
    env = catch_arena.parallel_env("dropout", dropout_rate=0.02, time_limit_s=6.0)
    env.record()
    env.reset(seed=3)
    gone = {}
    while env.agents:
        step = env.world().step
        if step == 1:
            env.withdraw("hunter_2")
            gone[2] = 1
        env.step(dict.fromkeys(env.agents, 1))
        for seat, hunter in enumerate(env.world().hunters):
            if hunter.withdrawn:
                gone.setdefault(seat, step)
    facts = json.loads(encode_bundle(env.replay()).split(b"\n", 1)[0])
    assert {seat: step for step, seat in facts["withdrawals"]} == gone
    assert len(facts["withdrawals"]) == len(gone) > 1
