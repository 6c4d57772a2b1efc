"""A recorded match becomes a bag that rosbags reads, with the poses and rulings of the match."""

from itertools import pairwise

import pytest
from command_line import run
from ros.match import Match
from rosbags.highlevel import AnyReader

from catch_arena.replay import Replay

NS = 1_000_000


@pytest.fixture(scope="module")
def replays(tmp_path_factory):
    """A contest of three, a single hunter after moving targets, and faults."""
    folder = tmp_path_factory.mktemp("replays")
    played = {
        "three": ("nearest nearest contested", "hunters=3", "time_limit_s=12", "initial_targets=6"),
        "one": ("nearest", "hunters=1", "target_motion=wander", "time_limit_s=6"),
        "faults": ("nearest nearest", "hunters=2", "time_limit_s=8", "faults.kill_refused=0.5"),
    }
    for name, (agents, *settings) in played.items():
        words = [*agents.split(), *(word for one in settings for word in ("--set", one))]
        made = run("match", *words, "--seed", "5", "--trusted", "-o", folder / f"{name}.replay")
        assert made.exit_code == 0, made.output
    return folder


@pytest.fixture(scope="module", params=["three", "one", "faults"])
def match(request, replays):
    return request.param, Replay.load(replays / f"{request.param}.replay")


@pytest.fixture(scope="module", params=["mcap", "sqlite3"])
def bag(request, match, replays):
    """The bag of a match, and what it was made of."""
    name, replay = match
    folder = replays / f"{name}_{request.param}"
    made = run("ros", "bag", replays / f"{name}.replay", "-o", folder, "--storage", request.param, "--force")
    assert made.exit_code == 0, made.output
    return folder, request.param, replay


def messages(folder):
    """Return the bag's messages, (topic, type, ns, message), by the types that the bag holds."""
    with AnyReader([folder]) as reader:
        return [
            (one.topic, one.msgtype, time, reader.deserialize(data, one.msgtype))
            for one, time, data in reader.messages()
        ]


def poses_topics(replay):
    names = ["turtle1"] if replay.config.hunters == 1 else replay.config.hunter_names
    return [f"/{name}/pose" for name in names]


