"""A node that serves catch_turtle, and the parts of turtlesim and of the spawner around it."""

import time
from collections.abc import Callable, Mapping
from typing import Final

from catch_arena.core.physics import DT
from catch_arena.errors import BusError
from catch_arena.messages import CatchTurtleRequest, Pose, Turtle, TurtleArray
from catch_arena.ros.middleware.bus import Bus, Log, Request
from catch_arena.ros.middleware.graph_names import ALIVE_TURTLES, KILL, SPAWN, TURTLE, pose_of
from catch_arena.ros.middleware.interfaces import Empty, Interfaces, Name

ANSWER_S: Final = 2.0
"""Longest wait for an answer [s]."""
_THERE_S: Final = 10.0
"""Longest wait for a node, or for a target in its list, to appear [s]."""
_LOOK_S: Final = 0.5
"""Time in which the bus finds publishers of the list [s]."""
_LISTEN_S: Final = 3.0
"""Wait for a list if the bus does not report publishers [s]: the exercise's spawner sends one after 2 s."""

Place = tuple[float, float]


class NodeUnderTest:
    """A service on a bus, and the position that it is asked about: the pose of turtle1, and the list of targets.

    A node that publishes the list itself, as the exercise's spawner does, is asked for its own targets.
    """

    def __init__(self, bus: Bus, service: str, interfaces: Interfaces, log: Log) -> None:
        self._bus, self._service, self._interfaces, self._log = bus, service, interfaces, log
        self._pose = bus.publisher(pose_of(TURTLE), interfaces.pose)
        self._alive: Callable[[TurtleArray], None] | None = None
        self.listed: dict[str, Place] = {}
        """Targets in the node's own list."""
        self.publishes_list = False
        bus.subscribe(ALIVE_TURTLES, interfaces.turtle_array, self._on_list)
        bus.serve(KILL, interfaces.kill, lambda request: request.answer(Empty()))
        bus.serve(SPAWN, interfaces.spawn, self._on_spawn)
        self._client = bus.client(service, interfaces.catch_turtle)
        self._spawned = 1
        self._has_answered = False

    def wait_for_node(self) -> None:
        """Wait until the service is there, and publish the list if the node does not.

        Raises:
            BusError: if no node serves it, or if its node cannot answer over this bus.
        """
        end = time.monotonic() + _THERE_S
        while not self._client.ready():
            if time.monotonic() > end:
                raise BusError(f"no node serves {self._service} on this bus: does the node run, in the same domain?")
            self._bus.spin(0.05)
        reports_publishers = self._bus.publishers_of(ALIVE_TURTLES) is not None
        self._spin_until(time.monotonic() + (_LOOK_S if reports_publishers else _LISTEN_S))
        self.publishes_list = self.publishes_list or bool(self._bus.publishers_of(ALIVE_TURTLES))
        if self.publishes_list:
            self._log(f"the node publishes {ALIVE_TURTLES} itself: it is asked for its own targets")
        else:
            self._alive = self._bus.publisher(ALIVE_TURTLES, self._interfaces.turtle_array)

    def wait_for_target(self) -> None:
        """Handle new messages, and wait until the node's own list has a target; BusError is raised if there is none."""
        end = time.monotonic() + _THERE_S
        self._bus.spin(DT)
        while not self.listed:
            if time.monotonic() > end:
                raise BusError(f"the node lists no target on {ALIVE_TURTLES} for {_THERE_S:g} s: does it call {SPAWN}?")
            self._bus.spin(DT)

    def request_catch(self, hunter: Place, targets: Mapping[str, Place], name: str, settle_s: float) -> bool | None:
        """Publish a position for a while, then request a target; return the answer, or None without one in time."""
        turtles = tuple(Turtle(target, x, y, 0.0) for target, (x, y) in targets.items())
        position = Pose(*hunter, 0.0, 0.0, 0.0), TurtleArray(turtles)
        self._publish_for(settle_s, *position)
        call = self._client.call(CatchTurtleRequest(name))
        end = time.monotonic() + ANSWER_S
        while not call.done() and time.monotonic() < end:
            self._publish_for(DT, *position)
        if not call.done() and not self._has_answered:
            # over rosbridge `wait_for_node` cannot check that a node serves it
            raise BusError(f"{self._service} does not answer on this bus: does the node run, in the same domain?")
        self._has_answered = True
        return bool(call.result().success) if call.done() else None

    def _publish_for(self, seconds: float, pose: Pose, alive: TurtleArray) -> None:
        """Publish a position for a time, every 16 ms as turtlesim does."""
        end = time.monotonic() + seconds
        while (now := time.monotonic()) < end:
            self._pose(pose)
            if self._alive is not None:
                self._alive(alive)
            self._spin_until(min(now + DT, end))

    def _spin_until(self, end: float) -> None:
        while (left := end - time.monotonic()) > 0.0:
            self._bus.spin(left)

    def _on_list(self, message: TurtleArray) -> None:
        if self._alive is None:  # else the list is ours
            self.publishes_list = True
            self.listed = {name: (x, y) for name, x, y, _ in message.turtles}

    def _on_spawn(self, request: Request) -> None:
        """Answer as turtlesim does; every name is free."""
        self._spawned += 1
        request.answer(Name(request.message.name or f"turtle{self._spawned}"))
