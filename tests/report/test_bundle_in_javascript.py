"""The player reads from a bundle the match that Python packed, and refuses a damaged bundle with one line."""

import base64
import gzip
import json
import math
from pathlib import Path

import numpy as np
import pytest
from render.matches import played
from report.javascript import deno

import catch_arena
from catch_arena.errors import ConfigError
from catch_arena.explanation import explain, what_if
from catch_arena.player.bundle import GRID, TURN, bundle_text, css, encode_bundle, packed_text
from catch_arena.player.element import element_script
from catch_arena.render.match_info import MatchInfo
from catch_arena.replay import Replay

READER = Path(__file__).with_name("read_bundles.js")
SCENARIOS = tuple(catch_arena.SCENARIOS)
WITHDRAWN_AT = 17


def read(texts):
    """Return the player's contents of each bundle, or `kind` and `error` if it refuses the bundle."""
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
def test_everything_stands_where_it_stood_in_the_match(bundles, scenario):
    """Within half a unit of the bundle's grid."""
    shown, replay = bundles[scenario]
    tracks = [np.array(track) for track in shown["tracks"]]
    of_targets = tracks[len(shown["hunters"]) :]
    targets = {number: (first, track) for (number, first, _), track in zip(shown["targets"], of_targets, strict=True)}
    for state, world in enumerate(replay.worlds()):
        poses = [(hunter, track[:, state]) for hunter, track in zip(world.hunters, tracks, strict=False)]
        for target in world.targets:
            first, track = targets[target.number]
            poses.append((target, track[:, state - first]))
        for one, (x, y, theta) in poses:
            assert (x, y) == pytest.approx((one.x, one.y), abs=0.51 * shown["side"] / GRID)
            assert abs(math.remainder(one.theta - theta, math.tau)) <= 0.51 * math.tau / TURN


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_names_colours_and_rulings_are_those_of_the_match(bundles, scenario):
    shown, replay = bundles[scenario]
    info = MatchInfo.of_replay(replay)
    agents = [(name, info.label(agent)) for agent, name in enumerate(info.names)]
    assert [(one["name"], one["label"]) for one in (*shown["hunters"], *shown["prey"])] == agents
    assert [one["color"] for one in shown["hunters"]] == [css(color) for color in info.colors[: replay.config.hunters]]
    rulings = [(state - 1, ruling) for state, world in enumerate(replay.worlds()) for ruling in world.rulings]
    for one, (state, ruling) in zip(shown["rulings"], rulings, strict=True):
        assert (one["time"], one["seat"], one["verdict"]) == (
            state * shown["period"],
            ruling.hunter,
            ruling.verdict.name,
        )
        assert ruling.target == (None if one["target"] is None else replay.config.target_name(one["target"]))


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_half_a_state_later_everybody_is_half_way_to_the_next(bundles, scenario):
    shown, _ = bundles[scenario]
    firsts = [0] * len(shown["hunters"]) + [first for _, first, _ in shown["targets"]]
    for state, there in enumerate(shown["states"]):
        for pose, first, track in zip(there["later"], firsts, shown["tracks"], strict=True):
            states = np.arange(first, first + len(track[0]))
            expected = [np.interp(state + 0.5, states, column) for column in track]
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


def test_a_contest_without_measured_distances_has_no_lens():
    """R9.1: the policy `capstone` grants each request for a target."""
    (shown,) = read([bundle_text(played("capstone", time_limit_s=20.0, hunters=4, side_m=4.0))])
    assert shown["contests"]
    assert all(contest["lens"] is None for contest in shown["contests"])


@pytest.fixture(scope="module")
def answered(replays):
    """(match, answers to two contests, the later one first)."""
    replay = replays["crowd"]
    contests = explain(replay).contests
    return replay, [what_if(replay, contests[-1]), what_if(replay, contests[0])]


