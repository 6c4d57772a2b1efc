"""Diagnosis of this machine's ROS 2 bus: facts, and problems that keep nodes from playing, with a command for each."""

import os
import sys
import time
from collections.abc import Iterator, Sequence
from typing import Final

from catch_arena.errors import BusError
from catch_arena.ros.middleware.bus import Bus, Endpoint
from catch_arena.ros.middleware.graph_names import TURTLE
from catch_arena.ros.middleware.interfaces import Interfaces
from catch_arena.ros.middleware.ros_types import describe_type
from catch_arena.ros.nodes.neighbours import Neighbours

LOOK_S: Final = 3.0
"""Time of the search for other nodes [s]: as long as they need to find each other on a busy machine."""
_VARIABLES: Final = ("ROS_DOMAIN_ID", "RMW_IMPLEMENTATION", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY")
_VERBS: Final = {"publisher": "publishes", "subscription": "subscribes to", "service": "serves", "client": "calls"}
ARENA: Final = "/catch_arena"
"""Name of the node of `ros serve`, which may run at the same time."""
_HOUSEKEEPING: Final = ("/rosout", "/parameter_events")


def examine(bus: Bus, given: Interfaces, look_s: float = LOOK_S) -> tuple[list[str], list[str]]:
    """Look for other nodes on a bus.

    Args:
        bus: the bus.
        given: the packages of --interfaces and --turtlesim.
        look_s: time of the search [s].

    Returns:
        the facts, and the problems, a line each.
    """
    facts = [f"Python {sys.version.split()[0]}, {bus.backend}{f' with {bus.middleware}' if bus.middleware else ''}"]
    facts += [f"{name}={os.environ[name]}" if name in os.environ else f"{name} is not set" for name in _VARIABLES]
    problems = []
    end = time.monotonic() + look_s
    while (left := end - time.monotonic()) > 0:
        bus.spin(left)
    try:
        types = bus.interfaces(given)
        facts.append(f"interfaces: {types.catch_turtle.name}: {describe_type(types.catch_turtle)}")
        (turtles,) = types.turtle_array.fields
        facts.append(f"interfaces: {types.turtle_array.name}: {turtles.name}, each {describe_type(types.turtle)}")
    except BusError as error:
        types = given
        problems.append(f"{error}: {error.hint}" if error.hint else str(error))
    graph = bus.graph()
    if graph is None:
        problems.append(
            f"{bus.backend} does not report other nodes: use rclpy, with the Python that ROS was built for, after "
            "`source /opt/ros/$ROS_DISTRO/setup.bash`"
        )
        return facts, problems
    facts += _nodes(graph)
    if all(one.node == ARENA for one in graph):
        problems.append(
            "no other node was found: start yours; if it runs, give both terminals the same ROS_DOMAIN_ID and "
            "ROS_AUTOMATIC_DISCOVERY_RANGE"
        )
    other_nodes = [endpoint for endpoint in graph if endpoint.node != ARENA]
    Neighbours([TURTLE], [TURTLE], types, problems.append).look(other_nodes)
    return facts, [line.removeprefix("warning: ") for line in problems]


def _nodes(graph: Sequence[Endpoint]) -> Iterator[str]:
    for node in sorted({one.node for one in graph}):
        uses = [
            f"{_VERBS[end.kind]} {end.name} ({end.type})"
            for end in graph
            if end.node == node and end.name not in _HOUSEKEEPING and not end.name.startswith(f"{node}/")
        ]
        yield f"node {node}: {', '.join(uses) or 'no topics'}"
