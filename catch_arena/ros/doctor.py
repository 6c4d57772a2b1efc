"""Diagnosis of this machine's ROS 2 bus: facts, and problems that keep nodes from playing, with a command for each."""

import os
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from catch_arena.errors import BusError
from catch_arena.ros.middleware.bus import Backend, Bus, Endpoint
from catch_arena.ros.middleware.graph_names import TURTLE, cmd_vel_of
from catch_arena.ros.middleware.interfaces import TWIST, Interfaces
from catch_arena.ros.middleware.ros_types import describe_type
from catch_arena.ros.nodes.neighbours import Neighbours

_VARIABLES: Final = ("ROS_DOMAIN_ID", "RMW_IMPLEMENTATION", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY")
_VERBS: Final = {"publisher": "publishes", "subscription": "subscribes to", "service": "serves", "client": "calls"}
ARENA: Final = "/catch_arena"
"""Name of the node of `ros serve`, which may run at the same time."""
_HOUSEKEEPING: Final = ("/rosout", "/parameter_events")
_START: Final = "start yours; if it runs, give both terminals the same ROS_DOMAIN_ID and ROS_AUTOMATIC_DISCOVERY_RANGE"
_WORKS: Final[Mapping[Backend, str]] = {
    "cyclonedds": "matches with nodes that have RMW_IMPLEMENTATION=rmw_cyclonedds_cpp; nodes with Fast DDS, ROS's "
    "default, can drive hunters, but get no answers to their catch requests",
    "rosbridge": "matches with nodes in the domain of the rosbridge server",
}
"""Scope of matches, by the back-ends that do not list nodes."""
_DRIVEN: Final = (TURTLE, *(f"hunter_{seat}" for seat in range(8)))
"""Hunters whose drivers are counted over a bus that does not list nodes."""


def examine(bus: Bus, given: Interfaces, look_s: float = 3.0) -> tuple[list[str], list[str]]:
    """Look for other nodes on a bus for `look_s` seconds, and return the facts and the problems, a line each.

    On a busy machine nodes need the usual time to find each other.
    """
    facts = [f"Python {sys.version.split()[0]}, {bus.backend}{f' with {bus.middleware}' if bus.middleware else ''}"]
    facts += [f"{name}={os.environ[name]}" if name in os.environ else f"{name} is not set" for name in _VARIABLES]
    problems = []
    if bus.graph() is None:
        for hunter in _DRIVEN:
            bus.subscribe(cmd_vel_of(hunter), TWIST, lambda _: None)
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
        problems.append(str(error))
    graph = bus.graph()
    if graph is None:
        facts.append(f"works over {bus.backend}: {_WORKS[bus.backend]}")
        facts.append(
            f"does not work over {bus.backend}: a list of the nodes, and a check of their names and types; rclpy has "
            "both, with the Python that ROS was built for, after `source /opt/ros/$ROS_DISTRO/setup.bash`"
        )
        drivers = {cmd_vel_of(hunter): bus.publishers_of(cmd_vel_of(hunter)) for hunter in _DRIVEN}
        facts += [f"publishers of {topic}: {count}" for topic, count in drivers.items() if count]
        if all(count == 0 for count in drivers.values()):
            first, *_, last = drivers
            problems.append(f"no node publishes {first}, or a topic from /hunter_0/cmd_vel to {last}: {_START}")
        return facts, problems
    facts += _nodes(graph)
    if all(one.node == ARENA for one in graph):
        problems.append(f"no other node was found: {_START}")
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
