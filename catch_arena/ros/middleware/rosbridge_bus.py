"""The bus by rosbridge's JSON over a websocket: any middleware and any ROS, on the side where the server runs."""

import json
import logging
import math
import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from itertools import count
from queue import SimpleQueue
from typing import Any, Final

from websockets.exceptions import WebSocketException
from websockets.sync.client import ClientConnection, connect

from catch_arena.errors import BusError
from catch_arena.ros.middleware.bus import DEPTH, LONGEST, SPIN_S, Call, Log, OnMessage, Peer, Request, WithoutGraph
from catch_arena.ros.middleware.interfaces import MessageType, ServiceType, values_by_field
from catch_arena.ros.middleware.names import Backend
from catch_arena.text import one_line

_logger = logging.getLogger("websockets.client")
if _logger.level == logging.NOTSET:  # with the root logger at DEBUG each frame writes a line
    _logger.setLevel(logging.INFO)

_OPEN_S: Final = 5.0
_AGAIN_S: Final = 1.0
"""After so long a connection that was lost is tried again."""
_CLOSE_S: Final = 1.0
_READ_S: Final = 0.5
"""So long the end waits for the server to read it."""
_LONGEST: Final = 32 * 2**20
"""Bytes of a frame; a longer one ends the connection. rosbridge cuts what is longer than 10 MB, and a quote in it takes
two bytes then.
"""
_REQUESTS: Final = 64
_OWN_SERVICE: Final = "/rosbridge_websocket/get_parameters"
"""rosbridge's own, whose response says that all before it was read; so does the error of a server without it."""
_INTEGERS: Final = {
    f"{sign}int{bits}": (-(2 ** (bits - 1)) if not sign else 0, 2 ** (bits - (not sign)) - 1)
    for sign in ("", "u")
    for bits in (8, 16, 32, 64)
}


