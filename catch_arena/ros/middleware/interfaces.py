"""R8.1: messages and services on a ROS 2 bus, as ROS's own definitions, and the tuples that stand for them here.

A definition is the text of a .msg or .srv file. It follows from the tuple, and each back-end makes its own types from
it, so that a field and its width stand in one place.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Annotated, Any, Final, NamedTuple, get_args, get_origin, get_type_hints

from catch_arena import messages
from catch_arena.verdicts import Ruling

INTERFACES: Final = "my_robot_interfaces"
"""Name of the exercise's package, with Turtle, TurtleArray and CatchTurtle."""
TURTLESIM: Final = "turtlesim"
"""Name of the package with Pose; turtlesim_msgs from Kilted on."""
OWN_PACKAGE: Final = "catch_arena_interfaces"
"""Name of our package of types: ros2/catch_arena_interfaces."""

UInt8 = Annotated[int, "uint8"]
Int32 = Annotated[int, "int32"]
UInt32 = Annotated[int, "uint32"]
"""Whole numbers by ROS's words for them; a float is a float64 if a definition does not say otherwise."""


class Field(NamedTuple):
    """One line of a definition."""

    name: str
    """Name of the field; empty if a student's own type lacks it: it is not sent, and is zero when it is read.

    Dots lead into messages: turtle.name.
    """
    type: "str | MessageType"
    """ROS's word for a bool, a string or a number, or another message."""
    is_sequence: bool
    """True for a sequence; only messages can be in one."""


@dataclass(frozen=True, slots=True)
class MessageType:
    """A message, or one half of a service."""

    name: str
    """Name of the type, as ROS writes it: turtlesim/msg/Pose, turtlesim/srv/Spawn_Request."""
    make: Callable[..., Any]
    """The NamedTuple that stands for one; its fields are those of `fields`, in their order."""
    fields: tuple[Field, ...]

    @property
    def definition(self) -> str:
        """The text of its .msg file."""
        lines = []
        for name, kind, is_sequence in self.fields:
            word = kind if isinstance(kind, str) else kind.name.replace("/msg/", "/")
            lines.append(f"{word}{'[]' if is_sequence else ''} {name}\n")
        return "".join(lines)


@dataclass(frozen=True, slots=True)
class ServiceType:
    """A service: its request and its response."""

    name: str
    request: MessageType
    response: MessageType


class Vector3(NamedTuple):
    """geometry_msgs/msg/Vector3."""

    x: float
    y: float
    z: float


class TwistMessage(NamedTuple):
    """geometry_msgs/msg/Twist: metres and radians per second, of which turtles obey linear.x and angular.z."""

    linear: Vector3
    angular: Vector3

    @classmethod
    def of(cls, linear_x: float, angular_z: float) -> "TwistMessage":
        """Return a Twist with the two numbers that a turtle obeys."""
        return cls(Vector3(linear_x, 0.0, 0.0), Vector3(0.0, 0.0, angular_z))


class Time(NamedTuple):
    """builtin_interfaces/msg/Time."""

    sec: Int32
    nanosec: UInt32


class Clock(NamedTuple):
    """rosgraph_msgs/msg/Clock: the arena's time."""

    clock: Time


class SpawnRequest(NamedTuple):
    """turtlesim/srv/Spawn, the request: metres, radians; an empty name lets the simulator choose one."""

    x: float
    y: float
    theta: float
    name: str


class SetPenRequest(NamedTuple):
    """turtlesim/srv/SetPen, the request: colour, width and whether nothing is drawn, each from 0 to 255."""

    r: UInt8
    g: UInt8
    b: UInt8
    width: UInt8
    off: UInt8


class Name(NamedTuple):
    """The response of turtlesim/srv/Spawn, "" if nothing was spawned, and the request of turtlesim/srv/Kill."""

    name: str


class Empty(NamedTuple):
    """A request or a response without fields."""


class RulingMessage(NamedTuple):
    """catch_arena_interfaces/msg/Ruling: the arbiter's ruling on one request (R5.6)."""

    time: float
    """The arena's time at the beginning of the step in which the request was judged [s]."""
    step: UInt32
    hunter: str
    target: str
    """The requested name, cut to 255 characters; empty for a rank that has no target."""
    verdict: str
    success: bool
    distance: float
    """Distance between the centres [m]; -1 if reach was not tested."""
    winner: str
    """The hunter that won the target, if the request was granted or lost a contest; else empty."""
    clause: str
    reason: str

    @classmethod
    def of(cls, ruling: Ruling, time_ms: int, hunters: Sequence[str]) -> "RulingMessage":
        """Return the message of a ruling in a step that began at `time_ms`; `hunters` are their names by seat."""
        target = "" if ruling.target is None else str(ruling.target)
        return cls(
            time=time_ms / 1000.0,
            step=ruling.step,
            hunter=hunters[ruling.hunter],
            # half of a surrogate pair is no UTF-8
            target=target.encode(errors="backslashreplace").decode()[:255],
            verdict=ruling.verdict.name,
            success=ruling.success,
            distance=-1.0 if ruling.distance_um is None else ruling.distance_um / 1e6,
            winner="" if ruling.winner is None else hunters[ruling.winner],
            clause=ruling.verdict.clause,
            reason=ruling.reason,
        )


