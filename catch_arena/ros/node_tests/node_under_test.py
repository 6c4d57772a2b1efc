"""Somebody's node that serves catch_turtle, and the arena about it: turtlesim's part, and the spawner's."""

import time
from collections.abc import Callable, Mapping
from typing import Final

from catch_arena.core.physics import DT
from catch_arena.errors import BusError, MissingServiceError
from catch_arena.messages import CatchTurtleRequest, Pose, Turtle, TurtleArray
from catch_arena.ros.middleware.bus import Bus, Log, Peer, Request
from catch_arena.ros.middleware.graph_names import ALIVE_TURTLES, KILL, SPAWN, TURTLE, pose_of
from catch_arena.ros.middleware.interfaces import Empty, Interfaces, Name

ANSWER_S: Final = 2.0
"""So long a node may take to answer."""
_THERE_S: Final = 10.0
"""So long a node may take to appear, or to list a target."""
_LOOK_S: Final = 0.5
_LISTEN_S: Final = 3.0
"""Where the middleware does not tell who publishes what: the exercise's spawner lists its first target after 2 s."""

Place = tuple[float, float]


class NodeUnderTest:
    """A service on a bus, and what it needs to answer.

    The arena says where turtle1 stands and which targets are alive. A node that publishes the list itself, as the
    exercise's spawner does, is asked for targets of its own; then turtle1 comes to them.

    Args:
        bus: the bus.
        service: its name, as in /catch_turtle.
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
        self._met = self._answered = False
        self._failure = ""
        self._alive: Callable[[TurtleArray], None] | None = None
        self.keeps_the_list = False
        """Whether the node publishes /alive_turtles itself."""

    @property
    def listed(self) -> dict[str, Place]:
        """The targets of a node that keeps the list, as it last told them."""
        return {} if self._heard is None else {name: (x, y) for name, x, y, _ in self._heard.turtles}

    def meet(self) -> None:
        """Wait until the service is there, and see who keeps the list.

        Raises:
            MissingServiceError: where nobody serves it.
            BusError: where somebody does who cannot answer over this bus.
        """
        if self._met:
            return
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
        self._met = True

    def wait_for_target(self) -> None:
        """Until a node that keeps the list has a target in it.

        Raises:
            BusError: where it has none for long.
        """
        end = time.monotonic() + _THERE_S
        while not self.listed:
            if time.monotonic() > end:
                raise BusError(f"the node lists no target on {ALIVE_TURTLES} for {_THERE_S:g} s: does it call {SPAWN}?")
            self._publish_for(DT)

    def ask(self, hunter: Place, targets: Mapping[str, Place], name: str, settle_s: float) -> bool | None:
        """Stand there among these targets for a while, and ask for one: the answer, None without one in time.

        Raises:
            MissingServiceError: where the middleware says that the very first request cannot be answered. `meet` is not
                told by rosbridge whether anybody serves it.
        """
        turtles = tuple(Turtle(target, x, y, 0.0) for target, (x, y) in targets.items())
        self._position = Pose(*hunter, 0.0, 0.0, 0.0), TurtleArray(turtles)
        self._publish_for(settle_s)
        call = self._client.call(CatchTurtleRequest(name))
        end = time.monotonic() + ANSWER_S
        while call.response is None and time.monotonic() < end:
            self._publish_for(DT)
            if self._failure and not self._answered:
                raise MissingServiceError(f"nobody answers on this bus ({self._failure}): does the node run?")
        self._answered = self._answered or call.response is not None
        return None if call.response is None else bool(call.response.success)

    def ask_nothing(self, seconds: float) -> None:
        """Stand there so long."""
        self._publish_for(seconds)

    def _publish_for(self, seconds: float) -> None:
        """The pose, and the list where it is ours, tick by tick, as turtlesim tells them."""
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

    def _on_list(self, message: TurtleArray, peer: Peer | None) -> None:
        del peer
        if not self._met or self.keeps_the_list:
            self._heard = message

    def _on_failure(self, why: str) -> None:
        self._failure = why
        if self._answered:
            self._log(f"warning: {why}")

    def _on_spawn(self, request: Request) -> None:
        """As turtlesim: every name is free here."""
        self._spawned += 1
        request.answer(Name(request.message.name or f"turtle{self._spawned}"))
