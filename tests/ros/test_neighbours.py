"""A node with other names, other types or a second referee gets a line that says what to change."""

import pytest
from ros.local import Hub, LocalBus

from catch_arena.errors import BusError
from catch_arena.ros.doctor import examine
from catch_arena.ros.middleware.bus import Endpoint
from catch_arena.ros.middleware.interfaces import Interfaces
from catch_arena.ros.nodes.neighbours import Neighbours

TYPES = Interfaces()
TWIST, POSE = "geometry_msgs/msg/Twist", "turtlesim/msg/Pose"
LIST, CATCH = TYPES.turtle_array.name, TYPES.catch_turtle.name
PLAYER = [
    Endpoint("/turtle_controller", "publisher", "/turtle1/cmd_vel", TWIST),
    Endpoint("/turtle_controller", "subscription", "/turtle1/pose", POSE),
    Endpoint("/turtle_controller", "subscription", "/alive_turtles", LIST),
    Endpoint("/turtle_controller", "client", "/catch_turtle", CATCH),
]


def lines(graph, driven=("hunter_0",)):
    log_lines = []
    watch = Neighbours(["hunter_0", "hunter_1"], driven, TYPES, log_lines.append)
    for _ in range(2):  # each is told once
        watch.look(graph)
    assert watch.seen == tuple(sorted({one.node for one in graph}))
    return log_lines


def test_a_node_of_the_exercise_is_no_news():
    assert lines(PLAYER) == []


@pytest.mark.parametrize(
    ("endpoint", "does", "what"),
    [
        (("publisher", "/alive_turtles", LIST), "publishes /alive_turtles", "a spawner"),
        (("service", "/catch_turtle", CATCH), "serves /catch_turtle", "a spawner"),
        (("publisher", "/turtle1/pose", POSE), "publishes /turtle1/pose", "turtlesim or a second arena"),
        (("publisher", "/hunter_1/pose", POSE), "publishes /hunter_1/pose", "turtlesim or a second arena"),
        (("service", "/spawn", "turtlesim/srv/Spawn"), "serves /spawn", "turtlesim or a second arena"),
    ],
)
def test_a_second_referee_is_named_with_the_command_for_the_controller_alone(endpoint, does, what):
    (line,) = lines([*PLAYER, Endpoint("/other", *endpoint)])
    assert line == (
        f"warning: /other {does}, as the arena does: two referees in one domain. It looks like {what}: end it, and "
        "start your controller alone: ros2 run YOUR_PACKAGE YOUR_CONTROLLER"
    )


def test_other_names_get_the_remapping_to_type():
    graph = [
        Endpoint("/bot", "publisher", "/autobot/cmd_vel", TWIST),
        Endpoint("/bot", "subscription", "/autobot/pose", POSE),
        Endpoint("/bot", "subscription", "/turtles", LIST),
        Endpoint("/bot", "client", "/catch_turtles", CATCH),
    ]
    (line,) = lines(graph, ("hunter_0", "hunter_1"))
    assert line == (
        "warning: /bot uses /autobot/cmd_vel and /autobot/pose and /turtles and /catch_turtles, which no node serves "
        "here: start it with --ros-args -r /autobot/cmd_vel:=/hunter_0/cmd_vel -r /autobot/pose:=/hunter_0/pose "
        "-r /turtles:=/alive_turtles -r /catch_turtles:=/hunter_0/catch_turtle"
    )
    (line,) = lines(graph)
    assert line.endswith("-r /turtles:=/alive_turtles -r /catch_turtles:=/catch_turtle")
    assert lines(graph[2:]) == []  # the list and the service are then served under both names


def test_a_type_of_our_name_with_other_fields_is_told():
    """Both packages have the course's name, and one has float32."""
    (line,) = lines([*PLAYER[:2], Endpoint("/mine", "subscription", "/alive_turtles", LIST, fields_differ=True)])
    assert line.startswith(f"warning: /mine has other fields in {LIST} than the arena, on /alive_turtles: ")
    assert line.endswith("Source the same my_robot_interfaces in both terminals")


def test_a_node_with_another_package_is_told_which_one_to_give():
    (line,) = lines([*PLAYER[:2], Endpoint("/mine", "subscription", "/alive_turtles", "other_msgs/msg/Turtles")])
    assert line.endswith("Start the arena again with --interfaces other_msgs")


class Bus(LocalBus):
    backend = "rclpy"
    middleware = "rmw_fastrtps_cpp"

    def __init__(self, graph, fault=None):
        super().__init__(Hub(), "doctor")
        self.endpoints, self.fault = graph, fault

    def graph(self):
        return self.endpoints

    def interfaces(self, given):
        if self.fault:
            raise BusError(self.fault)
        return given


def test_the_doctor_says_what_is_there_and_for_each_problem_what_to_do(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    monkeypatch.delenv("ROS_AUTOMATIC_DISCOVERY_RANGE", raising=False)
    facts, problems = examine(Bus(PLAYER), TYPES, 0.0)
    assert problems == []
    assert facts[0].endswith("rclpy with rmw_fastrtps_cpp")
    assert "ROS_DOMAIN_ID=7" in facts
    assert "ROS_AUTOMATIC_DISCOVERY_RANGE is not set" in facts
    assert "interfaces: my_robot_interfaces/srv/CatchTurtle: string name -> bool success" in facts
    assert facts[-1].startswith(
        "node /turtle_controller: publishes /turtle1/cmd_vel (geometry_msgs/msg/Twist), subscribes to "
    )

    problems = examine(Bus(PLAYER, "my package is not built: build it"), TYPES, 0.0)[1]
    assert problems == ["my package is not built: build it"]
    assert examine(Bus([]), TYPES, 0.0)[1][0].startswith("no other node was found: start yours; ")
    spawner = Endpoint("/turtle_spawner", "service", "/catch_turtle", CATCH)
    assert examine(Bus([*PLAYER, spawner]), TYPES, 0.0)[1][0].startswith("/turtle_spawner serves /catch_turtle, as ")
    arena = Endpoint("/catch_arena", "publisher", "/turtle1/pose", POSE)
    assert examine(Bus([*PLAYER, arena]), TYPES, 0.0)[1] == []
    assert examine(Bus([arena]), TYPES, 0.0)[1][0].startswith("no other node was found: ")


@pytest.mark.parametrize("backend", ["cyclonedds", "rosbridge"])
def test_the_doctor_says_what_works_over_a_bus_that_does_not_list_nodes(backend, monkeypatch):
    bus = Bus(None)
    monkeypatch.setattr(bus, "backend", backend)
    if backend == "rosbridge":
        monkeypatch.setattr(bus, "publishers_of", lambda _: None)
    facts, problems = examine(bus, TYPES, 0.0)
    works, missing = facts[-2:]
    assert works.startswith(f"works over {backend}: matches with nodes ")
    assert missing.startswith(f"does not work over {backend}: a list of the nodes, ")
    if backend == "rosbridge":
        assert problems == []
        return
    assert [line.startswith("no node publishes /turtle1/cmd_vel, or ") for line in problems] == [True]
    bus.publisher("/hunter_1/cmd_vel", TWIST)
    facts, problems = examine(bus, TYPES, 0.0)
    assert (facts[-1], problems) == ("publishers of /hunter_1/cmd_vel: 1", [])