class StandingMessage(NamedTuple):
    """catch_arena_interfaces/msg/Standing: the score and the rank of one hunter."""

    time: float
    """The arena's time [s]."""
    hunter: str
    player: str
    score: UInt32
    rank: UInt32
    over: bool


def message_type(name: str, make: Callable[..., Any], *parts: MessageType, floats: str = "float64") -> MessageType:
    """Return a NamedTuple's message; `parts` are the messages in it, and `floats` is ROS's word for its floats."""
    words: dict[Any, Any] = {bool: "bool", str: "string", float: floats} | {part.make: part for part in parts}
    fields = []
    for field, hint in get_type_hints(make, include_extras=True).items():
        is_sequence = get_origin(hint) is tuple
        one = get_args(hint)[0] if is_sequence else hint
        word = get_args(one)[1] if get_origin(one) is Annotated else words[one]
        fields.append(Field(field, word, is_sequence))
    return MessageType(name, make, tuple(fields))


def service_type(
    name: str, request: Callable[..., Any], response: Callable[..., Any], floats: str = "float64"
) -> ServiceType:
    """Return the service that two NamedTuples stand for."""
    request_type = message_type(f"{name}_Request", request, floats=floats)
    return ServiceType(name, request_type, message_type(f"{name}_Response", response, floats=floats))


def values_by_field(kind: MessageType, message: Any, convert: Callable[[MessageType, Any], Any]) -> dict[str, Any]:
    """Return the values of one of our tuples, by the names of its definition; `convert` converts a message in it."""
    values: dict[str, Any] = {}
    for (name, word, is_sequence), value in zip(kind.fields, message, strict=True):
        if isinstance(word, str):
            values[name] = value
        else:
            values[name] = [convert(word, one) for one in value] if is_sequence else convert(word, value)
    return values


def from_attributes(kind: MessageType, source: Any) -> Any:
    """Return our tuple from an object that has the fields as attributes, as a library's messages do; None is a NaN."""
    values = []
    for name, word, is_sequence in kind.fields:
        value: Any = attrgetter(name)(source) if name else 0.0
        if not isinstance(word, str):
            value = tuple(from_attributes(word, one) for one in value) if is_sequence else from_attributes(word, value)
        values.append(math.nan if value is None else value)
    return kind.make(*values)


VECTOR3: Final = message_type("geometry_msgs/msg/Vector3", Vector3)
TWIST: Final = message_type("geometry_msgs/msg/Twist", TwistMessage, VECTOR3)
TIME: Final = message_type("builtin_interfaces/msg/Time", Time)
CLOCK: Final = message_type("rosgraph_msgs/msg/Clock", Clock, TIME)
EMPTY: Final = service_type("std_srvs/srv/Empty", Empty, Empty)
RULING: Final = message_type(f"{OWN_PACKAGE}/msg/Ruling", RulingMessage)
STANDING: Final = message_type(f"{OWN_PACKAGE}/msg/Standing", StandingMessage)


class Interfaces:
    """The types whose package differs from student to student, and from one ROS 2 to another.

    Args:
        package: the exercise's own, with Turtle, TurtleArray and CatchTurtle.
        turtlesim: turtlesim's, which is turtlesim_msgs from Kilted on.
    """

    def __init__(self, package: str = INTERFACES, turtlesim: str = TURTLESIM) -> None:
        self.package, self.turtlesim = package, turtlesim
        self.turtle = message_type(f"{package}/msg/Turtle", messages.Turtle)
        self.turtle_array = message_type(f"{package}/msg/TurtleArray", messages.TurtleArray, self.turtle)
        self.catch_turtle = service_type(
            f"{package}/srv/CatchTurtle", messages.CatchTurtleRequest, messages.CatchTurtleResponse
        )
        self.pose = message_type(f"{turtlesim}/msg/Pose", messages.Pose, floats="float32")
        self.spawn = service_type(f"{turtlesim}/srv/Spawn", SpawnRequest, Name, floats="float32")
        self.kill = service_type(f"{turtlesim}/srv/Kill", Name, Empty)
        self.set_pen = service_type(f"{turtlesim}/srv/SetPen", SetPenRequest, Empty)

    def with_types(self, turtle_array: MessageType, catch_turtle: ServiceType) -> "Interfaces":
        """Return a copy with a list and a catch service of another package."""
        changed = Interfaces(catch_turtle.name.partition("/")[0], self.turtlesim)
        (turtles,) = turtle_array.fields
        if isinstance(turtles.type, MessageType):
            changed.turtle = turtles.type
        changed.turtle_array, changed.catch_turtle = turtle_array, catch_turtle
        return changed
