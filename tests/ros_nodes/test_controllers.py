"""Controllers of the exercise play with real rclpy and the documented `ros serve`."""

import re

import pytest

pytestmark = pytest.mark.rclpy
ANNA = ("--seat", "0=ros:anna", "--seat", "1=patrol")
ALONE = ("--seat", "0=ros:anna")
OTHER_WORDS = ("turtle_hunt_interfaces", "TurtleInfoArray", "list", "turtle_name", "turtle_killed")


@pytest.fixture
def course(bus_with):
    """A student's machine: the exercise's own package."""
    return bus_with("my_robot_interfaces")


@pytest.mark.parametrize(
    "choices",
    [
        "--target nearest --stop 0.5 --hz 10",
        "--target first --stop 0.05 --hz 100 --new-client",
        "--target first --stop 0.3 --hz 100 --answers threads",
        "--target first --stop 0.3 --hz 100 --answers spin",
        "--target nearest --stop 0.3 --hz 2 --new-client",
        "--target nearest --hasty --pen",
    ],
)
def test_a_controller_plays_with_the_documented_command(course, choices):
    """Whatever it drives to, and however it asks: alone it catches all that there is, which ends the match."""
    arena = course.serve(*ALONE, "--set", "target_budget=2")
    node = course.node("controller", *choices.split())
    code, printed = arena.finish()
    assert code == 0, printed
    assert re.search(r"^bus: rclpy, .* rmw_fastrtps_cpp, .* interfaces of my_robot_", printed, re.MULTILINE)
    assert re.search(r"^\s*1\s+2\s+anna ", printed, re.MULTILINE)
    assert "Traceback" not in printed
    node.wait_for("^caught target_turtle_", times=2)
    code, printed = node.end()
    assert code == 0, printed


def test_a_package_with_other_words_is_found_by_itself(bus_with):
    """Names, types and fields differ, numbers have 32 bits, and a field is missing."""
    bus = bus_with("turtle_hunt_interfaces")
    arena = bus.serve(*ANNA)
    bus.node("controller", "--types", *OTHER_WORDS).wait_for("^caught")
    assert "interfaces of turtle_hunt_interfaces" in arena.text


def test_a_package_with_two_lists_is_refused_before_the_match(bus_with):
    """The line says what the file holds, and what is missing."""
    package = "two_lists_interfaces"
    code, printed = bus_with(package).serve(*ANNA, "--interfaces", package, waits=False).finish()
    assert code == 2
    assert "error: two_lists_interfaces/msg/TurtleArray " in printed
    assert "alive" in printed
    assert "Traceback" not in printed


def test_a_spawner_next_to_the_arena_is_named(course):
    """Two nodes would answer each request."""
    arena = course.serve(*ANNA)
    course.node("referee")
    line = arena.wait_for("^warning: /turtle_spawner ").string
    assert "serves /catch_turtle" in line
    assert "publishes /alive_turtles" in line
    assert "ros2 run" in line


def test_answers_may_come_later_and_leave_before_the_next_message(course):
    """R8.4, in a process that has two of our buses."""
    code, printed = course.node("buses").finish()
    assert (code, printed.splitlines()[-1:]) == (0, ["right"]), printed


def test_another_turtle_and_service_play_with_the_line_that_is_printed(course):
    arena = course.serve(*ANNA)
    words = ("--turtle", "autobot", "--service", "catch_turtles")
    node = course.node("controller", *words)
    remapping = arena.wait_for(r"^warning: /turtle_controller uses .*(--ros-args.* -r /catch_turtles:=\S+.*)")[1]
    node.end()
    course.node("controller", *words, *remapping.split()).wait_for("^caught")


def test_a_node_that_dies_and_returns_plays_on(course):
    """The arena says both."""
    arena = course.serve(*ANNA)
    node = course.node("controller")
    node.wait_for("^caught")
    node.kill()
    arena.wait_for("^hunter_0: its node (is silent|has gone)")
    course.node("controller").wait_for("^caught")
    arena.wait_for("^hunter_0: its node is back")


def test_four_nodes_play_with_the_lines_that_are_printed(course):
    """Each seat's line has the remapping of its node; one dies and is started again."""
    names = ("anna", "ben", "cleo", "dan")
    seats = [word for seat, name in enumerate(names) for word in ("--seat", f"{seat}=ros:{name}")]
    arena = course.serve(*seats, "--set", "target_budget=40")
    lines = [arena.wait_for(rf"^waiting for {name} on .*(--ros-args .*)")[1].split() for name in names]
    nodes = [course.node("controller", *line) for line in lines]
    for node in nodes:
        node.wait_for("^caught")
    nodes[0].kill()
    nodes[0] = course.node("controller", *lines[0])
    nodes[0].wait_for("^caught")
    code, printed = arena.finish()
    assert code == 0, printed


def test_doctor_names_the_node_and_the_fields(bus_with):
    """On a busy machine the doctor's three seconds may not be enough, so it is run again."""
    bus = bus_with("turtle_hunt_interfaces")
    bus.node("controller", "--types", *OTHER_WORDS)
    looks = (bus.command("ros", "doctor").finish()[1] for _ in range(10))
    printed = next(text for text in looks if "node /turtle_controller: " in text)
    assert "turtle_hunt_interfaces/srv/CatchTurtle: string turtle_name -> boolean turtle_killed" in printed
