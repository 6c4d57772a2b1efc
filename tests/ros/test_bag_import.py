"""Bags of turtlesim are read, and the arbiter judges each catch in them."""

import csv
import math
import sqlite3
from itertools import pairwise
from pathlib import Path

import pytest
from command_line import run
from ros.bags import Recorder, without_definitions

from catch_arena.replay import Replay
from catch_arena.ros.bags.reading import read_bag
from catch_arena.ros.bags.rulings import judge_bag
from catch_arena.ros.bags.video import bag_worlds
from catch_arena.verdicts import Verdict

TRACES = Path(__file__).parents[1] / "data"
SIDE = 11.088889122009277


def trace(number=1):
    """(ms, x, y, theta, v, w) of a real turtlesim, tick by tick."""
    with (TRACES / f"turtlesim_humble_{number}.csv").open(newline="") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))[1:]
    return [(16.0 * tick, *map(float, row)) for tick, row in enumerate(rows)]


def record_chase(folder, *, storage="sqlite3", jitter=0.0, **names):
    """Record a real turtle's way, with targets next to it. Each is caught as the turtle passes, from a distance of its
    own, as the exercise's nodes grant it. Returns the catches: (ms, name, metres).
    """
    rows = trace()
    caught, lists = [], []
    moving = [row for row in rows[::160] if row[4] > 0.0]
    for number, (time_ms, x, y, theta, *_) in enumerate(moving, start=1):
        away = 0.055 * number
        place = [
            min(max(start + away * part, 0.0), SIDE)
            for start, part in ((x, math.cos(theta + 1)), (y, math.sin(theta + 1)))
        ]
        target = f"target_turtle_{number}", *place
        lists += [(max(0.0, time_ms - 1500.0), "spawned", target), (time_ms + 8.0, "caught", target)]
        caught.append((time_ms + 8.0, target[0], math.dist((x, y), place)))
    now = []
    events = [(time_ms, "pose", row) for time_ms, *row in rows] + lists
    with Recorder(folder, storage, **names) as bag:
        for time_ms, what, about in sorted(events, key=lambda one: (one[0], one[1] != "pose")):
            if what == "pose":
                bag.pose("turtle1", time_ms + jitter * math.sin(time_ms), *about)
                continue
            now = [*now, about] if what == "spawned" else [one for one in now if one != about]
            bag.alive(time_ms, *now)
    return caught


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_every_catch_of_a_real_turtles_bag_is_judged_where_it_stood(tmp_path, storage):
    caught = record_chase(tmp_path / "chase", storage=storage)
    assert len(caught) > 6
    judged = judge_bag(read_bag(tmp_path / "chase"))
    assert [one.ruling.target for one in judged] == [name for _, name, _ in caught]
    for one, (time_ms, _, metres) in zip(judged, caught, strict=True):
        assert one.time_ms == pytest.approx(time_ms, abs=0.01)
        assert one.hunter == "turtle1"
        assert one.ruling.distance_um == pytest.approx(1e6 * metres, abs=2)
        assert one.ruling.verdict is (Verdict.GRANTED if metres < 0.3 else Verdict.OUT_OF_REACH)
    assert {one.ruling.verdict for one in judged} == {Verdict.GRANTED, Verdict.OUT_OF_REACH}


def test_a_bag_of_humble_without_definitions_and_one_of_kilted_are_read_alike(tmp_path):
    record_chase(tmp_path / "humble")
    without_definitions(tmp_path / "humble" / "humble.db3")
    record_chase(tmp_path / "kilted", storage="mcap", package="turtles_by_me", turtlesim="turtlesim_msgs")
    humble, kilted = (judge_bag(read_bag(tmp_path / name)) for name in ("humble", "kilted"))
    assert [str(one) for one in humble] == [str(one) for one in kilted]


def test_a_turtle_with_float32_is_read_by_the_definition_in_the_bag(tmp_path):
    narrow = "string name\nfloat32 x\nfloat32 y\nfloat32 theta\n"
    caught = record_chase(tmp_path / "narrow", storage="mcap", turtle=narrow)
    judged = judge_bag(read_bag(tmp_path / "narrow"))
    for one, (*_, metres) in zip(judged, caught, strict=True):
        assert one.ruling.distance_um == pytest.approx(1e6 * metres, abs=3)


