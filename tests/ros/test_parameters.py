"""What nodes do with their parameters, and what --ros-args may say of them."""

import math
import sys

import pytest
from ros.local import Hub
from ros.match import TYPES

from catch_arena.config import ArenaConfig
from catch_arena.errors import BusError, ConfigError
from catch_arena.messages import Pose, Turtle, TurtleArray
from catch_arena.ros.middleware.parameters import arena_parameters, controller_parameters, spawner_parameters
from catch_arena.ros.nodes.controller import Controller
from catch_arena.ros.nodes.ros_args import take_ros_args
from catch_arena.scenarios import scenario
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.isolation.playing import inspector, start_players

FREQUENCY, PREFIX, CLOSEST = "spawn_frequency", "turtle_name_prefix", "catch_closest_turtle_first"


def given(*words):
    """What a spawner begins with: its name, its values, and what was said."""
    parameters, said = spawner_parameters(0.5, "target_turtle_"), []
    node = take_ros_args(words, "turtle_spawner", parameters, said.append)
    return node, [parameters[FREQUENCY].value, parameters[PREFIX].value], said


@pytest.mark.parametrize(
    ("words", "values"),
    [
        ((), [0.5, "target_turtle_"]),
        (("-p", f"{FREQUENCY}:=2.0"), [2.0, "target_turtle_"]),
        (("-p", f"{FREQUENCY}:=1e1", "-p", f"{FREQUENCY}:=.25"), [0.25, "target_turtle_"]),
        (("-p", f"turtle_spawner:{FREQUENCY}:=2.0"), [2.0, "target_turtle_"]),
        (("-p", f'{PREFIX}:="a2"'), [0.5, "a2"]),
        (("-p", f"{PREFIX}:='yes'"), [0.5, "yes"]),
    ],
)
def test_values_are_read_as_ros_reads_them(words, values):
    """A number with a point is a double, quotes make a text of anything, and the last one counts."""
    assert given(*words) == ("turtle_spawner", values, [])


@pytest.mark.parametrize(("word", "value"), [("yes", True), ("y", True), ("FALSE", False), ("off", False)])
def test_the_words_for_true_and_false_are_those_of_rcl(word, value):
    parameters = controller_parameters(closest_first=not value)
    take_ros_args(("-p", f"{CLOSEST}:={word}", "-r", "__node:=bob"), "turtle_controller", parameters, print)
    assert parameters[CLOSEST].value is value


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("-p",), "--ros-args -p must be followed by what it is about"),
        (("spawn_frequency:=2.0",), "--ros-args must be of -p, --params-file and -r __node:=NAME here, got 'spawn_fre"),
        (("-p", "spawn_frequency=2.0"), "--ros-args -p must be NAME:=VALUE, as spawn_frequency:=2.0"),
        (("-p", f"{FREQUENCY}:=2"), f"{FREQUENCY} must be a double, as 2.0, got 2"),
        (("-p", f"{FREQUENCY}:="), f"{FREQUENCY} must be a double, as 2.0, got None"),
        (("-p", f"{FREQUENCY}:=fast"), f"{FREQUENCY} must be a double, as 2.0, got 'fast'"),
        (("-p", f"{FREQUENCY}:=.nan"), f"{FREQUENCY}: spawn_frequency_hz must be a finite number"),
        (("-p", f"{FREQUENCY}:=" + "[" * 1000), f"--ros-args -p {FREQUENCY} must be YAML: "),
        (("-p", f"{PREFIX}:=no"), f"{PREFIX} must be a string, got False"),
        (("-p", "spawn_freq:=2.0"), f"there is no parameter 'spawn_freq': did you mean {FREQUENCY}?"),
        (("-p", f"{CLOSEST}:=true"), f"there is no parameter '{CLOSEST}': "),
        (("-p", f"other:{FREQUENCY}:=2.0"), f"--ros-args -p other:{FREQUENCY}:=2.0 is of the node other"),
        (("-r", "turtle1/pose:=x"), "--ros-args -r must be __node:=NAME, got 'turtle1/pose:=x': topics and services "),
        (
            ("-r", "__node:=a/b"),
            "--ros-args -r __node:= must be letters, digits and underscores, at most 255, got 'a/b'",
        ),
        (("--params-file", "/nowhere.yaml"), "--params-file /nowhere.yaml cannot be read: "),
    ],
)
def test_a_word_that_cannot_be_is_one_line(words, why):
    """As for every other option."""
    with pytest.raises(ConfigError) as error:
        given(*words)
    assert str(error.value).startswith(why)
    assert "\n" not in str(error.value)


def written(tmp_path, text):
    file = tmp_path / "params.yaml"
    file.write_text(text)
    return ("--params-file", str(file))


