"""Options for a ROS 2 bus and its packages, shared by all commands that exchange messages with nodes."""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final

import typer
from typer.core import TyperCommand

from catch_arena.cli.options import ConditionalOptions
from catch_arena.cli.terminal import echo
from catch_arena.errors import ConfigError, suggest
from catch_arena.ros.middleware.bus import Bus as JoinedBus
from catch_arena.ros.middleware.interfaces import INTERFACES, TURTLESIM, Interfaces
from catch_arena.ros.middleware.opening import BRIDGE_URL, describe_bus, open_bus
from catch_arena.text import shortened

if TYPE_CHECKING:
    from catch_arena.ros.node_tests.node_under_test import NodeUnderTest

_ROS_ARGS: Final = "--ros-args"
SPAWN_FREQUENCY: Final = "spawn_frequency"
NAME_PREFIX: Final = "turtle_name_prefix"
CLOSEST_FIRST: Final = "catch_closest_turtle_first"
_WORDS: Final = {"-p", "--param"}
_BOOLEANS: Final = {"true": True, "false": False}
_KINDS: Final = {bool: "true or false", float: "a number", str: "a text"}

Value = bool | float | str
_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_SERVICE: Final = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")
SERVICE: Final = "ros:"
"""Prefix of a word that names a node's service: ros:/catch_turtle."""
RosArgs = Annotated[
    list[str] | None,
    typer.Option(
        _ROS_ARGS,
        metavar="ARGS",
        help="Parameters of the node, -p NAME:=VALUE, after all other options (see `catch-arena docs ros_names`).",
    ),
]
"""Option for a node's parameters; only a NodeCommand may have it."""


Interface = Annotated[
    str,
    typer.Option(
        "--interfaces",
        metavar="PACKAGE",
        help="Your package with Turtle, TurtleArray and CatchTurtle (see `catch-arena docs ros_names`). With rclpy it "
        "is found automatically.",
    ),
]
BusOption = Annotated[
    str | None,
    typer.Option(
        "--bus",
        metavar="BUS",
        help="rclpy needs ROS on this machine; cyclonedds needs no ROS; rosbridge, or its address, such as "
        f"{BRIDGE_URL}, needs a rosbridge server on a machine with ROS.",
        show_default="the first that works",
    ),
]


@dataclass(frozen=True)
class Packages:
    """Packages of the nodes' messages."""

    interfaces: Interface = INTERFACES
    turtlesim: Annotated[
        str,
        typer.Option(metavar="PACKAGE", help="Package with Pose: turtlesim, or turtlesim_msgs from Kilted on."),
    ] = TURTLESIM

    def __post_init__(self) -> None:
        checked_name("--interfaces", self.interfaces, INTERFACES)
        checked_name("--turtlesim", self.turtlesim, TURTLESIM)

    @property
    def types(self) -> Interfaces:
        """The types of these packages."""
        return Interfaces(self.interfaces, self.turtlesim)


@dataclass(frozen=True)
class Bus(Packages):
    """Options for the bus to join."""

    bus: BusOption = None

    def opened(self, node: str) -> JoinedBus:
        """Join the bus, with a node of this name on it.

        Raises:
            BusError: if the bus cannot be reached.
        """
        return open_bus(self.bus, node=node, log=lambda line: echo(line, err=True))

    @contextmanager
    def joined(self, node: str) -> Iterator[JoinedBus]:
        """Join the bus, print its description, and leave it at the end.

        Raises:
            BusError: if it cannot be reached.
        """
        with closing(self.opened(node)) as bus:
            echo(describe_bus(bus, bus.interfaces(self.types)), err=True)
            yield bus


class NodeCommand(TyperCommand):
    """Command that can be started as a node: all words after --ros-args, up to a --, are values of that option."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put the name of --ros-args before each of its words, and parse all arguments."""
        in_ros_args, words = False, []
        for word in args:
            if word == _ROS_ARGS or (in_ros_args and word == "--"):
                in_ros_args = word == _ROS_ARGS
            else:
                words.append(f"{_ROS_ARGS}={word}" if in_ros_args else word)
        return super().parse_args(ctx, words)


@dataclass(frozen=True)
class NodeUnderTestOptions(ConditionalOptions):
    """Options for the bus of a node that serves ros:/catch_turtle, in place of an arbiter or an agent."""

    needs: ClassVar = "the service of a node, such as ros:/catch_turtle"
    interfaces: Interface = INTERFACES
    bus: BusOption = None

    @contextmanager
    def node(self, word: str) -> "Iterator[NodeUnderTest]":
        """Join the bus on which a node serves `word`, and yield that node, with an arena for it.

        Raises:
            ConfigError: for a name that no service can have.
            BusError: if the bus cannot be reached.
        """
        from catch_arena.ros.node_tests.node_under_test import NodeUnderTest

        service = word.removeprefix(SERVICE)
        if not is_service(service):
            raise ConfigError(f"a service must be given as ros:/NAME, such as ros:/catch_turtle, got {word!r}")
        bus = Bus(interfaces=self.interfaces, bus=self.bus)
        with bus.joined("catch_arena") as joined:
            yield NodeUnderTest(joined, service, joined.interfaces(bus.types), lambda line: echo(line, err=True))


def checked_name(setting: str, name: str, example: str) -> str:
    """Return the name of a turtle or a package, or the beginning of a name; an invalid name of a turtle ends turtlesim.

    Raises:
        ConfigError: for an invalid name.
    """
    if not _NAME.fullmatch(name):
        raise ConfigError(
            f"{setting} must be letters, digits and underscores, such as {example}, got {shortened(name)}"
        )
    return name


def is_service(name: str) -> bool:
    """Return whether a service can have that name: /catch_turtle."""
    return _SERVICE.fullmatch(name) is not None


def parameters_from(words: Sequence[str], defaults: Mapping[str, Value]) -> dict[str, Value]:
    """Return a node's parameters by name; of several values the last one counts.

    Args:
        words: the arguments after --ros-args.
        defaults: values of the parameters that are not given; a given value must have the default's type.

    Raises:
        ConfigError: for an unknown word or parameter, and for a value of another type.
    """
    values = dict(defaults)
    rest = iter(words)
    for word in rest:
        text = next(rest, None)
        if word not in _WORDS or text is None:
            raise ConfigError(f"--ros-args must be -p NAME:=VALUE, such as -p {SPAWN_FREQUENCY}:=2.0, got {word!r}")
        name, sign, value = text.partition(":=")
        if not name or not sign:
            raise ConfigError(f"--ros-args -p must be NAME:=VALUE, such as {SPAWN_FREQUENCY}:=2.0, got {text!r}")
        if name not in values:
            known = suggest(name, values) if values else "this node has none"
            raise ConfigError(f"there is no parameter {shortened(name)}: {known}")
        values[name] = _value(name, value, type(values[name]))
    return values


def _value(name: str, word: str, kind: type) -> Value:
    try:
        return _BOOLEANS[word.lower()] if kind is bool else kind(word)
    except (KeyError, ValueError):
        raise ConfigError(f"{name} must be {_KINDS[kind]}, got {shortened(word)}") from None