def test_a_turtle_with_float32_and_no_definition_is_refused_in_one_line(tmp_path):
    record_chase(tmp_path / "narrow", turtle="string name\nfloat32 x\nfloat32 y\nfloat32 theta\n")
    without_definitions(tmp_path / "narrow" / "narrow.db3")
    with sqlite3.connect(tmp_path / "narrow" / "narrow.db3") as base:  # empty lists can be read by any definition
        base.execute("DELETE FROM messages WHERE length(data) = 8")
    base.close()
    refused = run("ros", "import", tmp_path / "narrow", "--list")
    assert refused.exit_code == 2
    assert "/alive_turtles: its messages must be TurtleArray with string name, float64 x" in refused.stderr
    assert refused.stderr.count("\n") == 1


@pytest.mark.parametrize("settings", [["hunters=3", "initial_targets=6"], ["hunters=1", "target_motion=flee"]])
def test_what_was_caught_in_a_match_comes_back_with_the_same_rulings(tmp_path, settings):
    words = [word for one in [*settings, "time_limit_s=15"] for word in ("--set", one)]
    agents = ["nearest", "contested", "nearest"][: int(settings[0][-1])]
    assert run("match", *agents, *words, "--trusted", "--seed", 9, "-o", tmp_path / "m.replay").exit_code == 0
    assert run("ros", "bag", tmp_path / "m.replay", "-o", tmp_path / "m").exit_code == 0
    bag = read_bag(tmp_path / "m")
    judged = judge_bag(bag)
    worlds = list(Replay.load(tmp_path / "m.replay").worlds())
    granted = [
        (before.time_ms, one.hunter, one.target)
        for before, after in pairwise(worlds)
        for one in after.rulings
        if one.success
    ]
    assert sorted((one.time_ms, one.ruling.hunter, one.ruling.target) for one in judged) == sorted(granted)
    assert {one.ruling.verdict for one in judged} == {Verdict.GRANTED}
    assert len(judged) > 3
    *_, last = bag_worlds(bag, judged)
    assert [hunter.score for hunter in last.hunters] == [hunter.score for hunter in worlds[-1].hunters]
    assert last.team_scores == worlds[-1].team_scores  # whose lead the video shows
    for here, there in zip(last.hunters, worlds[-1].hunters, strict=True):
        assert (here.x, here.y) == pytest.approx((there.x, there.y), abs=2e-6)


def test_a_target_without_a_name_and_one_out_of_reach_are_told_apart(tmp_path):
    """The exercise's own nodes list a spawn that failed with an empty name."""
    one, far = ("target_turtle_1", 5.0, 5.2), ("target_turtle_2", 9.0, 5.0)
    lists = {496: [("", 5.0, 5.0), one, far], 800: [one, far], 1008: [far], 2000: []}
    with Recorder(tmp_path / "wrong") as bag:
        for time_ms in range(0, 4000, 16):
            bag.pose("turtle1", time_ms, 5.0, 5.0)
            bag.pose("target_turtle_1", time_ms, 5.0, 5.2)  # it is no hunter
            if time_ms in lists:
                bag.alive(time_ms, *lists[time_ms])
    contents = read_bag(tmp_path / "wrong")
    assert list(contents.hunters) == ["turtle1"]
    judged = judge_bag(contents)
    assert [(one.ruling.target, one.ruling.verdict) for one in judged] == [
        ("", Verdict.UNKNOWN_TARGET),
        ("target_turtle_1", Verdict.GRANTED),
        ("target_turtle_2", Verdict.OUT_OF_REACH),
    ]
    assert [": but " in str(one) for one in judged] == [True, False, True]


