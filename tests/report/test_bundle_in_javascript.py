"""The player's own decoder reads what Python wrote, number by number, and refuses what is no bundle with one line."""

import base64
import copy
import gzip
import json
from pathlib import Path

import numpy as np
import pytest
from report.decoder import decoded
from report.javascript import deno

import catch_arena
from catch_arena.explanation import explain
from catch_arena.player import bundle_text, packed_text
from catch_arena.player.bundle import encode_bundle
from catch_arena.player.element import element_script
from catch_arena.render.match_info import MatchInfo
from catch_arena.replay import Replay

READER = Path(__file__).with_name("read_bundles.js")
SCENARIOS = tuple(catch_arena.SCENARIOS)
WITHDRAWN_AT = 17


def read(texts):
    """What the player reads from each of these bundles; or `kind` and `error`, where it reads nothing."""
    found = json.loads(deno("run", "--no-remote", READER, given=json.dumps(texts)))
    assert len(found) == len(texts)
    return found


def refused(text):
    """The line that it is refused with."""
    (found,) = read([text])
    return found["error"]


def chase(env, infos):
    """Hunters go for the nearest target, and prey drives in circles."""
    prey = [0.5, 0.3]
    return {agent: prey if "prey" in agent else int(infos[agent]["action_mask"][1]) for agent in env.agents}


@pytest.fixture(scope="module")
def replays(tmp_path_factory):
    """A match of each scenario, by its name: saved and loaded again. Somebody withdraws from one."""
    folder = tmp_path_factory.mktemp("replays")
    for scenario in SCENARIOS:
        changes = {"dropout_rate": 0.02} if scenario == "dropout" else {}
        env = catch_arena.parallel_env(scenario, time_limit_s=8.0, control="target", **changes)
        env.record(title=f"«{scenario}» in U+1F422 \N{TURTLE}")
        _, infos = env.reset(seed=5)
        for step in range(10**6):
            if not env.agents:
                break
            if scenario == "crowd" and step == WITHDRAWN_AT:
                env.withdraw("hunter_3")
            if scenario == "herd" and step == WITHDRAWN_AT:
                env.withdraw("prey_1")
            _, _, _, _, infos = env.step(chase(env, infos))
        env.replay().save(folder / f"{scenario}.replay")
    return {scenario: Replay.load(folder / f"{scenario}.replay") for scenario in SCENARIOS}


@pytest.fixture(scope="module")
def bundles(replays):
    """By scenario: (what the player reads, the replay)."""
    found = read([bundle_text(replay) for replay in replays.values()])
    return {scenario: (one, replays[scenario]) for scenario, one in zip(SCENARIOS, found, strict=True)}


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_every_number_of_a_bundle_is_the_one_that_python_decodes(bundles, scenario):
    shown, replay = bundles[scenario]
    facts, bodies = decoded(encode_bundle(replay))
    names = ("title", "seed", "side", "period", "steps", "view", "hunters", "teams", "prey", "targets", "withdrawals")
    for name in names:
        assert shown[name] == facts[name], name
    assert shown["rulings"] == [
        {"time": state * facts["period"], "seat": seat, "verdict": verdict, "target": number}
        for state, seat, verdict, number in facts["rulings"]
    ]
    assert len(shown["tracks"]) == len(bodies) > 0
    for tracks, body in zip(shown["tracks"], bodies, strict=True):
        assert np.array_equal(np.array(tracks), body.astype(np.float32))


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_half_a_state_later_everybody_is_half_way_to_the_next(bundles, scenario):
    shown, replay = bundles[scenario]
    _, bodies = decoded(encode_bundle(replay))
    firsts = [0] * len(shown["hunters"]) + [first for _, first, _ in shown["targets"]]
    for state, there in enumerate(shown["states"]):
        for pose, first, body in zip(there["later"], firsts, bodies, strict=True):
            states = np.arange(first, first + body.shape[1])
            expected = [np.interp(state + 0.5, states, column) for column in body]
            assert [pose["x"], pose["y"], pose["theta"]] == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_targets_scores_and_withdrawals_are_those_of_the_match_in_every_state(bundles, scenario):
    shown, replay = bundles[scenario]
    for there, world in zip(shown["states"], replay.worlds(), strict=True):
        assert set(there["alive"]) == {target.number for target in world.targets}
        assert there["scores"] == [hunter.score for hunter in world.hunters]
        assert there["teamScores"] == (list(world.team_scores) if replay.config.teams else [])
        assert there["hunted"] == [{"caught": one.times_caught, "out": one.target is None} for one in world.prey]
    withdrawn = [[agent for agent, gone in enumerate(there["withdrawn"]) if gone] for there in shown["states"]]
    gone = [
        [agent for agent, one in enumerate((*world.hunters, *world.prey)) if one.withdrawn] for world in replay.worlds()
    ]
    assert withdrawn == [*gone[1:], gone[-1]]  # from the beginning of the step in which it takes no part
    if scenario == "crowd":
        assert withdrawn == [[]] * WITHDRAWN_AT + [[3]] * (len(withdrawn) - WITHDRAWN_AT)
    assert any(withdrawn) == (scenario in {"crowd", "dropout", "herd"})