def test_a_file_has_values_for_several_nodes(tmp_path):
    """What it says of this one counts more than what it says of all; others' parameters are left out with a line."""
    file = written(
        tmp_path,
        f"turtle_spawner:\n  ros__parameters: {{{FREQUENCY}: 2.0, use_sim_time: false}}\n"
        f"turtle_controller:\n  ros__parameters: {{{CLOSEST}: true}}\n"
        f"/**:\n  ros__parameters: {{{FREQUENCY}: 3.0, {PREFIX}: all_, x: {{y: 1}}}}\n",
    )
    node, values, said = given(*file)
    assert (node, values) == ("turtle_spawner", [2.0, "all_"])
    assert [line.partition("params.yaml: ")[2] for line in said] == [
        "/** has 'x', which is no parameter of turtle_spawner: it is left out",
        "turtle_spawner has 'use_sim_time', which is no parameter of turtle_spawner: it is left out",
    ]
    assert given(*file, "-r", "__node:=bob")[1] == [3.0, "all_"]
    assert given(*file, "-p", f"{FREQUENCY}:=4.0")[1] == [4.0, "all_"]
    assert given("-p", f"{FREQUENCY}:=4.0", *file)[1] == [2.0, "all_"]


@pytest.mark.parametrize("mark", ["", "\ufeff"], ids=["utf-8", "byte order mark"])
def test_a_file_as_ros2_param_dump_writes_it_is_read(tmp_path, mark):
    """With a slash before the node's name."""
    dumped = f"{mark}/turtle_spawner:\n  ros__parameters:\n    {FREQUENCY}: 2.0\n    {PREFIX}: bob_\n"
    assert given(*written(tmp_path, dumped))[1:] == ([2.0, "bob_"], [])
    assert given(*written(tmp_path, ""))[1:] == ([0.5, "target_turtle_"], [])


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("- 1\n", "must be names with values, got [1]"),
        (f"turtle_spawner:\n  {FREQUENCY}: 2.0\n", "turtle_spawner must have ros__parameters"),
        ("turtle_spawner:\n  ros__parameters: [1]\n", "turtle_spawner.ros__parameters must be names with values"),
        (f"/**:\n  ros__parameters:\n    {FREQUENCY}: 2\n", f"{FREQUENCY} must be a double, as 2.0, got 2"),
        ("a: [\n", "must be YAML: "),
        ("\x00", "must be YAML: "),
    ],
)
def test_a_file_that_cannot_be_is_one_line(tmp_path, text, why):
    """Whatever is in it."""
    with pytest.raises(ConfigError) as error:
        given(*written(tmp_path, text))
    assert why in str(error.value)
    assert "\n" not in str(error.value)


def test_where_nothing_reads_yaml_it_says_what_to_install(monkeypatch):
    """Over rclpy the extra may not be there."""
    monkeypatch.setitem(sys.modules, "ruamel.yaml", None)
    with pytest.raises(BusError, match=r"pip install '\.\[ros\]' in the clone"):
        given("-p", f"{FREQUENCY}:=2.0")


def test_a_match_has_the_spawners_parameters_and_keeps_them():
    """R3.1 counts the firings from its beginning."""
    parameters = arena_parameters(ArenaConfig(spawn_frequency_hz=2, name_prefix="b "))
    assert {name: one.value for name, one in parameters.items()} == {FREQUENCY: 2.0, PREFIX: "b "}
    assert all(one.fixed.startswith("a match keeps its settings") for one in parameters.values())


def test_a_controller_drives_to_the_closest_or_to_the_oldest_target_from_one_period_to_the_next():
    """The oldest stands to the left of it, the closest to the right."""
    hub = Hub()
    turtlesim = hub.bus("turtlesim")
    parameters = controller_parameters(closest_first=True)
    entrants = enter(["nearest", "first"], inspector(None))
    with start_players(entrants, None) as players:
        ours = hub.bus("ours")
        closest = parameters[CLOSEST]
        node = Controller(ours, players, scenario("capstone"), "turtle1", TYPES, closest, log=print)
        pose = turtlesim.publisher("/turtle1/pose", TYPES.pose)
        turtlesim.publisher("/alive_turtles", TYPES.turtle_array)(
            TurtleArray((Turtle("old", 5.0, 9.0, 0.0), Turtle("near", 5.0, 4.0, 0.0)))
        )
        turns = []
        for wanted in (True, False, False, True):
            closest.set(wanted)
            pose(Pose(5.0, 5.0, 0.0, 0.0, 0.0))
            ours.spin()
            node.tick()
            turns.append(math.copysign(1, hub.sent["/turtle1/cmd_vel"][-1].angular.z))
    assert turns == [-1, 1, 1, -1]
