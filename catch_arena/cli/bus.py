"""Options for a ROS 2 bus and its packages, shared by all commands that exchange messages with nodes."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Final

import typer

from catch_arena.cli.options import refuse
from catch_arena.cli.terminal import echo
from catch_arena.ros.middleware.bus import Bus as JoinedBus
from catch_arena.ros.middleware.graph_names import checked_name, checked_service
from catch_arena.ros.middleware.interfaces import INTERFACES, TURTLESIM, Interfaces
from catch_arena.ros.middleware.opening import BRIDGE_URL, describe_bus, open_bus

if TYPE_CHECKING:
    from catch_arena.ros.node_tests.node_under_test import NodeUnderTest

SERVICE: Final = "ros:"
"""Prefix of a word that names a node's service: ros:/catch_turtle."""
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
        """Join the bus, with a node of this name on it."""
        return open_bus(self.bus, node=node, log=lambda line: echo(line, err=True))

    @contextmanager
    def joined(self, node: str) -> Iterator[JoinedBus]:
        """Join the bus as `opened` does, print its description, and leave it at the end."""
        with closing(self.opened(node)) as bus:
            echo(describe_bus(bus, bus.interfaces(self.types)), err=True)
            yield bus


@dataclass(frozen=True)
class NodeUnderTestOptions:
    """Options for the bus of a node that serves ros:/catch_turtle, in place of an arbiter or an agent."""

    interfaces: Interface = INTERFACES
    bus: BusOption = None

    def refuse(self) -> None:
        """Check that no option was given, because there is no node."""
        refuse(self, "the service of a node, such as ros:/catch_turtle")

    @contextmanager
    def node(self, word: str) -> "Iterator[NodeUnderTest]":
        """Join the bus on which a node serves `word`, and yield that node, with an arena for it."""
        from catch_arena.ros.node_tests.node_under_test import NodeUnderTest

        service = checked_service("a service", word, SERVICE)
        bus = Bus(interfaces=self.interfaces, bus=self.bus)
        with bus.joined("catch_arena") as joined:
            yield NodeUnderTest(joined, service, joined.interfaces(bus.types), lambda line: echo(line, err=True))
