"""The part of a ROS 2 middleware that the arena uses: publish, subscribe, serve and call."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, ClassVar, Final, Literal, NamedTuple, get_args

from catch_arena.ros.middleware.interfaces import Interfaces, MessageType, ServiceType

Backend = Literal["rclpy", "cyclonedds", "rosbridge"]
BACKENDS: Final[tuple[Backend, ...]] = get_args(Backend)
"""Back-ends in the order in which they are tried."""
DEPTH: Final = 10
"""Number of unread messages that each topic keeps, as usual in ROS; after that the oldest is lost."""
SERVICE_DEPTH: Final = 64
"""Number of unread requests that each service keeps, and of unanswered calls that are kept; rclpy keeps all."""
SPIN_S: Final = 0.004
"""Longest time of a spin [s], except for one more message of each topic and service."""
LONGEST: Final = 2**17
"""Size of the longest message [bytes]. A longer one is left out: the arena needs none, and reading it takes time."""

Log = Callable[[str], object]
"""Function that takes one line for readers."""


class OnceLog:
    """A log that leaves out a line if it, or another line with the same subject, was logged before."""

    def __init__(self, log: Log) -> None:
        self._log = log
        self._logged: set[str] = set()

    def __call__(self, line: str, subject: str = "") -> None:
        """Log a line; lines with the same subject count as one, even if they differ."""
        if (subject or line) not in self._logged:
            self._logged.add(subject or line)
            self._log(line)

    def warn(self, line: str, subject: str = "") -> None:
        """Log a line as a warning, once."""
        self(f"warning: {line}", subject or line)


@dataclass(frozen=True, slots=True)
class Request:
    """One call of a service, which its server answers once, immediately or later."""

    message: Any
    answer: Callable[[Any], None]


EndpointKind = Literal["publisher", "subscription", "service", "client"]


class Endpoint(NamedTuple):
    """A publisher, subscription, service or client of another node."""

    node: str
    """Full name of the node: /turtle_controller."""
    kind: EndpointKind
    name: str
    """Name of the topic or the service."""
    type: str
    """Name of the type, as ROS writes it: turtlesim/msg/Pose."""
    fields_differ: bool = False
    """True if the type has the name of ours and other fields."""


class Client(NamedTuple):
    """Client of one service."""

    ready: Callable[[], bool]
    """Function that returns True if a node serves it, so that a call would be answered.

    It raises BusError if its node cannot answer over this bus.
    """
    call: Callable[[Any], Future[Any]]
    """Function that sends a request. The response comes while the bus spins, or never."""


class Bus(ABC):
    """A middleware, reached by a back-end. Callbacks run in the thread that calls `spin`, which does all the work.

    A back-end that cannot report other nodes keeps the answers of this class.
    """

    backend: ClassVar[Backend]
    middleware: str = ""
    """Name of the middleware below the back-end; empty if there is only one."""

    def interfaces(self, given: Interfaces) -> Interfaces:
        """Return the types that the other nodes use, if the middleware reports them; else those given.

        Raises:
            BusError: if this ROS does not have them, or if they are ambiguous.
        """
        return given

    def graph(self) -> list[Endpoint] | None:
        """Return the endpoints of all other nodes; None if the middleware does not report them."""
        return None

    def listeners_to(self, topic: str) -> int | None:
        """Return the number of a topic's subscriptions; None if the middleware does not report it."""
        del topic
        return None

    def publishers_of(self, topic: str) -> int | None:
        """Return the number of publishers of a subscribed topic; None if the middleware does not report it."""
        del topic
        return None

    @abstractmethod
    def publisher(self, topic: str, kind: MessageType) -> Callable[[Any], None]:
        """Announce a topic, and return a function that sends one message."""

    @abstractmethod
    def subscribe(self, topic: str, kind: MessageType, on_message: Callable[[Any], object]) -> None:
        """Subscribe to a topic. Messages that cannot be read are left out; one line is logged for all of them."""

    @abstractmethod
    def serve(self, service: str, kind: ServiceType, on_request: Callable[[Request], object]) -> None:
        """Answer a service."""

    @abstractmethod
    def client(self, service: str, kind: ServiceType) -> Client:
        """Return a client of a service."""

    @abstractmethod
    def spin(self, timeout_s: float = 0.0) -> None:
        """Handle the messages that have come, one of each topic and service in turn, for SPIN_S.

        If none has come, wait up to `timeout_s`. The rest waits for the next spin, in queues that drop their oldest.
        """

    @abstractmethod
    def close(self) -> None:
        """Leave the bus."""
