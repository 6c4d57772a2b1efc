"""The back-end that goes through ROS's own library, with a stand-in for the part of rclpy that it uses."""

import math
import sys
from types import ModuleType, SimpleNamespace

import pytest

from catch_arena.errors import BusError
from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse, Turtle, TurtleArray
from catch_arena.ros.middleware import opening, rclpy_bus
from catch_arena.ros.middleware.bus import Endpoint
from catch_arena.ros.middleware.interfaces import RULING, TWIST, Interfaces, TwistMessage
from catch_arena.ros.middleware.opening import open_bus
from catch_arena.ros.middleware.parameters import spawner_parameters

TYPES = Interfaces()


class Future:
    """rclpy.task.Future, as far as it goes: it may be waited for in a coroutine."""

    def __init__(self, *, executor=None):
        del executor
        self.value, self.is_set, self.callbacks = None, False, []

    def set_result(self, value):
        self.value, self.is_set = value, True
        for callback in self.callbacks:
            callback(self)

    def result(self):
        return self.value

    def add_done_callback(self, callback):
        self.callbacks.append(callback)

    def __await__(self):
        while not self.is_set:
            yield
        return self.value


class Group:
    """rclpy.callback_groups.ReentrantCallbackGroup: in another kind an unanswered request keeps all else waiting."""


class Executor:
    """Does one thing at a time, and goes on with a coroutine in each turn."""

    def __init__(self, context):
        self.context, self.tasks = context, []

    def add_node(self, node):
        node.executor = self

    def spin_once(self, timeout_sec):
        assert timeout_sec >= 0
        for task in list(self.tasks):
            try:
                task.send(None)
            except StopIteration:
                self.tasks.remove(task)
                return
        if self.context.waiting:
            act = self.context.waiting.pop(0)
            act()

    def shutdown(self):
        self.context.over = True


class Node:
    """A ROS graph of one process, which the context holds."""

    def __init__(self, name, context):
        self.name, self.context = name, context

    def create_publisher(self, kind, topic, depth):
        assert depth == 10
        self.context.publishers.setdefault(topic, []).append(self)

        def publish(message):
            assert isinstance(message, kind)
            for callback in self.context.heard.get(topic, ()):
                self.context.waiting.append(lambda callback=callback: callback(message))

        return SimpleNamespace(publish=publish)

    def create_subscription(self, kind, topic, callback, depth, callback_group):
        assert isinstance(callback_group, Group)
        assert kind is not None
        assert depth == 10
        self.context.heard.setdefault(topic, []).append(callback)

    def create_service(self, kind, service, callback, callback_group):
        assert isinstance(callback_group, Group)
        self.context.served[service] = kind, callback

    def create_client(self, kind, service, callback_group):
        assert isinstance(callback_group, Group)

        def call_async(request):
            served, callback = self.context.served[service]
            assert served is kind
            future = Future()

            async def execute():
                future.set_result(await callback(request, kind.Response()))

            self.context.waiting.append(lambda: self.executor.tasks.append(execute()))
            return future

        return SimpleNamespace(call_async=call_async, service_is_ready=lambda: service in self.context.served)

    def declare_parameter(self, name, value, descriptor):
        self.context.parameters[name] = value, descriptor

    def add_on_set_parameters_callback(self, callback):
        self.context.on_set = callback

    def count_publishers(self, topic):
        return len(self.context.publishers.get(topic, ()))

    def destroy_node(self):
        self.context.destroyed = True


class Context:
    def __init__(self):
        self.heard, self.served, self.waiting, self.publishers = {}, {}, [], {}
        self.parameters = {}

    def try_shutdown(self):
        self.shut = True