def test_answers_are_about_their_contests_and_have_the_alternative_way_of_the_loser(answered):
    replay, answers = answered
    (shown,) = read([bundle_text(replay, answers)])
    for one, answer in zip(shown["answers"], answers[::-1], strict=True):  # in the order of time
        assert (one["agent"], one["text"]) == (answer.seat, answer.sentence)
        assert shown["contests"][one["contest"]]["target"] == answer.contest.target
        assert shown["contests"][one["contest"]]["time"] == answer.contest.judged_ms
        worlds = list(answer.alternative.worlds())[min(answer.actions) :]
        assert one["way"]["first"] == min(answer.actions)
        x, y, _ = one["way"]["track"]
        hunters = [world.hunters[answer.seat] for world in worlds]
        assert x == pytest.approx([hunter.x for hunter in hunters], abs=0.51 * shown["side"] / GRID)
        assert y == pytest.approx([hunter.y for hunter in hunters], abs=0.51 * shown["side"] / GRID)


def test_there_is_no_ghost_where_no_change_helps():
    poses = ((5.0, 5.0, 0.0), (5.0, 5.0, 0.0))
    replay = played("duel", time_limit_s=1.0, hunter_poses=poses, reach_m=9.0)
    answer = what_if(replay, explain(replay).contests[0])
    (shown,) = read([bundle_text(replay, [answer])])
    assert [(one["text"], one["way"]) for one in shown["answers"]] == [(answer.sentence, None)]
    assert answer.sentence.startswith("No change of ")


def test_an_answer_is_shown_around_its_contest(answered):
    replay, answers = answered
    for answer in answers:
        (shown,) = read([bundle_text(replay, [answer])])
        assert shown["shown"] == [[None, answer.sentence, answer.sentence, answer.sentence, None]]


def test_an_answer_of_another_match_is_refused(answered, replays):
    _, answers = answered
    with pytest.raises(ConfigError, match="answers must be about contests of this match, got one about Contest"):
        bundle_text(replays["duel"], answers)


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


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"steps": -1}, "steps must be a number from 0 to 8388608, got -1"),
        ({"side": "11"}, 'side must be a number from 2 to 5000, got "11"'),
        ({"hunters": {}}, "hunters must be a list, got {}"),
        (
            {"hunters": [{"name": "a"}]},
            'hunters[0] must be a name, a label, a colour, a reach and the number of a ring\'s arcs, got {"name":"a"}',
        ),
        ({"teams": [{"name": "a", "color": "red"}]}, "teams must be names, colours and seats, or null, got [{"),
        ({"prey": [{"name": "a"}]}, 'prey[0] must be a name, a label and the numbers of its targets, got {"name":"a"}'),
        (
            {"prey": [{"name": "a", "label": "a", "targets": [1, 999]}]},
            "prey[0] plays target 999, which is not in the replay",
        ),
        ({"view": {"radius": 2}}, 'view must be a radius and an angle, or null, got {"radius":2}'),
        (
            {"targets": [[1, 0]]},
            "targets[0] must be a number, its first state, and the number of its states, got [1,0]",
        ),
        ({"withdrawals": [[0, 99]]}, "withdrawals[0] must be a step and an agent, got [0,99]"),
        ({"rulings": [[0, 0, "GRANTED", 999]]}, "rulings[0] is about target 999, which is not in the replay"),
        (
            {"answers": [{"contest": 0, "agent": 0, "text": "", "first": 9, "states": 99}]},
            "answers[0] must be a contest's index, a seat, a text, the first state of a way, and the number of its ",
        ),
        (
            {"answers": [{"contest": 999, "agent": 0, "text": "", "first": 0, "states": 0}]},
            "answers[0] is about contest 999, which is not in the replay",
        ),
        (
            {"moments": [{"time": 0, "agent": 99, "text": "", "contest": None}]},
            "moments[0] must be a time, a seat, a text, and a contest's index or null, got {",
        ),
        (
            {"moments": [{"time": 0, "agent": 0, "text": "", "contest": 999}]},
            "moments[0] is about contest 999, which is not in the replay",
        ),
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


def test_the_modules_are_one_script_in_a_page():
    """A script, not a module: nothing is imported or exported, and no name stands in it twice."""
    script = element_script().removeprefix("<script>").removesuffix("</script>")
    assert "catch-replay" in script
    deno("eval", f"new Function({json.dumps(script)})")
