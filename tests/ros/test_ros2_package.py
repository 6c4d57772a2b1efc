"""ros2/catch_arena_interfaces has the messages that we send, and its launch file the options of `ros serve`."""

import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest
from rosbags.typesys import get_types_from_msg
from rosbags.typesys.store import Typestore

from catch_arena.ros.middleware.interfaces import OWN_PACKAGE, RULING, STANDING, Interfaces
from catch_arena.ros.middleware.typestore import type_hash

PACKAGE = Path(__file__).parents[2] / "ros2" / OWN_PACKAGE
TYPES = Interfaces(OWN_PACKAGE)
MESSAGES = (TYPES.turtle, TYPES.turtle_array, RULING, STANDING)


@pytest.mark.parametrize("kind", MESSAGES, ids=lambda kind: kind.name)
def test_its_messages_are_those_that_we_send(kind):
    """By the hash that ROS would announce, which a reader of .msg files of somebody else's makes."""
    store = Typestore()
    for other in MESSAGES:
        text = (PACKAGE / f"{other.name.replace(f'{OWN_PACKAGE}/', '')}.msg").read_text(encoding="utf-8")
        store.register(get_types_from_msg(text, other.name))
    assert store.hash_rihs01(kind.name) == type_hash(kind)


class Action:
    """Stands for every action and event of launch: it keeps what it was made of."""

    def __init__(self, *words, **fields):
        self.words, self.fields = words, fields


class StandIn(ModuleType):
    """Stands for a module of launch, with every class that is imported from it."""

    def __getattr__(self, name):
        vars(self)[name] = list if name == "LaunchDescription" else type(name, (Action,), {})
        return vars(self)[name]


@pytest.fixture
def described(monkeypatch):
    """Actions of the launch file, by the names of their classes."""
    for module in ("launch", "launch.actions", "launch.event_handlers", "launch.events", "launch_ros.actions"):
        monkeypatch.setitem(sys.modules, module, StandIn(module))
    of_context = SimpleNamespace(LaunchConfiguration=lambda name: SimpleNamespace(perform=lambda given: given[name]))
    monkeypatch.setitem(sys.modules, "launch.substitutions", of_context)
    return by_kind(runpy.run_path(str(PACKAGE / "launch" / "arena.launch.py"))["generate_launch_description"]())


def by_kind(actions):
    found = {}
    for one in actions:
        found.setdefault(type(one).__name__, []).append(one)
    return found


@pytest.fixture
def arguments(described):
    """Arguments of the launch file with their defaults."""
    return {one.words[0]: one.fields.get("default_value", "mine") for one in described["DeclareLaunchArgument"]}


@pytest.fixture
def launched(described, arguments):
    """Gives the arena's command, the variables of both processes, and the node's parameters."""

    def launch(**given):
        (begin,) = described["OpaqueFunction"]
        actions = by_kind(begin.fields["function"](arguments | given))
        variables = dict(one.words for one in actions.get("SetEnvironmentVariable", ()))
        return actions["ExecuteProcess"][0].fields["cmd"], variables, actions["Node"][0].fields["parameters"]

    return launch


def test_its_service_is_the_one_that_we_serve():
    """Request and response."""
    request, response = (PACKAGE / "srv" / "CatchTurtle.srv").read_text(encoding="utf-8").split("---\n")
    for text, kind in ((request, TYPES.catch_turtle.request), (response, TYPES.catch_turtle.response)):
        assert [line for line in text.splitlines() if not line.startswith("#")] == kind.definition.splitlines()


@pytest.mark.parametrize(("speed", "simulated"), [("", False), ("1", False), ("1.0", False), ("5", True)])
def test_the_node_goes_by_the_arenas_clock_where_there_is_one(launched, speed, simulated):
    """Without /clock its timers would never fire."""
    assert launched(speed=speed)[2] == [{"use_sim_time": simulated}]


def test_the_launch_file_passes_on_what_it_is_given_and_nothing_else(launched):
    """Both processes are in one domain and use one middleware."""
    assert launched()[:2] == (["catch-arena", "ros", "serve"], {})
    assert launched(bus="cyclonedds")[1] == {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}
    given = {"scenario": "duel", "record": "a.replay", "bus": "rosbridge", "domain": "7", "seed": "3", "speed": "2.0"}
    command, variables, _ = launched(seats="0=ros:anna 1=patrol", **given)
    assert " ".join(command) == (
        "catch-arena ros serve --seat 0=ros:anna --seat 1=patrol --scenario duel --seed 3 --speed 2.0 "
        "--bus rosbridge --record a.replay"
    )
    assert variables == {"ROS_DOMAIN_ID": "7"}
