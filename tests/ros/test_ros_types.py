"""A student's interface package is used as it is, or an error names what it lacks."""

from types import SimpleNamespace

import pytest

from catch_arena.errors import BusError
from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse, Turtle, TurtleArray
from catch_arena.ros.middleware import ros_types
from catch_arena.ros.middleware.bus import Endpoint
from catch_arena.ros.middleware.interfaces import INTERFACES, Interfaces, from_attributes
from catch_arena.ros.middleware.rclpy_bus import to_ros
from catch_arena.ros.middleware.ros_types import (
    describe_type,
    fitting_packages,
    found_types,
    package_types,
    turtlesim_package,
)

USUAL = {
    "msg": {
        "Turtle": {"name": "string", "x": "double", "y": "double", "theta": "double"},
        "TurtleArray": {"turtles": "sequence<mine/Turtle>"},
    },
    "srv": {"CatchTurtle": ({"name": "string"}, {"success": "boolean"})},
}


VARIANTS = {
    "the exercise's": (USUAL["msg"], USUAL["srv"]),
    "other names of fields": (
        {
            "Turtle": {"turtle_name": "string", "x": "float", "y": "float", "theta": "float", "age": "int32"},
            "TurtleArray": {"list": "sequence<mine/Turtle>"},
        },
        {"CatchTurtle": ({"id": "string"}, {"sucess": "boolean", "message": "string"})},
    ),
    "other names of types": (
        {"Info": {"name": "string", "x": "double", "y": "double"}, "Infos": {"arr": "sequence<mine/Info>"}},
        {"Catch": ({"name": "string", "x": "double"}, {"success": "boolean"}), "Other": ({"a": "int64"}, {})},
    ),
    "two texts, one of them the usual": (
        {
            "Turtle": {"kind": "string", "name": "string", "x": "double", "y": "double"},
            "TurtleArray": {"names": "sequence<string>", "turtles": "sequence<mine/Turtle>"},
        },
        {"CatchTurtle": ({"by": "string", "name": "string"}, {"late": "boolean", "success": "boolean"})},
    ),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_a_package_is_taken_as_it_is(package, name):
    package("mine", *VARIANTS[name])
    types = package_types("mine", Interfaces())
    turtles = TurtleArray((Turtle("t1", 1.5, 2.5, 0.5), Turtle("t2", 3.0, 4.0, -1.0)))
    listed = to_ros(types.turtle_array, turtles, ros_types.ros_class(types.turtle_array.name)())
    has_theta = "theta" in vars(ros_types.ros_class(types.turtle.name)())
    expected = tuple(one if has_theta else one._replace(theta=0.0) for one in turtles.turtles)
    assert from_attributes(types.turtle_array, listed).turtles == expected
    service = ros_types.ros_class(types.catch_turtle.name)
    request = to_ros(types.catch_turtle.request, CatchTurtleRequest("t1"), service.Request())
    assert "t1" in vars(request).values()
    assert from_attributes(types.catch_turtle.request, request) == CatchTurtleRequest("t1")
    response = to_ros(types.catch_turtle.response, CatchTurtleResponse(success=True), service.Response())
    assert list(vars(response).values()).count(True) == 1
    assert from_attributes(types.catch_turtle.response, response) == CatchTurtleResponse(success=True)


def test_fields_may_stand_in_a_message_and_an_answer_may_have_none(package):
    msg = {
        "Place": {"x": "float", "y": "float"},
        "Turtle": {"at": "mine/Place", "name": "string"},
        "TurtleArray": {"turtlearray": "sequence<mine/Turtle>"},
    }
    package(
        "mine", msg, {"Catch": ({"turtle": "mine/Turtle"}, {}), "SetLed": ({"state": "string"}, {"success": "boolean"})}
    )
    types = package_types("mine", Interfaces())
    listed = to_ros(types.turtle_array, TurtleArray((Turtle("t1", 1.5, 2.5, 0.5),)), SimpleNamespace())
    assert (listed.turtlearray[0].name, vars(listed.turtlearray[0].at)) == ("t1", {"x": 1.5, "y": 2.5})
    service = ros_types.ros_class("mine/srv/Catch")
    request = to_ros(types.catch_turtle.request, CatchTurtleRequest("t1"), service.Request())
    assert request.turtle.name == "t1"
    assert from_attributes(types.catch_turtle.request, request) == CatchTurtleRequest("t1")
    assert vars(to_ros(types.catch_turtle.response, CatchTurtleResponse(success=True), service.Response())) == {}
    assert describe_type(types.catch_turtle) == "string turtle.name -> no field"


def test_what_a_node_uses_decides_between_types_of_one_package(package):
    package("mine", USUAL["msg"], dict.fromkeys(("CatchTurtle", "CatchIt"), USUAL["srv"]["CatchTurtle"]))
    found = package_types("mine", Interfaces(), catch="mine/srv/CatchIt")
    assert (found.catch_turtle.name, found.turtle_array.name) == ("mine/srv/CatchIt", "mine/msg/TurtleArray")


@pytest.mark.parametrize(
    ("msg", "srv", "why"),
    [
        (
            USUAL["msg"],
            {"CatchTurtle": ({"one": "string", "two": "string"}, {"success": "boolean"})},
            "mine/srv/CatchTurtle_Request has string one, string two: it needs one text named name, or only one text",
        ),
        (
            USUAL["msg"],
            {"CatchTurtle": ({"name": "string"}, {"success": "string"})},
            "mine/srv/CatchTurtle_Response has string success: it needs one bool named success, or only one bool",
        ),
        (
            {**USUAL["msg"], "Turtle": {"name": "string", "coordinates": "sequence<double>"}},
            USUAL["srv"],
            "mine/msg/Turtle has string name, sequence<double> coordinates: it needs one real number named x",
        ),
        (
            USUAL["msg"],
            {"Catch": USUAL["srv"]["CatchTurtle"], "KillTurtle": USUAL["srv"]["CatchTurtle"]},
            "mine: CatchTurtle could be mine/srv/Catch and mine/srv/KillTurtle",
        ),
        (USUAL["msg"], {}, "mine/srv has no type that fits CatchTurtle"),
    ],
)
def test_what_is_missing_or_ambiguous_is_told_with_what_the_file_holds(package, msg, srv, why):
    package("mine", msg, srv)
    with pytest.raises(BusError) as error:
        package_types("mine", Interfaces())
    assert str(error.value).startswith(why)
    assert f"build {'the package' if ' has ' in why else 'mine'} again" in str(error.value)


def test_a_package_that_is_not_built_is_one_line():
    with pytest.raises(BusError, match=r"^none_such has no srv that this Python can import: build your package"):
        package_types("none_such", Interfaces())


@pytest.mark.parametrize(
    ("there", "found"),
    [
        (["mine", "example"], ["mine"]),
        (["mine", "yours"], ["mine", "yours"]),
        (["mine", "my_robot_interfaces"], ["my_robot_interfaces"]),
        (["mine", "catch_arena_interfaces"], ["mine"]),
        (["catch_arena_interfaces"], ["catch_arena_interfaces"]),
    ],
)
def test_packages_that_fit_are_found_and_ours_only_if_no_other_does(package, monkeypatch, there, found):
    for name in there:
        msg = {word: {a: b.replace("mine", name) for a, b in fields.items()} for word, fields in USUAL["msg"].items()}
        package(name, msg if name != "example" else {}, USUAL["srv"])
    monkeypatch.setattr(ros_types, "_packages", lambda: iter(there))
    assert list(fitting_packages(Interfaces())) == found


def test_where_none_fits_one_line_says_how_to_see_why(package, monkeypatch):
    package("mine", USUAL["msg"], {"CatchTurtle": ({"id": "int64"}, {"success": "boolean"})})
    monkeypatch.setattr(ros_types, "_packages", lambda: iter(["mine"]))
    with pytest.raises(BusError, match=r"^no package with the types of my_robot_interfaces is sourced: build your .* "):
        fitting_packages(Interfaces())
    with pytest.raises(BusError, match=r"^mine/srv/CatchTurtle_Request has int64 id: it needs one text named name, or"):
        found_types(Interfaces("mine"), list)
    msg = {word: {a: b.replace("mine", INTERFACES) for a, b in fields.items()} for word, fields in USUAL["msg"].items()}
    package(INTERFACES, msg, {"CatchTurtle": ({"id": "int64"}, {"success": "boolean"})})
    monkeypatch.setattr(ros_types, "_packages", lambda: iter([INTERFACES]))
    with pytest.raises(BusError, match=rf"^{INTERFACES}/srv/CatchTurtle_Request has int64 id: "):
        fitting_packages(Interfaces())


def test_the_types_that_a_node_uses_come_before_those_of_packages(package, monkeypatch):
    """If several packages fit and no node runs, one must be named."""
    for name in ("a", "b"):
        msg = {
            word: {one: of.replace("mine", name) for one, of in fields.items()} for word, fields in USUAL["msg"].items()
        }
        package(name, msg, USUAL["srv"])
    monkeypatch.setattr(ros_types, "_packages", lambda: iter(["a", "b"]))
    monkeypatch.setattr(ros_types, "_LOOK_S", 0.0)
    used = [Endpoint("/mine", "client", "/catch_turtle", "b/srv/CatchTurtle")]
    assert found_types(Interfaces(), lambda: used).package == "b"
    assert found_types(Interfaces("a"), lambda: used).package == "a"
    with pytest.raises(BusError, match=r"^several packages have a catch service: a, b; choose one"):
        found_types(Interfaces(), list)


def test_turtlesim_has_another_package_from_kilted_on(package):
    assert turtlesim_package("turtlesim") == "turtlesim"
    package("turtlesim_msgs", {"Pose": {"x": "float"}}, {})
    assert turtlesim_package("turtlesim") == "turtlesim_msgs"
    package("turtlesim", {"Pose": {"x": "float"}}, {})
    assert turtlesim_package("turtlesim") == "turtlesim"
