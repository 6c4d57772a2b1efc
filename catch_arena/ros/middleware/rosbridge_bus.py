"""The bus by rosbridge's JSON over a websocket: the server's side may have any middleware and any ROS."""

import json
import math
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import ExitStack, suppress
from functools import cache, partial
from itertools import count
from typing import Any, Final, NamedTuple

import msgspec
from websockets.exceptions import WebSocketException
from websockets.sync.client import ClientConnection, connect

from catch_arena.errors import BusError
from catch_arena.ros.middleware.bus import DEPTH, LONGEST, SERVICE_DEPTH, SPIN_S, Bus, Client, Log, OnceLog, Request
from catch_arena.ros.middleware.interfaces import MessageType, ServiceType, from_attributes, values_by_field
from catch_arena.text import one_line

_READ_S: Final = 0.5
"""Longest wait for the server to read the end of the services [s]."""
_CALL_S: Final = 0.005
"""Period in which all connections are read while a call waits for its response [s]."""
_LONGEST_FRAME: Final = 32 * 2**20
"""Size of the longest frame [bytes]; a longer one ends the connection.

rosbridge cuts messages at 10 MB, and a quote takes two bytes in a frame.
"""
_OWN_SERVICE: Final = "/rosbridge_websocket/get_parameters"
"""Service of rosbridge itself. Its response, or the error of a server without it, proves that all frames before the
call were read.
"""
_REAL: Final[Any] = float | None  # rosbridge writes null for a number that is not finite
_JSON: Final[dict[str, Any]] = {"string": str, "bool": bool, "float32": _REAL, "float64": _REAL}
"""JSON types of a field by ROS's name of its type; other fields are whole numbers."""


class _Inbox(NamedTuple):
    """Unread frames of one topic or service, and the function that handles each."""

    frames: deque[dict[str, Any]]
    handle: Callable[[dict[str, Any]], None]


class _OpenCall(NamedTuple):
    """A call that is not answered yet."""

    connection: ClientConnection
    service: str
    response: MessageType
    call: Future[Any]


