"""A small rosbridge server, written from the protocol's page: topics and services between its websocket clients.

Where the page leaves it open, it does as rosbridge_suite 2.1.0:

- errors go to its own log, and no client hears of them;
- nothing more of a connection is read until a call that came over it is answered;
- a service stays when its client has gone;
- of a connection that ends, what was not read yet is forgotten.
"""

import json
import threading
from contextlib import contextmanager, suppress
from itertools import count
from queue import SimpleQueue

from websockets.exceptions import WebSocketException
from websockets.sync.server import serve


class Bridge:
    """Everything that was read is kept in `frames`, and in `errors` what it could not do. Whoever holds `reading` keeps
    it from reading on.
    """

    def __init__(self):
        self.frames, self.errors = [], []
        self.services = {}
        self.reading = threading.RLock()
        self._clients = set()
        self._types = {}
        self._subscribers = {}
        self._callers = {}
        self._ids = count(1)

    def __call__(self, socket):
        """One client, until it goes."""
        self._clients.add(socket)
        texts, gone = SimpleQueue(), threading.Event()
        threading.Thread(target=self._read, args=(socket, texts, gone), daemon=True).start()
        with suppress(WebSocketException):
            for text in socket:
                texts.put(text)
        gone.set()
        texts.put(None)
        with self.reading:
            self._clients.discard(socket)
            for sockets in self._subscribers.values():
                sockets.discard(socket)

    def _read(self, socket, texts, gone):
        while True:
            text = texts.get()
            with self.reading:
                if gone.is_set():
                    return
                frame = json.loads(text)
                self.frames.append(frame)
                answered = getattr(self, f"on_{frame['op']}", self.refuse)(socket, frame)
            if answered is not None:
                answered.wait()

    def refuse(self, socket, frame):
        del socket
        self.errors.append(frame)

    def on_advertise(self, socket, frame):
        if self._types.setdefault(frame["topic"], frame["type"]) != frame["type"]:
            self.refuse(socket, frame)

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
        self.services[frame["service"]] = socket

    def on_unadvertise_service(self, socket, frame):
        if self.services.pop(frame["service"], None) is None:
            self.refuse(socket, frame)

    def on_call_service(self, socket, frame):
        """What to wait for."""
        service = frame["service"]
        if service not in self.services:
            said = f"Service {service} does not exist"
            send(socket, {"op": "service_response", "service": service, "values": said, "result": False} | named(frame))
            return None
        own = f"service_request:{service}:{next(self._ids)}"
        answered = threading.Event()
        self._callers[own] = socket, frame, answered
        asked = {"op": "call_service", "id": own, "service": service, "args": frame.get("args", {})}
        send(self.services[service], asked)
        return answered

    def on_service_response(self, socket, frame):
        """Services of ROS cannot say that they failed: then whoever called waits for ever."""
        if not isinstance(frame["values"], dict):
            self.refuse(socket, frame)
            return
        caller, asked, answered = self._callers.pop(frame["id"])
        answer = {"op": "service_response", "service": frame["service"], "values": frame["values"], "result": True}
        send(caller, answer | named(asked))
        answered.set()

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