class RosbridgeBus(WithoutGraph):
    """See `catch_arena.ros.middleware.bus.Bus`. A thread receives; where the server goes away, it is looked for
    until it is back.

    Args:
        url: the server's.
        log: takes one line whenever there is something that people should know.

    Raises:
        BusError: where no server answers.
    """

    def __init__(self, url: str, *, log: Log) -> None:
        self._url, self._log = url, log
        self._come = threading.Condition()
        self._inboxes: dict[tuple[str, str], deque[dict[str, Any]]] = {}
        self._handlers: dict[tuple[str, str], Callable[[dict[str, Any]], None]] = {}
        self._announced: list[dict[str, Any]] = []
        self._announcing = threading.Lock()
        """Held so that a new connection gets every announcement, and each once."""
        self._notes: deque[str] = deque(maxlen=100)
        self._complaints: deque[str] = deque(maxlen=100)
        self._unreadable: set[str] = set()
        self._ids = count(1)
        self._lines: list[_CallLine] = []
        self._beside: ClientConnection | None = None
        """The connection whose server the lines reach."""
        self._closing = False
        self._connection: ClientConnection | None = None
        first: Future[None] = Future()
        self._thread = threading.Thread(target=self._receive, args=(first,), name="rosbridge", daemon=True)
        self._thread.start()
        try:
            first.result()
        except Exception as error:  # noqa: BLE001 - whatever the thread could not do
            raise BusError(
                f"no rosbridge server answers at {url} ({one_line(str(error))}): start one where ROS is, "
                "with ros2 launch rosbridge_server rosbridge_websocket_launch.xml"
            ) from None

    @property
    def backend(self) -> Backend:
        """Which one it is."""
        return "rosbridge"

    def publisher(self, topic: str, kind: MessageType) -> Callable[[Any], None]:
        """Announce a topic."""
        self._announce({"op": "advertise", "topic": topic, "type": kind.name})

        def publish(message: Any) -> None:
            self._send({"op": "publish", "topic": topic, "msg": to_json(kind, message)})

        return publish

    def subscribe(self, topic: str, kind: MessageType, on_message: OnMessage) -> None:
        """Hear a topic; rosbridge does not say who sends."""

        def handle(frame: dict[str, Any]) -> None:
            on_message(from_json(kind, frame.get("msg")), None)

        self._handle(("publish", topic), DEPTH, handle)
        # Without a queue_length: its queue's thread in rosbridge never ends where it is left with something in it.
        self._announce({"op": "subscribe", "topic": topic, "type": kind.name})

    def unsubscribe(self, topic: str) -> None:
        """Hear it no more."""
        with self._come:
            del self._inboxes["publish", topic], self._handlers["publish", topic]
        told = ("subscribe", topic)
        with self._announcing:
            self._announced = [frame for frame in self._announced if (frame["op"], frame.get("topic")) != told]
            self._send({"op": "unsubscribe", "topic": topic})

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
            on_request(Request(request, None, answer))

        self._handle(("call_service", service), _REQUESTS, handle)
        self._announce({"op": "advertise_service", "service": service, "type": kind.name})

    def client(self, service: str, kind: ServiceType, on_failure: Log | None = None) -> "_BridgeClient":
        """Call a service."""
        client = _BridgeClient(service, kind, self._call, self._ids, on_failure or self._complain)
        self._handle(("service_response", service), _REQUESTS, client.handle)
        return client

    def publishers_of(self, topic: str) -> frozenset[Peer] | None:
        """Rosbridge does not tell."""
        del topic
        return None

    def spin(self, timeout_s: float = 0.0) -> None:
        """Take what has come."""
        with self._come:
            if timeout_s > 0.0 and not any(self._inboxes.values()):
                self._come.wait(timeout_s)
            notes = list(self._notes)
            self._notes.clear()
        for note in notes:
            self._log(note)
        end = time.monotonic() + SPIN_S
        busy = tuple(self._inboxes)
        while busy:
            busy = tuple(key for key in busy if self._hand_out(key))
            if time.monotonic() > end:
                break

    def close(self) -> None:
        """Leave the bus. The services end before it: rosbridge would keep them, and whoever calls one would wait for
        ever.
        """
        self._closing = True
        for line in self._lines:
            line.close()
        connection = self._connection
        if connection is not None:
            self._end_services()
            with suppress(OSError, WebSocketException):
                connection.close()
        self._thread.join(_CLOSE_S)

    def _hand_out(self, key: tuple[str, str]) -> bool:
        """The oldest frame of an inbox to its handler; whether there was one."""
        inbox = self._inboxes.get(key)  # a handler before it may have unsubscribed
        if not inbox:
            return False
        try:
            self._handlers[key](inbox.popleft())
        except ValueError as error:
            if key[1] not in self._unreadable:
                self._unreadable.add(key[1])
                self._log(f"warning: a message on {key[1]} cannot be read: {error}")
        return True

    def _handle(self, key: tuple[str, str], depth: int, handle: Callable[[dict[str, Any]], None]) -> None:
        with self._come:
            self._inboxes[key] = deque(maxlen=depth)
            self._handlers[key] = handle

    def _announce(self, frame: dict[str, Any]) -> None:
        with self._announcing:
            self._announced.append(frame)
            self._send(frame)

    def _end_services(self) -> None:
        """And wait until rosbridge has read it: when a connection ends it forgets what it has not read yet."""
        served = [name for does, name in self._handlers if does == "call_service"]
        if not served:
            return
        read = "service_response", _OWN_SERVICE
        self._handle(read, 1, lambda _: None)
        for service in served:
            self._send({"op": "unadvertise_service", "service": service})
        self._send({"op": "call_service", "service": _OWN_SERVICE, "args": {}})
        with self._come:
            self._come.wait_for(lambda: self._inboxes[read], _READ_S)

    def _call(self, frame: dict[str, Any]) -> None:
        """Over a line on which no other call is under way."""
        connection = self._connection
        if connection is None:
            return
        if self._beside is not connection:  # the server has been away, and so have they
            for line in self._lines:
                line.close()
            self._lines, self._beside = [], connection
        free = next((line for line in self._lines if line.is_free), None)
        if free is None:
            free = _CallLine(self._url, self._sort_in)
            self._lines.append(free)
            if len(self._lines) > _REQUESTS:  # nobody waits for one so old
                self._lines.pop(0).close()
        free.send(frame)

    def _send(self, frame: dict[str, Any]) -> None:
        """Nothing is kept for a server that is away: a pose of then is of no use later."""
        connection = self._connection
        if connection is not None:
            with suppress(OSError, WebSocketException):
                connection.send(json.dumps(frame))

    def _receive(self, first: "Future[None]") -> None:
        """The thread: frames into their inboxes, of which a full one loses its oldest."""
        while not self._closing:
            try:
                with _connection_to(self._url) as connection:
                    with self._announcing:
                        for frame in self._announced:
                            connection.send(json.dumps(frame))
                        self._connection = connection
                    if first.done():
                        self._note("rosbridge: the server is back")
                    else:
                        first.set_result(None)
                    for text in connection:
                        self._sort_in(text)
            except Exception as error:  # noqa: BLE001 - it would end the thread, and nobody would hear of it
                if not first.done():
                    first.set_exception(error)
                    return
            if self._connection is not None and not self._closing:
                self._note("warning: rosbridge: the connection is lost; it is tried again every second")
            self._connection = None
            if not self._closing:
                time.sleep(_AGAIN_S)

    def _sort_in(self, text: str | bytes) -> str:
        """A frame into its inbox; what it does, as rosbridge calls it."""
        if len(text) > LONGEST:
            self._complain(f"a frame of more than {LONGEST // 1024} KiB is left out")
            return ""
        try:
            frame = json.loads(text)
        except (ValueError, RecursionError):
            self._note("warning: rosbridge sent what is no JSON")
            return ""
        if not isinstance(frame, dict):
            return ""
        does = str(frame.get("op"))
        if does == "status":
            self._complain(str(frame.get("msg")))
        key = does, str(frame.get("service", frame.get("topic")))
        with self._come:
            if key in self._inboxes:
                self._inboxes[key].append(frame)
                self._come.notify()
        return does

    def _complain(self, what: str) -> None:
        """What the server says that it could not do."""
        line = f"warning: rosbridge: {one_line(what)}"
        if line not in self._complaints:
            self._complaints.append(line)
            self._note(line)

    def _note(self, line: str) -> None:
        with self._come:
            if line not in self._notes:
                self._notes.append(line)