class RosbridgeBus(Bus):
    """See `catch_arena.ros.middleware.bus.Bus`. If the server goes away, one line is logged."""

    backend = "rosbridge"

    def __init__(self, url: str, *, log: Log) -> None:
        self._url, self._log = url, OnceLog(log)
        self._inboxes: dict[tuple[str, str], _Inbox] = {}
        """Inboxes by the frames' operation ("publish", "call_service") and by topic or service."""
        self._calls: dict[str, _OpenCall] = {}
        self._ids = count(1)
        try:
            self._connection = _connection_to(url, open_s=5.0)
        except (OSError, ValueError, WebSocketException) as error:
            raise BusError(
                f"no rosbridge server answers at {url} ({one_line(str(error))}): start one where ROS is, "
                "with ros2 launch rosbridge_server rosbridge_websocket_launch.xml"
            ) from None

    def publisher(self, topic: str, kind: MessageType) -> Callable[[Any], None]:
        """Announce a topic."""
        self._send({"op": "advertise", "topic": topic, "type": kind.name})
        return lambda message: self._send({"op": "publish", "topic": topic, "msg": to_json(kind, message)})

    def subscribe(self, topic: str, kind: MessageType, on_message: Callable[[Any], object]) -> None:
        """Subscribe to a topic."""

        def handle(frame: dict[str, Any]) -> None:
            on_message(from_json(kind, frame.get("msg")))

        self._inboxes["publish", topic] = _Inbox(deque(maxlen=DEPTH), handle)
        # Without a queue_length: the thread of such a queue in rosbridge never ends if messages are left in it.
        self._send({"op": "subscribe", "topic": topic, "type": kind.name})

    def serve(self, service: str, kind: ServiceType, on_request: Callable[[Request], object]) -> None:
        """Answer a service."""

        def handle(frame: dict[str, Any]) -> None:
            respond = {"op": "service_response", "service": service, "id": frame.get("id")}

            def answer(response: Any) -> None:
                self._send({**respond, "values": to_json(kind.response, response), "result": True})

            try:
                request = from_json(kind.request, frame.get("args"))
            except ValueError as error:
                self._send({**respond, "values": str(error), "result": False})
                raise
            on_request(Request(request, answer))

        self._inboxes["call_service", service] = _Inbox(deque(maxlen=SERVICE_DEPTH), handle)
        self._send({"op": "advertise_service", "service": service, "type": kind.name})

    def client(self, service: str, kind: ServiceType) -> Client:
        """Return a client of a service, which is always ready.

        rosbridge itself waits for the server, and answers with an error if there is none.
        """
        return Client(lambda: True, partial(self._call, service, kind))

    def spin(self, timeout_s: float = 0.0) -> None:
        """Handle the frames that have come."""
        wait_s = min(timeout_s, _CALL_S) if self._calls else timeout_s
        if any(inbox.frames for inbox in self._inboxes.values()):
            wait_s = 0.0
        if not self._read(self._connection, wait_s):
            self._warn_once("the connection is lost: start the server and this command again")
        for name, one in list(self._calls.items()):
            if not self._read(one.connection):
                self._calls.pop(name, None)
        end = time.monotonic() + SPIN_S
        while sum(self._dispatch(key) for key in tuple(self._inboxes)) and time.monotonic() <= end:
            pass

    def close(self) -> None:
        """Leave the bus. Its services end first: rosbridge would keep them, and never answer their clients."""
        for one in self._calls.values():
            one.connection.close()
        self._calls.clear()
        self._end_services()
        self._connection.close()

    def _send(self, frame: dict[str, Any]) -> None:
        """Send a frame, or drop it if the server is away."""
        with suppress(OSError, WebSocketException):
            self._connection.send(json.dumps(frame))

    def _read(self, connection: ClientConnection, timeout_s: float = 0.0) -> bool:
        """Read frames of a connection into their inboxes, for SPIN_S; return False if the connection has ended."""
        end = math.inf
        try:
            while time.monotonic() < end:
                text = connection.recv(timeout_s)
                timeout_s, end = 0.0, min(end, time.monotonic() + SPIN_S)
                self._route(text)
        except TimeoutError:
            return True
        except WebSocketException:
            return False
        return True

    def _route(self, text: str | bytes) -> None:
        """Put a frame into its inbox; a full inbox drops its oldest frame."""
        if len(text) > LONGEST:
            self._warn_once(f"a frame of more than {LONGEST // 1024} KiB is left out")
            return
        try:
            frame = json.loads(text)
            operation = frame["op"]
        except (KeyError, TypeError, ValueError):
            self._warn_once(f"the server at {self._url} does not speak rosbridge's protocol")
            return
        if operation == "status":
            self._warn_once(str(frame.get("msg")))
        elif operation == "service_response":
            self._on_response(frame)
        else:
            inbox = self._inboxes.get((operation, frame.get("service", frame.get("topic"))))
            if inbox is not None:
                inbox.frames.append(frame)

    def _dispatch(self, key: tuple[str, str]) -> int:
        """Handle the oldest frame of an inbox, and return the number of handled frames: 0 or 1."""
        inbox = self._inboxes[key]
        if not inbox.frames:
            return 0
        try:
            inbox.handle(inbox.frames.popleft())
        except ValueError as error:
            self._warn_once(f"a message on {key[1]} cannot be read: {error}", key[1])
        return 1

    def _call(self, service: str, kind: ServiceType, request: Any) -> Future[Any]:
        """Call a service over a new connection: rosbridge reads no further frame of a connection until the response."""
        call: Future[Any] = Future()
        name = f"call_service:{service}:{next(self._ids)}"
        frame = {"op": "call_service", "id": name, "service": service, "args": to_json(kind.request, request)}
        with suppress(OSError, WebSocketException):
            connection = _connection_to(self._url, open_s=1.0)
            self._calls[name] = _OpenCall(connection, service, kind.response, call)
            connection.send(json.dumps(frame))
        if len(self._calls) > SERVICE_DEPTH:
            self._calls.pop(next(iter(self._calls))).connection.close()
        return call

    def _on_response(self, frame: dict[str, Any]) -> None:
        open_call = self._calls.pop(str(frame.get("id")), None)
        if open_call is None:
            return
        open_call.connection.close()
        if not frame.get("result"):
            self._warn_once(f"{open_call.service}: {frame.get('values')}")
            return
        try:
            open_call.call.set_result(from_json(open_call.response, frame.get("values")))
        except ValueError as error:
            self._warn_once(f"a message on {open_call.service} cannot be read: {error}", open_call.service)

    def _warn_once(self, problem: str, subject: str = "") -> None:
        self._log.warn(f"rosbridge: {one_line(problem)}", subject or problem)

    def _end_services(self) -> None:
        """End the services, and wait until rosbridge has read that: it drops unread frames when a connection ends."""
        served = [name for operation, name in self._inboxes if operation == "call_service"]
        if not served:
            return
        for service in served:
            self._send({"op": "unadvertise_service", "service": service})
        self._send({"op": "call_service", "service": _OWN_SERVICE, "args": {}})
        with suppress(TimeoutError, WebSocketException):
            while '"service_response"' not in str(self._connection.recv(_READ_S)):
                pass


def _connection_to(url: str, open_s: float) -> ClientConnection:
    opening = connect(
        url,
        proxy=None,  # the environment's proxies are for the Web, and some take 127.0.0.1 too
        open_timeout=open_s,
        close_timeout=1.0,
        max_size=_LONGEST_FRAME,
        max_queue=None,  # all frames of a flood are read, so that an inbox keeps the newest
        compression=None,
    )
    return ExitStack().enter_context(opening)  # websockets wants a context; `close` ends it


def to_json(kind: MessageType, message: Any) -> dict[str, Any]:
    """Return a message as rosbridge writes it."""
    return values_by_field(kind, message, to_json)


def from_json(kind: MessageType, values: Any) -> Any:
    """Return our message from rosbridge's JSON values, or raise ValueError for other fields or types."""
    try:
        return from_attributes(kind, msgspec.convert(values, _struct(kind)))
    except msgspec.ValidationError as error:
        raise ValueError(f"{kind.name}: {error}") from None


@cache
def _struct(kind: MessageType) -> Any:
    """Return the type by which msgspec checks a message."""
    fields: list[tuple[str, Any]] = []
    for name, word, is_sequence in kind.fields:
        one: Any = _JSON.get(word, int) if isinstance(word, str) else _struct(word)
        fields.append((name, list[one] if is_sequence else one))
    return msgspec.defstruct(kind.name.rpartition("/")[2], fields)
