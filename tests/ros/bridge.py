"""A small rosbridge server, written from the protocol's page: topics and services between its websocket clients.

It does as rosbridge_suite 2.1.0 where the page leaves it open:

- nothing more of a connection is read until a call that came over it is answered;
- a service stays when its client has gone, and nobody answers a call of it then;
- frames of a connection that were not read when it ended are forgotten.
"""

import json
import threading
from contextlib import contextmanager, suppress
from itertools import count
from queue import SimpleQueue

from websockets.exceptions import WebSocketException
from websockets.sync.server import serve


class Bridge:
    """Keeps all frames that it has read in `frames`; while a test holds `reading`, it reads no more."""

    def __init__(self):
        self.frames, self.services = [], {}
        self.reading = threading.RLock()
        self.clients = set()
        self._subscribers = {}
        self._callers = {}
        self._ids = count(1)

    def __call__(self, socket):
        """Serve one client, until it goes."""
        self.clients.add(socket)
        texts, gone = SimpleQueue(), threading.Event()
        threading.Thread(target=self._read, args=(socket, texts, gone), daemon=True).start()
        with suppress(WebSocketException):
            for text in socket:
                texts.put(text)
        gone.set()
        texts.put(None)
        with self.reading:
            self.clients.discard(socket)
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
                answered = getattr(self, f"on_{frame['op']}", lambda *_: None)(socket, frame)
            if answered is not None:
                answered.wait()

    def on_subscribe(self, socket, frame):
        self._subscribers.setdefault(frame["topic"], set()).add(socket)

    def on_publish(self, socket, frame):
        del socket
        for other in self._subscribers.get(frame["topic"], ()):
            send(other, {"op": "publish", "topic": frame["topic"], "msg": frame["msg"]})

    def on_advertise_service(self, socket, frame):
        self.services[frame["service"]] = socket

    def on_unadvertise_service(self, socket, frame):
        del socket
        self.services.pop(frame["service"], None)

    def on_call_service(self, socket, frame):
        """Pass a call on, and return the event to wait for."""
        service = frame["service"]
        if service not in self.services:
            self._respond(socket, frame, f"Service {service} does not exist", result=False)
            return None
        own, answered = f"service_request:{service}:{next(self._ids)}", threading.Event()
        self._callers[own] = socket, frame, answered
        args = frame.get("args", {})
        send(self.services[service], {"op": "call_service", "id": own, "service": service, "args": args})
        return answered

    def on_service_response(self, socket, frame):
        """Pass it on; services of ROS cannot say that they failed, so the caller of one that does waits for ever."""
        del socket
        if isinstance(frame["values"], dict):
            caller, call_frame, answered = self._callers.pop(frame["id"])
            self._respond(caller, call_frame, frame["values"], result=True)
            answered.set()

    def _respond(self, socket, call_frame, values, *, result):
        named = {"id": call_frame["id"]} if "id" in call_frame else {}
        answer = {"op": "service_response", "service": call_frame["service"], "values": values, "result": result}
        send(socket, answer | named)

    def raw(self, text):
        """Send a text to all clients."""
        for socket in list(self.clients):
            with suppress(WebSocketException):  # it may just be going
                socket.send(text)

    def hang_up(self):
        """Close all connections."""
        for socket in list(self.clients):
            socket.close()


def send(socket, frame):
    with suppress(WebSocketException):
        socket.send(json.dumps(frame))


@contextmanager
def running_bridge():
    """Run a server on a free port, and return it with its address."""
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
