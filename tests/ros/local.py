"""A bus inside one process: what is sent is there at once, in the order in which it was sent."""

from types import SimpleNamespace

from catch_arena.ros.middleware.bus import Call, Request, WithoutGraph


class Hub:
    """What all buses of a test are plugged into."""

    def __init__(self):
        self.heard = {}
        self.served = {}
        self.sent = {}
        self.publishers = {}

    def bus(self, peer=None):
        return LocalBus(self, peer)


class LocalBus(WithoutGraph):
    """See `catch_arena.ros.middleware.bus.Bus`; `peer` is who sends."""

    backend = "cyclonedds"

    def __init__(self, hub, peer):
        self.hub, self.peer, self._queue = hub, peer, []

    def publisher(self, topic, kind):
        del kind
        self.hub.publishers.setdefault(topic, set()).add(self.peer)

        def publish(message):
            self.hub.sent.setdefault(topic, []).append(message)
            for bus, on_message in self.hub.heard.get(topic, ()):
                bus._queue.append(lambda on_message=on_message: on_message(message, self.peer))

        return publish

    def subscribe(self, topic, kind, on_message):
        del kind
        self.hub.heard.setdefault(topic, []).append((self, on_message))

    def unsubscribe(self, topic):
        self.hub.heard[topic] = [one for one in self.hub.heard[topic] if one[0] is not self]

    def serve(self, service, kind, on_request):
        del kind
        self.hub.served[service] = self, on_request

    def client(self, service, kind):
        del kind

        def call(request):
            found = Call()
            bus, on_request = self.hub.served[service]
            answer = lambda response: setattr(found, "response", response)  # noqa: E731 - one line says it
            bus._queue.append(lambda: on_request(Request(request, self.peer, answer)))
            return found

        return SimpleNamespace(call=call, ready=service in self.hub.served)

    def publishers_of(self, topic):
        return frozenset(self.hub.publishers.get(topic, ()))

    def gone(self):
        """Its process has ended."""
        for peers in self.hub.publishers.values():
            peers.discard(self.peer)

    def spin(self, timeout_s=0.0):
        del timeout_s
        queue, self._queue = self._queue, []
        for act in queue:
            act()

    def close(self):
        pass