def test_prey_is_caught_and_returns_in_the_matches_that_are_read(bundles):
    """Else the numbers above would prove little."""
    for scenario in ("tag", "herd"):
        shown, _ = bundles[scenario]
        assert any(len(one["targets"]) > 1 for one in shown["prey"]), scenario
        assert any(one["out"] for there in shown["states"] for one in there["hunted"]), scenario


def test_the_player_knows_the_teams_and_in_how_many_pieces_each_ring_is(bundles):
    shown, replay = bundles["pairs"]
    info = MatchInfo.of_replay(replay)
    assert [(one["name"], tuple(one["seats"])) for one in shown["teams"]] == [
        (one.name, one.seats) for one in info.contenders
    ]
    assert [one["pieces"] for one in shown["hunters"]] == list(info.rings)
    assert bundles["standard"][0]["teams"] is None


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_the_player_knows_who_moves_who_reaches_how_far_and_what_is_seen(bundles, scenario):
    shown, replay = bundles[scenario]
    config = replay.config
    lasting = {number for number, _, length in shown["targets"] if length > 2}
    if scenario == "herd":  # who is withdrawn stands still
        lasting -= set(shown["prey"][1]["targets"])
    assert set(shown["moving"]) >= lasting if config.targets_move else shown["moving"] == []
    assert [one["reach"] for one in shown["hunters"]] == list(config.reaches)
    partial = {"radius": config.view_radius_m, "angle": config.view_angle_deg}
    assert shown["view"] == (partial if config.partial_view else None)


def test_contests_are_those_that_explain_tells_and_lie_at_their_targets(bundles):
    count = 0
    for shown, replay in bundles.values():
        for one, contest in zip(shown["contests"], explain(replay).contests, strict=True):
            count += 1
            assert one["time"] == (contest.step - 1) * shown["period"]
            assert one["parties"] == [claim.seat for claim in contest.claims]
            assert replay.config.target_name(one["place"]) == one["target"] == contest.target
    assert count > 5


@pytest.fixture(scope="module")
def small():
    """(facts, tracks) of a short bundle with something in each list."""
    teams = ((0, 1, 2), (3, 4, 5))
    env = catch_arena.parallel_env("crowd", time_limit_s=1.5, hunters=6, reach_m=3.0, side_m=6.0, teams=teams, prey=2)
    env.record(title="short")
    _, infos = env.reset(seed=1)
    while env.agents:
        _, _, _, _, infos = env.step(chase(env, infos))
        if len(env.agents) == 8:
            env.withdraw("hunter_3")
    head, tracks = encode_bundle(env.replay()).split(b"\n", 1)
    facts = json.loads(head)
    assert all(facts[name] for name in ("hunters", "teams", "prey", "targets", "withdrawals", "rulings", "contests"))
    return facts, tracks


def packed(facts, tracks):
    return packed_text(json.dumps(facts).encode() + b"\n" + tracks)


