"""A small rosbridge server, written from the protocol's page: topics and services between its websocket clients."""

import json
import threading
from contextlib import contextmanager, suppress
from itertools import count

from websockets.exceptions import WebSocketException
from websockets.sync.server import serve


class Bridge:
    """Everything that comes in is kept in `frames`."""

    def __init__(self):
        self.frames = []
        self._lock = threading.RLock()
        self._clients = set()
        self._types = {}
        self._subscribers = {}
        self._servers = {}
        self._callers = {}
        self._ids = count(1)

    def __call__(self, socket):
        """One client, until it goes."""
        self._clients.add(socket)
        with suppress(WebSocketException):
            for text in socket:
                frame = json.loads(text)
                with self._lock:
                    self.frames.append(frame)
                    getattr(self, f"on_{frame['op']}", self.refuse)(socket, frame)
        with self._lock:
            self._clients.discard(socket)
            for sockets in self._subscribers.values():
                sockets.discard(socket)
            self._servers = {service: one for service, one in self._servers.items() if one is not socket}

    def refuse(self, socket, frame):
        send(socket, {"op": "status", "level": "error", "msg": f"Unknown operation: {frame['op']}"})

    def on_advertise(self, socket, frame):
        if self._types.setdefault(frame["topic"], frame["type"]) != frame["type"]:
            said = f"{frame['topic']} is already established with type {self._types[frame['topic']]}"
            send(socket, {"op": "status", "level": "error", "msg": said})

    def on_subscribe(self, socket, frame):
        self._subscribers.setdefault(frame["topic"], set()).add(socket)

    def on_unsubscribe(self, socket, frame):
        self._subscribers[frame["topic"]].discard(socket)

    def on_publish(self, socket, frame):
        if frame["topic"] not in self._types:
            self.refuse(socket, frame)
        for other in self._subscribers.get(frame["topic"], ()):
            send(other, {"op": "publish", "topic": frame["topic"], "msg": frame["msg"]})

    def on_advertise_service(self, socket, frame):
        self._servers[frame["service"]] = socket

    def on_call_service(self, socket, frame):
        service = frame["service"]
        if service not in self._servers:
            said = f"Service {service} does not exist"
            send(socket, {"op": "service_response", "service": service, "values": said, "result": False} | named(frame))
            return
        own = f"service_request:{service}:{next(self._ids)}"
        self._callers[own] = socket, frame
        asked = {"op": "call_service", "id": own, "service": service, "args": frame.get("args", {})}
        send(self._servers[service], asked)

    def on_service_response(self, socket, frame):
        del socket
        caller, asked = self._callers.pop(frame["id"])
        answer = {"op": "service_response", "service": frame["service"], "result": frame["result"]}
        send(caller, answer | {"values": frame.get("values", {})} | named(asked))

    def raw(self, text):
        """Send something to all clients, whatever it is."""
        for socket in list(self._clients):
            with suppress(WebSocketException):  # it may just be going
                socket.send(text)

    def hang_up(self):
        """On all clients."""
        for socket in list(self._clients):
            socket.close()


def named(frame):
    return {"id": frame["id"]} if "id" in frame else {}


def send(socket, frame):
    with suppress(WebSocketException):
        socket.send(json.dumps(frame))


@contextmanager
def running_bridge():
    """A server on a free port: it, and its address."""
    bridge = Bridge()
    with serve(bridge, "127.0.0.1", 0) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        try:
            yield bridge, f"ws://127.0.0.1:{server.socket.getsockname()[1]}"
        finally:
            bridge.hang_up()
            server.shutdown()
            thread.join(5)