@pytest.fixture
def joined(monkeypatch, package):
    """On a bus of the stand-in's."""
    begun = []
    ros = {
        "rclpy": {
            "Context": Context,
            "init": lambda context, domain_id: begun.append((context, domain_id)),
            "create_node": Node,
            "get_rmw_implementation_identifier": lambda: "rmw_of_a_test",
        },
        "rclpy.node": {},
        "rclpy.executors": {"SingleThreadedExecutor": Executor},
        "rclpy.task": {"Future": Future},
        "rclpy.callback_groups": {"ReentrantCallbackGroup": Group},
        "rcl_interfaces": {},
        "rcl_interfaces.msg": {"ParameterDescriptor": SimpleNamespace, "SetParametersResult": SimpleNamespace},
    }
    for name, content in ros.items():
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
        vars(sys.modules[name]).update(content)
    vector = "geometry_msgs/Vector3"
    package(
        "geometry_msgs",
        {"Vector3": dict.fromkeys("xyz", "double"), "Twist": {"linear": vector, "angular": vector}},
        {},
    )
    package(
        "my_robot_interfaces",
        {"Turtle": {"name": "string"}, "TurtleArray": {"turtles": "sequence<my_robot_interfaces/Turtle>"}},
        {"CatchTurtle": ({"name": "string"}, {"success": "boolean"})},
    )
    made = open_bus("rclpy", node="arena", domain=7)
    assert begun[0][1] == 7
    yield made
    made.close()


def test_topics_go_through_ross_own_messages(joined):
    """Nested ones and sequences too."""
    heard = []
    joined.subscribe("/a", TWIST, heard.append)
    joined.subscribe("/b", TYPES.turtle_array, heard.append)
    joined.publisher("/a", TWIST)(TwistMessage.of(1.0, 2.0))
    turtles = TurtleArray((Turtle("a", 1.0, 2.0, 3.0), Turtle("b", 1.0, 2.0, 3.0)))
    joined.publisher("/b", TYPES.turtle_array)(turtles)
    joined.spin()

    assert heard == [TwistMessage.of(1.0, 2.0), turtles]
    assert [joined.publishers_of(topic) for topic in ("/a", "/c")] == [1, 0]
    assert joined.about == "rmw_of_a_test"


def test_the_types_that_a_node_uses_come_before_those_of_packages(joined, monkeypatch):
    monkeypatch.setattr(rclpy_bus, "fitting_packages", lambda given: {"a": given, "b": given})
    monkeypatch.setattr(rclpy_bus, "package_types", lambda *names, **used: (names[0], used))
    graph = [Endpoint("/mine", "client", "/catch_turtle", "mine/srv/CatchIt")]
    monkeypatch.setattr(joined, "graph", lambda: graph)
    assert joined.interfaces(TYPES) == ("mine", {"turtles": "", "catch": "mine/srv/CatchIt"})
    graph.clear()
    assert joined.interfaces(TYPES)[0] == "mine"  # it keeps what its topics were made with


def test_of_several_packages_one_must_be_named(joined, monkeypatch):
    monkeypatch.setattr(rclpy_bus, "fitting_packages", lambda given: {"a": given, "b": given})
    monkeypatch.setattr(rclpy_bus, "_LOOK_S", 0.0)
    monkeypatch.setattr(joined, "graph", list)
    with pytest.raises(BusError, match=r"^a and b have a catch service each$") as error:
        joined.interfaces(TYPES)
    assert error.value.hint == "give --interfaces a, or another"


