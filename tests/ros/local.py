"""A bus inside one process: what is sent is there at once, in the order in which it was sent."""

from concurrent.futures import Future

from catch_arena.ros.middleware.bus import Bus, Client, Request


class Hub:
    """Hub that connects all buses of a test."""

    def __init__(self):
        self.subscribers = {}
        self.served = {}
        self.sent = {}
        self.publishers = {}

    def bus(self, name):
        return LocalBus(self, name)


class LocalBus(Bus):
    """See `catch_arena.ros.middleware.bus.Bus`; `name` is its node's."""

    backend = "cyclonedds"

    def __init__(self, hub, name):
        self.hub, self.name, self._queue = hub, name, []

    def publisher(self, topic, kind):
        del kind
        self.hub.publishers.setdefault(topic, set()).add(self.name)

        def publish(message):
            self.hub.sent.setdefault(topic, []).append(message)
            for bus, on_message in self.hub.subscribers.get(topic, ()):
                bus._queue.append(lambda on_message=on_message: on_message(message))

        return publish

    def subscribe(self, topic, kind, on_message):
        del kind
        self.hub.subscribers.setdefault(topic, []).append((self, on_message))

    def serve(self, service, kind, on_request):
        del kind
        self.hub.served[service] = self, on_request

    def client(self, service, kind):
        del kind

        def call(request):
            found = Future()
            bus, on_request = self.hub.served[service]
            bus._queue.append(lambda: on_request(Request(request, found.set_result)))
            return found

        return Client(lambda: service in self.hub.served, call)

    def publishers_of(self, topic):
        return len(self.hub.publishers.get(topic, ()))

    def gone(self):
        """Remove the publishers of a process that has ended."""
        for names in self.hub.publishers.values():
            names.discard(self.name)

    def spin(self, timeout_s=0.0):
        del timeout_s
        queue, self._queue = self._queue, []
        for act in queue:
            act()

    def close(self):
        pass
