"""The arena's view of a ROS 2 middleware: publish, subscribe, serve and call, over any back-end."""

import os
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Final, Literal, NamedTuple, Protocol

from catch_arena.errors import BusError, ConfigError, install_hint
from catch_arena.ros.middleware.interfaces import Interfaces, MessageType, ServiceType
from catch_arena.ros.middleware.names import BACKENDS, BRIDGE_URL, INTERFACES, Backend
from catch_arena.ros.middleware.parameters import Parameters
from catch_arena.text import one_line

DEPTH: Final = 10
"""Messages of each topic that are kept until they are read, as usual in ROS; then the oldest is lost."""
SPIN_S: Final = 0.004
"""Longest time of a spin, but for one more message of each topic and service, and of each sender if the middleware
distinguishes senders.
"""
LONGEST: Final = 2**17
"""Bytes of a message. A longer one is left out: the arena needs none, and reading it takes time."""
_HIGHEST_DOMAIN: Final = 232
"""The ports of the domains above it do not exist."""
_MODULES: Final[Mapping[Backend, str]] = {"cyclonedds": "cyclonedds", "rosbridge": "websockets", "rclpy": "rclpy"}
_INSTALL: Final = install_hint("ros")
_SERVICE: Final = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")
_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")

Peer = str
"""The sender of a message: one process."""
Log = Callable[[str], object]
"""Takes one line for people."""


class OnceLog:
    """A log that leaves out a line if it, or another line about the same, was logged before."""

    def __init__(self, log: Log) -> None:
        self._log = log
        self._logged: set[str] = set()

    def __call__(self, line: str, about: str = "") -> None:
        """Log a line; lines that differ and have the same `about` count as one."""
        if (about or line) not in self._logged:
            self._logged.add(about or line)
            self._log(line)


OnMessage = Callable[[Any, Peer | None], object]
"""Takes a message and its sender, None if the middleware does not tell."""


@dataclass(frozen=True, slots=True)
class Request:
    """One call of a service, which its server answers once, immediately or later."""

    message: Any
    peer: Peer | None
    answer: Callable[[Any], None]
    """Sends the response."""


class Call:
    """A service's response that may still be under way."""

    def __init__(self) -> None:
        self.response: Any = None
        """None until it has come."""


EndpointKind = Literal["publisher", "subscription", "service", "client"]


class Endpoint(NamedTuple):
    """A publisher, subscription, service or client of another node."""

    node: str
    """Its full name: /turtle_controller."""
    kind: EndpointKind
    name: str
    """Of the topic or the service."""
    type: str
    """As ROS writes it: turtlesim/msg/Pose."""
    fields_differ: bool = False
    """True if the type has the name of ours and other fields."""


class Client(Protocol):
    """Calls one service."""

    @property
    def ready(self) -> bool:
        """True if a node serves it, so that a call would be answered.

        Raises:
            BusError: if its node cannot answer over this bus.
        """

    def call(self, request: Any) -> Call:
        """Send a request; the response comes while the bus spins, or never."""


class Bus(Protocol):
    """A middleware, reached by a back-end. All is done by the thread that calls `spin`, in which callbacks run."""

    @property
    def backend(self) -> Backend:
        """Name of the back-end."""

    @property
    def about(self) -> str:
        """Name of the middleware below the back-end; empty if there is only one."""

    def interfaces(self, given: Interfaces) -> Interfaces:
        """Return the types that the other nodes use, if the middleware reports them; else those given.

        Raises:
            BusError: if this ROS does not have them, or if they are ambiguous.
        """

    def graph(self) -> list[Endpoint] | None:
        """Return the endpoints of all other nodes; None if the middleware does not tell."""

    def listeners_to(self, topic: str) -> int | None:
        """Return the number of a topic's subscriptions; None if the middleware does not tell."""

    def publisher(self, topic: str, kind: MessageType) -> Callable[[Any], None]:
        """Announce a topic, and return a function that sends one message."""

    def subscribe(self, topic: str, kind: MessageType, on_message: OnMessage) -> None:
        """Subscribe to a topic; a message that cannot be read is left out, with one line for all of them."""

    def unsubscribe(self, topic: str) -> None:
        """End a subscription."""

    def serve(self, service: str, kind: ServiceType, on_request: Callable[[Request], object]) -> None:
        """Answer a service."""

    def client(self, service: str, kind: ServiceType, on_failure: Log | None = None) -> Client:
        """Return a client of a service; over rosbridge `on_failure` takes the line that says why a call failed."""

    def declare(self, parameters: Parameters) -> None:
        """Let others read and change the node's parameters, as `ros2 param` does: over rclpy only."""

    def publishers_of(self, topic: str) -> frozenset[Peer] | None:
        """Return who publishes on a topic that was subscribed to; None if the middleware does not tell."""

    def spin(self, timeout_s: float = 0.0) -> None:
        """Handle what has come, one message of each topic and service in turn, for SPIN_S.

        If nothing has come, wait up to `timeout_s`. The rest waits for the next spin, in queues that lose their oldest.
        """

    def close(self) -> None:
        """Leave the bus."""