def test_every_tick_has_a_pose_of_each_hunter_and_boundaries_have_the_matchs_own(bag):
    folder, _, replay = bag
    worlds = list(replay.worlds())
    by_time = {world.time_ms // 16 * 16 * NS: world for world in worlds}
    for seat, topic in enumerate(poses_topics(replay)):
        places = {time: (one.x, one.y) for name, _, time, one in messages(folder) if name == topic}
        assert sorted(places) == [16 * NS * tick for tick in range(worlds[-1].time_ms // 16 + 1)]
        for time, world in by_time.items():
            hunter = world.hunters[seat]
            assert places[time] == pytest.approx((hunter.x, hunter.y), abs=2e-6)
        steps = [abs(a[0] - b[0]) + abs(a[1] - b[1]) for (_, a), (_, b) in pairwise(sorted(places.items()))]
        assert max(steps) <= 1.5 * replay.config.max_speeds[seat] * 0.016 + 1e-6


def test_the_rulings_are_those_of_the_match_at_the_beginning_of_their_steps(bag):
    folder, _, replay = bag
    hunters = replay.config.hunter_names
    expected = [
        (
            before.time_ms * NS,
            one.step,
            hunters[one.hunter],
            one.target,
            one.verdict.name,
            one.success,
            -1_000_000 if one.distance_um is None else one.distance_um,
        )
        for before, after in pairwise(replay.worlds())
        for one in after.rulings
    ]
    recorded = []
    for topic, kind, time, one in messages(folder):
        if topic == "/rulings":
            assert kind == "catch_arena_interfaces/msg/Ruling"
            assert one.time == time / 1e9
            recorded.append(
                (time, one.step, one.hunter, one.target, one.verdict, one.success, round(1e6 * one.distance))
            )
    assert expected
    assert recorded == expected


def test_a_bag_has_every_ruling_that_the_bus_carried(tmp_path):
    """Requests for what was caught, for what never was there, and several in a step are among them."""
    match = Match(hunters=2, hunter_poses=((5.0, 5.0, 0.0), (6.0, 6.0, 0.0)), initial_targets=8, record=True,
                  time_limit_s=2, reach_m=3.0)  # fmt: skip
    names = ["nonsense", "target_turtle_99", "n" * 300]
    while not match.service.over:
        step = match.service.world.step
        names += [turtle.name for turtle in match.service.alive_turtles().turtles if turtle.name not in names]
        for number in range(step % 4):
            match.request(match.a, names[(step + 5 * number) % len(names)], f"/hunter_{step % 2}/catch_turtle")
        match.tick()
    match.service.replay.save(tmp_path / "m.replay")
    assert run("ros", "bag", tmp_path / "m.replay", "-o", tmp_path / "m").exit_code == 0
    sent = [(one.step, one.hunter, one.target, one.verdict) for one in match.sent("/rulings")]
    recorded = [one for topic, _, _, one in messages(tmp_path / "m") if topic == "/rulings"]
    assert sorted((one.step, one.hunter, one.target, one.verdict) for one in recorded) == sorted(sent)
    assert {verdict for *_, verdict in sent} == {
        "GRANTED", "DUPLICATE", "ALREADY_CAUGHT", "UNKNOWN_TARGET", "OUT_OF_REACH", "MALFORMED",
    }  # fmt: skip


def raw(folder):
    with AnyReader([folder]) as reader:
        return [(one.topic, time, data) for one, time, data in reader.messages()]


def test_the_same_replay_gives_the_same_messages_and_other_packages_other_names(replays, tmp_path):
    one, other = tmp_path / "one", tmp_path / "other"
    words = ["--interfaces", "turtles_by_me", "--turtlesim", "turtlesim_msgs"]
    for folder in (one, other):
        assert run("ros", "bag", replays / "one.replay", "-o", folder, *words).exit_code == 0
    assert raw(one) == raw(other)
    assert {kind for _, kind, *_ in messages(one)} == {
        "turtlesim_msgs/msg/Pose",
        "turtles_by_me/msg/TurtleArray",
        "catch_arena_interfaces/msg/Ruling",
    }


def test_a_bag_is_replaced_with_force_alone_and_what_is_no_bag_never(replays, tmp_path):
    words = ["ros", "bag", replays / "one.replay", "-o"]
    folder = tmp_path / "b"
    assert run(*words, folder).stdout.startswith(f"bag: {folder} (")
    refused = run(*words, folder)
    assert (refused.exit_code, refused.stderr) == (
        2,
        f"error: {folder}: already exists; use --force to replace it, or choose another name\n",
    )
    assert run(*words, folder, "--force", "--storage", "sqlite3").exit_code == 0
    assert sorted(path.name for path in folder.iterdir()) == ["b.db3", "metadata.yaml"]
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.txt").write_text("all of it")
    refused = run(*words, mine, "--force")
    assert refused.stderr == f"error: {mine}: already exists and is not a bag; choose another name\n"
    assert (mine / "thesis.txt").read_text() == "all of it"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["b", "mine"]


@pytest.mark.parametrize(
    ("option", "name"), [("--interfaces", "my robot"), ("--turtlesim", ""), ("--interfaces", "a/b")]
)
def test_a_package_that_cannot_be_is_one_line(replays, tmp_path, option, name):
    refused = run("ros", "bag", replays / "one.replay", "-o", tmp_path / "b", option, name)
    assert refused.exit_code == 2
    assert refused.stderr.startswith(f"error: {option} must be letters, digits and underscores, such as ")
    assert refused.stderr.endswith(f", got {name!r}\n")


@pytest.mark.parametrize("words", [["bag", "x.replay"], ["import", "x"]])
def test_without_rosbags_it_says_what_to_install(monkeypatch, words):
    monkeypatch.setattr("catch_arena.cli.ros.find_spec", lambda _: None)
    refused = run("ros", *words)
    assert (refused.exit_code, refused.stderr) == (
        2,
        "error: bags need rosbags, which is not installed: pip install '.[ros]' in the clone of Catch Arena\n",
    )