def test_a_bundle_that_is_written_anew_is_read(small):
    (found,) = read([packed(*small)])
    assert found["title"] == small[0]["title"]


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"steps": -1}, "steps must be a number from 0 to 8388608, got -1"),
        ({"steps": 0.5}, "steps must be a whole number, got 0.5"),
        ({"period": 0}, "period must be a number from 16 to 1000000000, got 0"),
        ({"side": "11"}, 'side must be a number from 2 to 5000, got "11"'),
        ({"title": None}, "title must be text, got null"),
        ({"hunters": {}}, "hunters must be a list, got {}"),
        (
            {"hunters": [{"name": "a"}]},
            'hunters[0] must be a name, a colour, a reach and the number of a ring\'s arcs, got {"name":"a"}',
        ),
        (
            {"hunters": [{"name": "a", "color": "#aabbcc", "reach": -1}]},
            "hunters[0] must be a name, a colour, a reach and the number of a ring's arcs, got {",
        ),
        (
            {"hunters": [{"name": "a", "color": "#aabbcc", "reach": 1, "pieces": 0}]},
            "hunters[0] must be a name, a colour, a reach and the number of a ring's arcs, got",
        ),
        ({"teams": [{"name": "a", "color": "red"}]}, "teams must be names, colours and seats, or null, got [{"),
        ({"prey": [{"name": "a"}]}, 'prey[0] must be a name and the numbers of its targets, got {"name":"a"}'),
        ({"prey": [{"name": "a", "targets": [1, 999]}]}, "prey[0] plays target 999, which is not in the replay"),
        ({"view": {"radius": 2}}, 'view must be a radius and an angle, or null, got {"radius":2}'),
        ({"view": {"radius": 2, "angle": 400}}, "view must be a radius and an angle, or null, got"),
        (
            {"targets": [[1, 0]]},
            "targets[0] must be a number, its first state, and the number of its states, got [1,0]",
        ),
        ({"withdrawals": [[0, 99]]}, "withdrawals[0] must be a step and an agent, got [0,99]"),
        ({"rulings": [[0, 0, "GRANTED", 999]]}, "rulings[0] is about target 999, which is not in the replay"),
        ({"rulings": []}, "contests[0] belongs to no ruling in the replay"),
        ({"steps": 10**6}, "its tracks must have "),
    ],
)
def test_the_line_names_what_is_wrong_with_a_bundle(small, changes, line):
    facts, tracks = small
    assert refused(packed({**facts, **changes}, tracks)).startswith(f"Error: It is damaged: {line}")


def test_a_bundle_without_a_field_is_refused_by_its_name(small):
    facts, tracks = small
    found = read([packed({other: facts[other] for other in facts if other != name}, tracks) for name in facts])
    for name, one in zip(facts, found, strict=True):
        assert one["error"].startswith(f"Error: It is damaged: {name} must be "), one
        assert one["error"].endswith("got no value."), one


def test_a_truncated_bundle_is_refused_wherever_it_ends(small):
    content = json.dumps(small[0]).encode() + b"\n" + small[1]
    whole = base64.b64decode(packed_text(content))
    texts = [base64.b64encode(whole[:end]).decode() for end in range(0, len(whole), max(1, len(whole) // 60))]
    texts += [packed_text(content[:end]) for end in range(0, len(content), len(content) // 60)]
    for one in read(texts):
        assert one["error"].startswith("Error: It is damaged: "), one


def test_what_is_no_bundle_at_all_is_refused():
    texts = ["", "%", "A", "no base64 at all", base64.b64encode(b"not gzip").decode(), packed_text(b"")]
    contents = [b"\n", b"[]\n", b"null\n", b"{}\n", b'"\xff"\n', b"[" * 10**5 + b"\n"]
    for one in read(texts + [packed_text(content) for content in contents]):
        assert one["error"].startswith("Error: It is damaged: "), one
        assert "\n" not in one["error"]


def test_a_bundle_that_unpacks_without_end_is_not_unpacked():
    bomb = gzip.compress(bytes(257 << 20), compresslevel=1)
    line = refused(base64.b64encode(bomb).decode())
    assert line == f"Error: It is damaged: it has more than {256 << 20} bytes when unpacked."


def places(value, path=()):
    """The path of each part of a JSON value; of lists the first and the last."""
    yield path
    if isinstance(value, dict):
        parts = list(value)
    elif isinstance(value, list):
        parts = sorted({0, len(value) - 1}) if value else []
    else:
        return
    for part in parts:
        yield from places(value[part], (*path, part))


def replaced(value, path, other):
    """A copy with another part at a path."""
    if not path:
        return other
    changed = copy.deepcopy(value)
    inner = changed
    for part in path[:-1]:
        inner = inner[part]
    inner[path[-1]] = other
    return changed


def test_whatever_stands_in_a_field_a_bundle_is_read_or_refused_with_one_line(small):
    """All kinds of JSON at each place: nothing hangs, and no error comes from deep inside."""
    facts, tracks = small
    others = [None, True, -1, 0, 0.5, 1e300, 2**53, "", "x", [], [[]], {}]
    texts = [packed(replaced(facts, path, other), tracks) for path in places(facts) for other in others]
    found = read(texts)
    assert len(found) > 500
    assert sum("error" in one for one in found) > len(found) // 2
    for one in found:
        if "error" in one:
            assert one["kind"] == "Error", one
            assert one["error"].startswith("Error: It is damaged: "), one
            assert "\n" not in one["error"]


def test_the_modules_are_one_script_in_a_page():
    """A script, not a module: nothing is imported or exported, and no name stands in it twice."""
    script = element_script().removeprefix("<script>").removesuffix("</script>")
    assert "catch-replay" in script
    deno("eval", f"new Function({json.dumps(script)})")