class WithoutGraph:
    """The part of a `Bus` that only ROS's own library can do."""

    about = ""

    def interfaces(self, given: Interfaces) -> Interfaces:
        """Return those given."""
        return given

    def graph(self) -> list[Endpoint] | None:
        """Return None."""
        return None

    def listeners_to(self, topic: str) -> int | None:
        """Return None."""
        del topic
        return None

    def declare(self, parameters: Parameters) -> None:
        """Do nothing: there is no node of ROS's."""


def open_bus(
    backend: Backend | None = None,
    *,
    node: str = "catch_arena",
    domain: int | None = None,
    url: str | None = None,
    log: Log = print,
) -> Bus:
    """Join a ROS 2 bus.

    Args:
        backend: None takes the first of BACKENDS that works here.
        node: the node's name, over rclpy.
        domain: DDS's, from 0 to 232; None is ROS_DOMAIN_ID, or 0. A rosbridge server has its own.
        url: rosbridge's server; None is BRIDGE_URL.
        log: takes one line whenever there is something that people should know.

    Raises:
        ConfigError: for a domain that does not exist, or a domain or a url that this back-end does not use.
        BusError: if what it needs is not installed, or if the bus cannot be reached.
    """
    number = _checked_domain(domain)
    if backend is None:
        backend = _first_that_works(log)
    elif not _is_installed(backend):
        raise BusError(_missing(backend))
    if backend == "rosbridge" and domain is not None:
        raise ConfigError(
            f"--domain {domain} must be left out with --bus rosbridge: the server has a domain of its own"
        )
    if backend != "rosbridge" and url is not None:
        raise ConfigError(
            f"--url {url} must come with --bus rosbridge, whose server listens there, got --bus {backend}"
        )
    if backend == "cyclonedds":
        from catch_arena.ros.middleware.dds_bus import DdsBus

        return DdsBus(number, log=log)
    if backend == "rosbridge":
        from catch_arena.ros.middleware.rosbridge_bus import RosbridgeBus

        return RosbridgeBus(BRIDGE_URL if url is None else url, log=log)
    from catch_arena.ros.middleware.rclpy_bus import RclpyBus

    return RclpyBus(node, number, log=log)


def described(bus: Bus, domain: int | None, interfaces: Interfaces) -> str:
    """Return one line on how nodes reach this bus, and with which types."""
    where = "" if bus.backend == "rosbridge" else f", domain {_checked_domain(domain)}"
    below = f", {bus.about}" if bus.about else ""
    python = f"Python {sys.version_info.major}.{sys.version_info.minor}"
    return f"bus: {bus.backend}{where}{below}, {python}, interfaces of {interfaces.package}"


def is_service(name: str) -> bool:
    """Return whether a service can have that name: /catch_turtle."""
    return _SERVICE.fullmatch(name) is not None


def checked_package(option: str, name: str) -> str:
    """Return the name of a ROS package.

    Raises:
        ConfigError: for anything else.
    """
    if not _NAME.fullmatch(name):
        raise ConfigError(f"{option} must be the name of a ROS package, as {INTERFACES}, got {name!r}")
    return name


def _checked_domain(domain: int | None) -> int:
    word = os.environ.get("ROS_DOMAIN_ID", "").strip() or "0" if domain is None else str(domain)
    if not (word.isascii() and word.isdecimal()) or int(word) > _HIGHEST_DOMAIN:
        name = "ROS_DOMAIN_ID" if domain is None else "the domain id"
        raise ConfigError(f"{name} must be a whole number from 0 to {_HIGHEST_DOMAIN}, got {word}")
    return int(word)


def _first_that_works(log: Log) -> Backend:
    backend = next((one for one in BACKENDS if _is_installed(one)), None)
    if backend is None:
        raise BusError(f"a ROS 2 bus needs rclpy, cyclonedds or websockets: {_INSTALL}")
    if backend != "rclpy" and "ROS_DISTRO" in os.environ:
        log(
            f"warning: ROS is sourced, but rclpy cannot be imported ({_import_fault()}), so {backend} is used: "
            "make the virtual environment with ROS's own Python: python3 -m venv --system-site-packages"
        )
    return backend


def _is_installed(backend: Backend) -> bool:
    if backend == "rclpy":  # it may be there and not be sourced, or be built for another Python
        return not _import_fault()
    module = _MODULES[backend]
    return module in sys.modules or find_spec(module) is not None


def _import_fault() -> str:
    try:
        import_module("rclpy.node")
    except ImportError as error:
        return one_line(str(error))
    return ""


def _missing(backend: Backend) -> str:
    if backend == "rclpy":
        return (
            "rclpy is not there: source ROS first (source /opt/ros/jazzy/setup.bash), with the Python it was built for"
        )
    where = "" if backend == "rosbridge" else " (no wheels for Linux on ARM: use --bus rosbridge)"
    return f"{backend} needs {_MODULES[backend]}, which is not installed: {_INSTALL}{where}"
