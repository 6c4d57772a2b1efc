"""What `conformance` and `grade` do where a service on a ROS 2 bus stands in the place of an arbiter or an agent."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from catch_arena.cli.bus_options import BusOptions
from catch_arena.cli.terminal import say
from catch_arena.errors import ConfigError

if TYPE_CHECKING:
    from catch_arena.ros.node_tests.node_under_test import NodeUnderTest

_SERVICE: Final = "ros:"


def names_a_service(word: str) -> bool:
    """Whether it names a service: ros:/catch_turtle."""
    return word.startswith(_SERVICE)


@contextmanager
def node_under_test(word: str, bus: BusOptions) -> "Iterator[NodeUnderTest]":
    """Whoever serves it, with the arena about it on the bus.

    Raises:
        ConfigError: for a name that no service has.
        BusError: where the bus cannot be reached.
    """
    from catch_arena.ros.middleware.opening import is_service
    from catch_arena.ros.node_tests.node_under_test import NodeUnderTest

    service = word.removeprefix(_SERVICE)
    if not is_service(service):
        raise ConfigError(f"a service must be given as ros:/NAME, as ros:/catch_turtle, got {word!r}")
    types = bus.types()
    with bus.joined("catch_arena") as joined:
        yield NodeUnderTest(joined, service, joined.interfaces(types), lambda line: say(line, err=True))
