"""A node that serves catch_turtle, and the parts of turtlesim and of the spawner around it."""

import time
from collections.abc import Callable, Mapping
from typing import Final

from catch_arena.core.physics import DT
from catch_arena.errors import BusError, MissingServiceError
from catch_arena.messages import CatchTurtleRequest, Pose, Turtle, TurtleArray
from catch_arena.ros.middleware.bus import Bus, Log, Request
from catch_arena.ros.middleware.graph_names import ALIVE_TURTLES, KILL, SPAWN, TURTLE, pose_of
from catch_arena.ros.middleware.interfaces import Empty, Interfaces, Name

ANSWER_S: Final = 2.0
"""Longest wait for an answer."""
_THERE_S: Final = 10.0
"""Longest wait for a node to appear, and for a target in its list."""
_LOOK_S: Final = 0.5
"""How long publishers of the list are looked for."""
_LISTEN_S: Final = 3.0
"""How long a list is waited for if the bus does not know publishers: the exercise's spawner sends one after 2 s."""
_MOST_SILENT: Final = 3
"""A node is given up after this many requests in a row without an answer."""

Place = tuple[float, float]


class NodeUnderTest:
    """A service on a bus, and the position that it is asked about.

    We publish the pose of turtle1 and the list of targets. A node that publishes the list itself, as the exercise's
    spawner does, is asked for its own targets, and turtle1 moves to them.

    Args:
        bus: the bus.
        service: its name, for example /catch_turtle.
        interfaces: the packages of the types.
        log: takes one line when there is news.
    """

    def __init__(self, bus: Bus, service: str, interfaces: Interfaces, log: Log) -> None:
        self._bus, self._service, self._interfaces, self._log = bus, service, interfaces, log
        self._pose = bus.publisher(pose_of(TURTLE), interfaces.pose)
        bus.subscribe(ALIVE_TURTLES, interfaces.turtle_array, self._on_list)
        bus.serve(KILL, interfaces.kill, lambda request: request.answer(Empty()))
        bus.serve(SPAWN, interfaces.spawn, self._on_spawn)
        self._client = bus.client(service, interfaces.catch_turtle, self._on_failure)
        self._spawned = 1
        self._heard: TurtleArray | None = None
        self._position = Pose(0.0, 0.0, 0.0, 0.0, 0.0), TurtleArray(())
        self._answered = False
        """Whether any request was answered."""
        self._silent = 0
        """Number of the last requests, if they were not answered."""
        self._failure = ""
        self._alive: Callable[[TurtleArray], None] | None = None
        self.keeps_the_list = False
        """Whether the node publishes /alive_turtles itself."""

    @property
    def listed(self) -> dict[str, Place]:
        """Targets in the last list of a node that keeps the list."""
        return {} if self._heard is None else {name: (x, y) for name, x, y, _ in self._heard.turtles}

    def meet(self) -> None:
        """Wait until the service is there, and see which side keeps the list.

        Raises:
            MissingServiceError: if no node serves it.
            BusError: if the node that serves it cannot answer over this bus.
        """
        end = time.monotonic() + _THERE_S
        while not self._client.ready:
            if time.monotonic() > end:
                raise MissingServiceError(
                    f"nobody serves {self._service} on this bus: does the node run, in the same domain?"
                )
            self._bus.spin(0.05)
        self._spin(_LOOK_S if self._bus.publishers_of(ALIVE_TURTLES) is not None else _LISTEN_S)
        self.keeps_the_list = bool(self._bus.publishers_of(ALIVE_TURTLES)) or self._heard is not None
        if self.keeps_the_list:
            self._log(
                f"the node publishes {ALIVE_TURTLES} itself: it is asked for its own targets, one after the other"
            )
        else:
            self._alive = self._bus.publisher(ALIVE_TURTLES, self._interfaces.turtle_array)

    def wait_for_target(self) -> None:
        """Wait until the list of a node that keeps it has a target.

        Raises:
            BusError: if it stays empty.
        """
        end = time.monotonic() + _THERE_S
        while not self.listed:
            if time.monotonic() > end:
                raise BusError(f"the node lists no target on {ALIVE_TURTLES} for {_THERE_S:g} s: does it call {SPAWN}?")
            self.publish_for(DT)

    def ask(self, hunter: Place, targets: Mapping[str, Place], name: str, settle_s: float) -> bool | None:
        """Publish a position for a while, then request a target; return the answer, or None without one in time.

        Raises:
            MissingServiceError: if rosbridge reports that nobody serves it, which `meet` cannot see there.
            BusError: if this is the third request in a row without an answer.
        """
        turtles = tuple(Turtle(target, x, y, 0.0) for target, (x, y) in targets.items())
        self._position = Pose(*hunter, 0.0, 0.0, 0.0), TurtleArray(turtles)
        self.publish_for(settle_s)
        call = self._client.call(CatchTurtleRequest(name))
        end = time.monotonic() + ANSWER_S
        while call.response is None and time.monotonic() < end:
            self.publish_for(DT)
            if self._failure and not self._answered:
                raise MissingServiceError(f"nobody answers on this bus ({self._failure}): does the node run?")
        if call.response is None:
            self._silent += 1
            if self._silent == _MOST_SILENT:
                raise BusError(f"it has not answered {_MOST_SILENT} requests one after the other, and is given up")
            return None
        self._silent, self._answered = 0, True
        return bool(call.response.success)

    def publish_for(self, seconds: float) -> None:
        """Publish the position for a time, every 16 ms as turtlesim does: the pose, and the list if it is ours."""
        end = time.monotonic() + seconds
        while (now := time.monotonic()) < end:
            self._pose(self._position[0])
            if self._alive is not None:
                self._alive(self._position[1])
            self._spin(min(now + DT, end) - now)

    def _spin(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self._bus.spin(left)

    def _on_list(self, message: TurtleArray) -> None:
        if self._alive is None:  # else it is ours
            self._heard = message

    def _on_failure(self, why: str) -> None:
        self._failure = why
        if self._answered:
            self._log(f"warning: {why}")

    def _on_spawn(self, request: Request) -> None:
        """Answer as turtlesim does; every name is free."""
        self._spawned += 1
        request.answer(Name(request.message.name or f"turtle{self._spawned}"))
