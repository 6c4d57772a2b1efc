"""What the arena uses of a ROS 2 middleware: publish, subscribe, serve and call, whichever back-end does it."""

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
"""Of every topic's history: ROS's usual one. Who reads less often loses the oldest."""
SPIN_S: Final = 0.004
"""Whatever comes, a spin takes no longer than this, and one message more of each topic and service: of each sender,
where senders are told apart.
"""
LONGEST: Final = 2**17
"""Bytes of a message. What is longer is left out: nobody waits until it has been read, and all that the arena needs is
far shorter.
"""
HIGHEST_DOMAIN: Final = 232
"""The ports of the domains above it do not exist."""
_MODULES: Final[Mapping[Backend, str]] = {"cyclonedds": "cyclonedds", "rosbridge": "websockets", "rclpy": "rclpy"}
_INSTALL: Final = install_hint("ros")
_SERVICE: Final = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")
_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")

Peer = str
"""Who sent something: the same for all that comes from one process."""
Log = Callable[[str], object]
"""Takes one line for people."""
OnMessage = Callable[[Any, Peer | None], object]
"""Is called with a message, and with who sent it, as far as the middleware tells."""


@dataclass(frozen=True, slots=True)
class Request:
    """A service was called: whoever serves it answers once, at once or later."""

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
    """What another node publishes, hears, serves or calls."""

    node: str
    """Its full name: /turtle_controller."""
    kind: EndpointKind
    name: str
    """Of the topic or the service."""
    type: str
    """As ROS writes it: turtlesim/msg/Pose."""
    fields_differ: bool = False
    """Whether the type has the name of ours and other fields."""


class Client(Protocol):
    """Calls one service."""

    @property
    def ready(self) -> bool:
        """Whether somebody serves it, so that a call would be answered.

        Raises:
            BusError: where somebody serves it who cannot answer over this bus.
        """

    def call(self, request: Any) -> Call:
        """Ask; the response comes while the bus spins, or never."""


class Bus(Protocol):
    """A middleware, reached by a back-end. All is done by the thread that calls `spin`, in which callbacks run."""

    @property
    def backend(self) -> Backend:
        """Which one it is."""

    @property
    def about(self) -> str:
        """What carries the messages, for people; empty if that is clear from `backend`."""

    def interfaces(self, given: Interfaces) -> Interfaces:
        """The types that the other nodes use, as far as the middleware tells; else those given.

        Raises:
            BusError: where they are not known here, or cannot be told.
        """

    def graph(self) -> list[Endpoint] | None:
        """What all other nodes publish, hear, serve and call; None where the middleware does not tell."""

    def listeners_to(self, topic: str) -> int | None:
        """How many hear a topic; None where the middleware does not tell."""

    def publisher(self, topic: str, kind: MessageType) -> Callable[[Any], None]:
        """Announce a topic; what is returned sends one message."""

    def subscribe(self, topic: str, kind: MessageType, on_message: OnMessage) -> None:
        """Hear a topic; what cannot be read is left out, and told once."""

    def unsubscribe(self, topic: str) -> None:
        """Hear it no more."""

    def serve(self, service: str, kind: ServiceType, on_request: Callable[[Request], object]) -> None:
        """Answer a service."""

    def client(self, service: str, kind: ServiceType, on_failure: Log | None = None) -> Client:
        """Call a service; `on_failure` takes the line in which rosbridge says that no response will come, which
        otherwise is logged.
        """

    def declare(self, parameters: Parameters) -> None:
        """Let others read and change the node's parameters, as `ros2 param` does: over rclpy only."""

    def publishers_of(self, topic: str) -> frozenset[Peer] | None:
        """Who publishes on a topic that was subscribed to; None where the middleware does not tell."""

    def spin(self, timeout_s: float = 0.0) -> None:
        """Take what has come, one message of each topic and service after the other, for SPIN_S; where nothing has
        come, wait for it so long. What is left waits for the next spin, in queues that lose their oldest.
        """

    def close(self) -> None:
        """Leave the bus."""


