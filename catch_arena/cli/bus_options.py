"""Which ROS 2 bus, and which packages: the options of all commands that speak to nodes."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any, Final, NamedTuple

import typer
from typer.core import TyperCommand

from catch_arena.cli.terminal import say
from catch_arena.errors import ConfigError
from catch_arena.ros.middleware.names import BRIDGE_URL, INTERFACES, TURTLESIM, Backend

if TYPE_CHECKING:
    from catch_arena.ros.middleware.bus import Bus
    from catch_arena.ros.middleware.interfaces import Interfaces

BusOption = Annotated[
    Backend | None,
    typer.Option(
        "--bus",
        metavar="BUS",
        help="rclpy needs ROS on this machine; cyclonedds needs none; rosbridge needs a rosbridge server where ROS "
        "runs.",
        show_default="the first of them that works here",
    ),
]
Domain = Annotated[
    int | None,
    typer.Option(
        help="The DDS domain, from 0 to 232; not with rosbridge, whose server has its own.",
        show_default="ROS_DOMAIN_ID, or 0",
    ),
]
Url = Annotated[
    str | None,
    typer.Option(metavar="URL", help="Where rosbridge's server listens; only with rosbridge.", show_default=BRIDGE_URL),
]
Package = Annotated[
    str,
    typer.Option(
        "--interfaces",
        metavar="PACKAGE",
        help="Your package with Turtle, TurtleArray and CatchTurtle (`catch-arena docs ros2`). Over rclpy it is found "
        "by itself.",
    ),
]
Turtlesim = Annotated[
    str, typer.Option(metavar="PACKAGE", help="The package with Pose: turtlesim, or turtlesim_msgs from Kilted on.")
]
_ROS_ARGS: Final = "--ros-args"
RosArgs = Annotated[
    list[str] | None,
    typer.Option(
        _ROS_ARGS,
        metavar="ARGS...",
        help="The node's parameters, after all other options: -p NAME:=VALUE (`catch-arena docs ros2`).",
    ),
]
"""Only of a NodeCommand."""


def interfaces_of(package: str, turtlesim: str) -> "Interfaces":
    """The types of --interfaces and --turtlesim.

    Raises:
        ConfigError: for a name that no package can have.
    """
    from catch_arena.ros.middleware.interfaces import Interfaces
    from catch_arena.ros.middleware.opening import checked_package

    return Interfaces(checked_package("--interfaces", package), checked_package("--turtlesim", turtlesim))


class BusOptions(NamedTuple):
    """What was given of the options of a bus."""

    backend: Backend | None
    domain: int | None
    url: str | None
    interfaces: str
    turtlesim: str

    def types(self) -> "Interfaces":
        """See `interfaces_of`."""
        return interfaces_of(self.interfaces, self.turtlesim)

    @contextmanager
    def joined(self, node: str) -> Iterator["Bus"]:
        """The bus, with a node of this name on it; it is left in the end.

        Raises:
            BusError: where it cannot be reached.
        """
        from catch_arena.ros.middleware.opening import described, open_bus

        joined = open_bus(
            self.backend, node=node, domain=self.domain, url=self.url, log=lambda line: say(line, err=True)
        )
        try:
            say(described(joined, self.domain, joined.interfaces(self.types())), err=True)
            yield joined
        finally:
            joined.close()

    def refuse(self) -> None:
        """Where no bus is joined, none of them would do anything.

        Raises:
            ConfigError: for one that was given.
        """
        given = {
            "--bus": self.backend is not None,
            "--domain": self.domain is not None,
            "--url": self.url is not None,
            "--interfaces": self.interfaces != INTERFACES,
            "--turtlesim": self.turtlesim != TURTLESIM,
        }
        for option, is_given in given.items():
            if is_given:
                raise ConfigError(f"{option} must come with a service of a node, as ros:/catch_turtle")


class NodeCommand(TyperCommand):
    """A command that may be started as a node: all words behind --ros-args are its values, up to a --."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put the option's name before each of its words."""
        behind, words = False, []
        for word in args:
            if word == _ROS_ARGS or (behind and word == "--"):
                behind = word == _ROS_ARGS
            else:
                words.append(f"{_ROS_ARGS}={word}" if behind else word)
        return super().parse_args(ctx, words)