def test_another_node_of_our_name_is_seen_and_we_are_not(joined, monkeypatch):
    """As a second arena in the domain. Each node of one name is seen, and whether its fields are ours."""

    def end(name, fields="ours"):
        return SimpleNamespace(
            node_name=name, node_namespace="/", topic_type="turtlesim/msg/Pose", topic_type_hash=fields
        )

    graph = {"publishers": [end("mine"), end("arena"), end("mine", "others")], "subscriptions": [end("mine")]}
    names = [("arena", "/"), ("mine", "/")]
    changes = {
        "get_name": lambda: "arena",
        "get_namespace": lambda: "/",
        "get_topic_names_and_types": lambda: [("/a", ["turtlesim/msg/Pose"])],
        "get_publishers_info_by_topic": lambda _: graph["publishers"],
        "get_subscriptions_info_by_topic": lambda _: graph["subscriptions"],
        "get_node_names_and_namespaces": lambda: names,
        "get_service_names_and_types_by_node": lambda name, _: [("/s", [f"{name}s"])],
        "get_client_names_and_types_by_node": lambda *_: [],
    }
    for name, value in changes.items():
        monkeypatch.setattr(joined._node, name, value, raising=False)
    mine = Endpoint("/mine", "publisher", "/a", "turtlesim/msg/Pose")
    heard = mine._replace(kind="subscription")
    seen = [mine, mine._replace(fields_differ=True), heard, Endpoint("/mine", "service", "/s", "mines")]
    assert joined.graph() == seen
    names.append(("arena", "/"))
    graph["publishers"].append(end("arena"))
    assert {one.node for one in joined.graph()} == {"/mine", "/arena"}


def test_a_service_is_answered_at_once_or_later(joined):
    """Several may wait, and those who ask later are heard meanwhile; answers leave together, before what is published
    next.
    """
    asked = []
    joined.serve("/catch_turtle", TYPES.catch_turtle, asked.append)
    client = joined.client("/catch_turtle", TYPES.catch_turtle)
    assert client.ready
    calls = [client.call(CatchTurtleRequest(name)) for name in "abc"]
    joined.spin()

    assert [one.message.name for one in asked] == ["a", "b", "c"]
    assert [call.response for call in calls] == [None, None, None]

    publish, told = joined.publisher("/a", TWIST), []
    joined.subscribe("/a", TWIST, lambda *_: told.append([call.response for call in calls]))
    asked[1].answer(CatchTurtleResponse(True))
    publish(TwistMessage.of(1.0, 2.0))
    assert [call.response for call in calls] == [None, CatchTurtleResponse(True), None]
    asked[0].answer(CatchTurtleResponse(False))
    asked[2].answer(CatchTurtleResponse(False))
    publish(TwistMessage.of(1.0, 2.0))
    assert [call.response.success for call in calls] == [False, True, False]
    joined.spin()
    assert len(told) == 2


def test_parameters_are_the_nodes_own(joined):
    """ROS serves them; what is set is asked of us first, and what the node has besides is none of ours."""
    parameters = spawner_parameters(0.5, "bob_")
    joined.declare(parameters)
    declared = joined._context.parameters
    assert {name: value for name, (value, _) in declared.items()} == {
        "spawn_frequency": 0.5,
        "turtle_name_prefix": "bob_",
    }
    assert [descriptor.read_only for _, descriptor in declared.values()] == [False, True]

    def change(*changes):
        result = joined._context.on_set([SimpleNamespace(name=name, value=value) for name, value in changes])
        return result.successful, getattr(result, "reason", "")

    assert change(("use_sim_time", True)) == (True, "")
    assert change(("use_sim_time", True), ("spawn_frequency", 4.0)) == (True, "")
    assert parameters["spawn_frequency"].value == 4.0
    done, reason = change(("spawn_frequency", math.nan))
    assert not done
    assert reason.startswith("spawn_frequency: ")
    assert change(("spawn_frequency", 2)) == (False, "spawn_frequency must be a double, as 2.0, got 2")
    assert parameters["spawn_frequency"].value == 4.0


def test_a_package_that_is_not_built_is_one_line(joined):
    """Ours may be missing where a student has only their own."""
    with pytest.raises(BusError, match="build catch_arena_interfaces with colcon, and source it"):
        joined.publisher("/rulings", RULING)


def test_without_ros_it_says_so_in_one_line(monkeypatch):
    """It may be found, and its libraries not."""
    monkeypatch.setattr(opening, "_import_fault", lambda _: "")
    monkeypatch.setitem(sys.modules, "rclpy", None)
    with pytest.raises(BusError, match=r"rclpy cannot be loaded .*: source ROS first"):
        open_bus("rclpy")