class WithoutGraph:
    """What the back-ends without ROS's own library cannot tell."""

    about = ""

    def interfaces(self, given: Interfaces) -> Interfaces:
        """Those given."""
        return given

    def graph(self) -> list[Endpoint] | None:
        """It is not known."""
        return None

    def listeners_to(self, topic: str) -> int | None:
        """It is not known."""
        del topic
        return None

    def declare(self, parameters: Parameters) -> None:
        """There is no node of ROS's: only --ros-args gives parameters."""


def open_bus(
    backend: Backend | None = None,
    *,
    node: str = "catch_arena",
    domain: int | None = None,
    localhost: bool = False,
    url: str | None = None,
    log: Log = print,
) -> Bus:
    """Join a ROS 2 bus.

    Args:
        backend: None takes the first of BACKENDS that works here.
        node: what the node is called.
        domain: DDS's, from 0 to 232; None is ROS_DOMAIN_ID, or 0. rosbridge has that of its server.
        localhost: whether cyclonedds keeps to this machine whatever the environment says; else ROS_LOCALHOST_ONLY and
            ROS_AUTOMATIC_DISCOVERY_RANGE say where it looks for others.
        url: rosbridge's server; None is BRIDGE_URL.
        log: takes one line whenever there is something that people should know.

    Raises:
        ConfigError: for a domain that cannot be; for a domain or a url that this back-end has no use for.
        BusError: where what it needs is not installed, or where the bus cannot be reached.
    """
    number = _checked_domain(domain)
    if backend is None:
        backend = next((one for one in BACKENDS if _is_installed(one)), None)
        if backend is None:
            raise BusError(f"a ROS 2 bus needs rclpy, cyclonedds or websockets: {_INSTALL}")
        if backend != "rclpy" and "ROS_DISTRO" in os.environ:
            log(
                f"warning: ROS is sourced, but rclpy cannot be imported ({_import_fault()}), so {backend} is used: "
                "make the virtual environment with ROS's own Python: python3 -m venv --system-site-packages"
            )
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
        from catch_arena.ros.middleware.dds_domain import discovery_of

        return DdsBus(node, number, "localhost" if localhost else discovery_of(os.environ), log=log)
    if backend == "rosbridge":
        from catch_arena.ros.middleware.rosbridge_bus import RosbridgeBus

        return RosbridgeBus(BRIDGE_URL if url is None else url, log=log)
    from catch_arena.ros.middleware.rclpy_bus import RclpyBus

    return RclpyBus(node, number, log=log)


def described(bus: Bus, domain: int | None, interfaces: Interfaces) -> str:
    """One line on how nodes reach this bus, and with which types."""
    where = "" if bus.backend == "rosbridge" else f", domain {_checked_domain(domain)}"
    below = f", {bus.about}" if bus.about else ""
    python = f"Python {sys.version_info.major}.{sys.version_info.minor}"
    return f"bus: {bus.backend}{where}{below}, {python}, interfaces of {interfaces.package}"


def is_service(name: str) -> bool:
    """Whether a service can have that name: /catch_turtle."""
    return _SERVICE.fullmatch(name) is not None


def checked_package(option: str, name: str) -> str:
    """The name of a ROS package.

    Raises:
        ConfigError: for anything else.
    """
    if not _NAME.fullmatch(name):
        raise ConfigError(f"{option} must be the name of a ROS package, as {INTERFACES}, got {name!r}")
    return name


def _checked_domain(domain: int | None) -> int:
    word = os.environ.get("ROS_DOMAIN_ID", "").strip() or "0" if domain is None else str(domain)
    if not (word.isascii() and word.isdecimal()) or int(word) > HIGHEST_DOMAIN:
        name = "ROS_DOMAIN_ID" if domain is None else "the domain id"
        raise ConfigError(f"{name} must be a whole number from 0 to {HIGHEST_DOMAIN}, got {word}")
    return int(word)


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
