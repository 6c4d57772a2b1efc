"""Messages and services have the bytes of ROS's wire format, which are written out here."""

import pytest

from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse, Pose, Turtle, TurtleArray
from catch_arena.ros.middleware import dds_bus
from catch_arena.ros.middleware.interfaces import (
    CLOCK,
    EMPTY,
    TWIST,
    Clock,
    Empty,
    Interfaces,
    Name,
    SpawnRequest,
    Time,
    TwistMessage,
    from_attributes,
)
from catch_arena.ros.middleware.typestore import type_hash

TYPES = Interfaces()
HEADER = {"client": 0x0102030405060708, "number": 5}
BEGIN = "00010000 0807060504030201 0500000000000000"


def encoded(kind, message, **header):
    return dds_bus.to_sample(kind, message, **header).serialize(use_version_2=False)


def decoded(kind, data, *, header=False):
    sample = dds_bus.idl_struct(kind).deserialize(data)
    message = from_attributes(kind, sample)
    return (message, sample.client, sample.number) if header else message


@pytest.mark.parametrize(
    ("kind", "message", "expected"),
    [
        (TYPES.pose, Pose(1.0, 2.0, -0.5, 0.25, 0.0), "00010000 0000803f 00000040 000000bf 0000803e 00000000"),
        (
            TWIST,
            TwistMessage.of(1.5, -2.0),
            """00010000 000000000000f83f 0000000000000000 0000000000000000
            0000000000000000 0000000000000000 00000000000000c0""",
        ),
        (TYPES.turtle_array, TurtleArray(()), "00010000 00000000"),
        (
            TYPES.turtle_array,
            TurtleArray((Turtle("ab", 1.0, 2.0, 3.0), Turtle("", 0.0, 0.0, -1.0))),
            """00010000 02000000 03000000 616200 0000000000
            000000000000f03f 0000000000000040 0000000000000840
            01000000 00 000000 0000000000000000 0000000000000000 000000000000f0bf""",
        ),
        (CLOCK, Clock(Time(3, 16_000_000)), "00010000 03000000 0024f400"),
    ],
)
def test_messages_are_these_bytes(kind, message, expected):
    """Four bytes in front, then each number at a multiple of its size, counted from behind them."""
    assert encoded(kind, message) == bytes.fromhex(expected)
    assert decoded(kind, bytes.fromhex(expected)) == message


@pytest.mark.parametrize(
    ("kind", "message", "expected"),
    [
        (TYPES.catch_turtle.request, CatchTurtleRequest("t1"), "03000000 743100"),
        (TYPES.catch_turtle.response, CatchTurtleResponse(True), "01"),
        (TYPES.spawn.request, SpawnRequest(1.0, 2.0, 0.5, "x"), "0000803f 00000040 0000003f 02000000 7800"),
        (TYPES.spawn.response, Name("x"), "02000000 7800"),
        (TYPES.kill.request, Name(""), "01000000 00"),
        (TYPES.kill.response, Empty(), "00"),
        (EMPTY.request, Empty(), "00"),
        (EMPTY.response, Empty(), "00"),
    ],
)
def test_requests_and_responses_begin_with_the_client_and_a_number(kind, message, expected):
    """Eight bytes each; what has no fields has one byte, as ROS's has."""
    expected = bytes.fromhex(BEGIN + expected)

    assert encoded(kind, message, **HEADER) == expected
    assert decoded(kind, expected, header=True) == (message, *HEADER.values())


def test_hashes_of_types_are_those_that_ros_announces():
    """Two of them are known."""
    assert type_hash(TYPES.pose) == "RIHS01_739beba26bcba6920404ba722b7b8321348512f92ea5be235c47251940dd8aa9"
    assert type_hash(TWIST).startswith("RIHS01_9c45bf16")


def test_types_have_the_names_that_ros_gives_them_on_dds():
    """With the student's own package, and turtlesim's newer one."""
    types = Interfaces("my_package", "turtlesim_msgs")

    assert dds_bus.dds_name(types.pose) == "turtlesim_msgs::msg::dds_::Pose_"
    assert dds_bus.dds_name(types.turtle_array) == "my_package::msg::dds_::TurtleArray_"
    assert dds_bus.dds_name(types.catch_turtle.request) == "my_package::srv::dds_::CatchTurtle_Request_"
    assert dds_bus.dds_name(EMPTY.response) == "std_srvs::srv::dds_::Empty_Response_"