class _CallLine:
    """A connection of its own for calls, one at a time. Until a call is answered rosbridge reads nothing else that
    comes over the same connection: Twists and responses would wait behind it, for ever where no answer comes.

    Args:
        url: the server's.
        sort_in: takes what comes, and tells what it does.
    """

    def __init__(self, url: str, sort_in: Callable[[str | bytes], str]) -> None:
        self._url, self._sort_in = url, sort_in
        self._frames: SimpleQueue[dict[str, Any] | None] = SimpleQueue()
        self._connection: ClientConnection | None = None
        self.is_free = True
        """Whether no call is under way; one that is lost with its connection stays so."""
        threading.Thread(target=self._run, name="rosbridge calls", daemon=True).start()

    def send(self, frame: dict[str, Any]) -> None:
        """Call."""
        self.is_free = False
        self._frames.put(frame)

    def close(self) -> None:
        """Whatever is under way."""
        self._frames.put(None)
        if self._connection is not None and not self.is_free:
            with suppress(OSError, WebSocketException):
                self._connection.close()

    def _run(self) -> None:
        with suppress(OSError, WebSocketException), _connection_to(self._url) as connection:
            self._connection = connection
            while (frame := self._frames.get()) is not None:
                connection.send(json.dumps(frame))
                while self._sort_in(connection.recv()) != "service_response":
                    pass
                self.is_free = True


class _BridgeClient:
    """See `catch_arena.ros.middleware.bus.Client`."""

    def __init__(
        self,
        service: str,
        kind: ServiceType,
        send: Callable[[dict[str, Any]], None],
        ids: "count[int]",
        on_failure: Log,
    ) -> None:
        self._service, self._kind, self._send, self._ids, self._on_failure = service, kind, send, ids, on_failure
        self._calls: dict[str, Call] = {}

    @property
    def ready(self) -> bool:
        """Rosbridge waits for the server itself, and answers with an error where there is none."""
        return True

    def call(self, request: Any) -> Call:
        """Ask."""
        name = f"call_service:{self._service}:{next(self._ids)}"
        self._calls[name] = call = Call()
        if len(self._calls) > _REQUESTS:  # nobody waits for one so old
            del self._calls[next(iter(self._calls))]
        arguments = to_json(self._kind.request, request)
        self._send({"op": "call_service", "id": name, "service": self._service, "args": arguments})
        return call

    def handle(self, frame: dict[str, Any]) -> None:
        """A response."""
        call = self._calls.pop(str(frame.get("id")), None)
        if call is None:
            return
        if frame.get("result"):
            call.response = from_json(self._kind.response, frame.get("values"))
        else:
            self._on_failure(one_line(f"{self._service}: {frame.get('values')}"))


def _connection_to(url: str) -> ClientConnection:
    return connect(
        url,
        proxy=None,  # those of the environment are for the Web, and some take 127.0.0.1 too
        open_timeout=_OPEN_S,
        close_timeout=_CLOSE_S,
        max_size=_LONGEST,
        compression=None,
    )


def to_json(kind: MessageType, message: Any) -> dict[str, Any]:
    """A message as rosbridge writes it."""
    return values_by_field(kind, message, to_json)


def from_json(kind: MessageType, values: Any) -> Any:
    """A message from rosbridge's.

    Raises:
        ValueError: for what is no such message, in one line.
    """
    if isinstance(values, list) and len(values) == len(kind.fields):  # the protocol knows arguments by their places
        values = {field.name: value for field, value in zip(kind.fields, values, strict=True)}
    if values is None and not kind.fields:
        values = {}
    if not isinstance(values, dict):
        raise ValueError(f"{kind.name} must be an object, got {_short(values)}")  # noqa: TRY004 - of the message
    found = []
    for name, word, is_sequence in kind.fields:
        if name not in values:
            raise ValueError(f"{kind.name} must have {name}")
        value = values[name]
        if is_sequence:
            if not isinstance(value, list):
                raise ValueError(f"{name} must be a list, got {_short(value)}")
            found.append(tuple(_value(name, word, one) for one in value))
        else:
            found.append(_value(name, word, value))
    return kind.make(*found)


def _value(name: str, word: str | MessageType, value: Any) -> Any:
    if not isinstance(word, str):
        return from_json(word, value)
    if word == "string" and isinstance(value, str):
        return value
    if word == "bool" and isinstance(value, bool):
        return value
    if word.startswith("float"):
        if value is None:  # rosbridge's word for NaN and the infinities, which JSON does not have
            return math.nan
        if isinstance(value, int | float) and not isinstance(value, bool):
            with suppress(OverflowError):
                return float(value)
    if word in _INTEGERS and isinstance(value, int) and not isinstance(value, bool):
        low, high = _INTEGERS[word]
        if low <= value <= high:
            return value
    raise ValueError(f"{name} must be a {word}, got {_short(value)}")


def _short(value: Any) -> str:
    return one_line(repr(value)[:100])