def test_the_video_shows_who_was_where_and_is_as_long_as_the_bag(tmp_path):
    caught = record_chase(tmp_path / "chase", jitter=3.0)
    bag = read_bag(tmp_path / "chase")
    judged = judge_bag(bag)
    worlds = list(bag_worlds(bag, judged))
    rows = {time_ms: row for time_ms, *row in trace()}
    assert len(worlds) == len(rows)
    for world in worlds[1:-1]:
        (hunter,) = world.hunters
        # it lies on the way between two poses, which were told up to 3 ms too early or too late
        assert (hunter.x, hunter.y) == pytest.approx(rows[world.time_ms][:2], abs=0.003 * 2 * 3.0 + 1e-4)
    for time_ms, name, _ in caught:
        there = {world.time_ms for world in worlds if name in {target.name for target in world.targets}}
        assert max(there) <= time_ms
        assert max(there) > time_ms - 16
    assert sum(len(world.rulings) for world in worlds) == len(caught)
    made = run("ros", "import", tmp_path / "chase", "-o", tmp_path / "f.mp4", "--size", "320x320", "--fps", 2)
    assert made.exit_code == 0, made.output
    assert made.stdout.count(" s  turtle1 caught target_turtle_") == len(caught)
    assert f"catches: {len(caught)} in the recording" in made.stdout
    frames = round(bag.end_ms / 1000 * 2)
    assert f"video: {tmp_path / 'f.mp4'} ({frames} frames" in made.stdout
    assert (tmp_path / "f.mp4").stat().st_size > 10_000


@pytest.mark.parametrize("pose", [(math.nan, 5.0), (5.0, math.inf), (1e30, 5.0), (-3.0, 5.0)])
def test_poses_that_cannot_be_are_left_out_and_counted(tmp_path, pose):
    with Recorder(tmp_path / "b") as bag:
        for time_ms in range(0, 1600, 16):
            bag.pose("turtle1", time_ms, *(pose if time_ms == 800 else (5.0, 5.0)))
        bag.alive(900, ("a", 5.1, 5.0))
        bag.alive(1000, ("a", math.nan, 5.0))
        bag.alive(1100)
    result = run("ros", "import", tmp_path / "b", "--list")
    assert result.exit_code == 0
    assert result.stderr == "left out: 2 messages that are damaged or have impossible values\n"
    assert "catches: 1 in the recording, 1 of them granted" in result.stdout


DAMAGE = {
    "truncated": lambda file: file.write_bytes(file.read_bytes()[: file.stat().st_size // 2]),
    "empty": lambda file: file.write_bytes(b""),
    "noise": lambda file: file.write_bytes(b"\x89MCAP0\r\n" + bytes(range(256)) * 40),
    "gone": lambda file: file.unlink(),
}


@pytest.mark.parametrize(
    ("storage", "name", "how"),
    [
        *(
            (storage, f"whole{ending}", how)
            for storage, ending in (("mcap", ".mcap"), ("sqlite3", ".db3"))
            for how in DAMAGE
        ),
        *(("sqlite3", "metadata.yaml", how) for how in ("empty", "noise", "gone")),
    ],
)
def test_a_damaged_bag_is_one_line_and_no_video(tmp_path, storage, name, how):
    folder = tmp_path / "whole"
    record_chase(folder, storage=storage)
    DAMAGE[how](folder / name)
    refused = run("ros", "import", folder, "-o", tmp_path / "f.mp4")
    assert refused.exit_code == 2
    assert refused.stderr.startswith(f"error: {folder}: ")
    assert refused.stderr.count("\n") == 1
    assert not refused.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["whole"]


def test_a_folder_without_turtles_and_one_with_targets_alone_say_what_to_record(tmp_path):
    with Recorder(tmp_path / "empty"):
        pass
    with Recorder(tmp_path / "lists") as bag:
        bag.alive(0, ("a", 1.0, 1.0))
    with Recorder(tmp_path / "targets") as bag:
        bag.pose("a", 0, 1.0, 1.0)
        bag.alive(0, ("a", 1.0, 1.0))
    for name, why in (
        ("empty", "has no poses of turtlesim; record with ros2 bag record -a"),
        ("lists", "has no poses of turtlesim; record with ros2 bag record -a"),
        ("targets", "has no poses of hunters; record /turtle1/pose too"),
        ("nowhere", "no such file"),
    ):
        refused = run("ros", "import", tmp_path / name)
        assert refused.stderr == f"error: {tmp_path / name}: {why}\n"
