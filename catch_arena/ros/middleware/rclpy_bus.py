"""The bus by ROS's own library, rclpy, over any middleware that is set there; services work too."""

import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import suppress
from importlib import import_module
from operator import attrgetter
from typing import Any

from catch_arena.ros.middleware.bus import DEPTH, SPIN_S, Bus, Client, Endpoint, EndpointKind, Request
from catch_arena.ros.middleware.interfaces import (
    Interfaces,
    MessageType,
    ServiceType,
    from_attributes,
    values_by_field,
)
from catch_arena.ros.middleware.ros_types import found_types, ros_class, turtlesim_package


class RclpyBus(Bus):
    """See `catch_arena.ros.middleware.bus.Bus`."""

    backend = "rclpy"

    def __init__(self, node: str, domain: int) -> None:
        rclpy = import_module("rclpy")
        groups, executors = import_module("rclpy.callback_groups"), import_module("rclpy.executors")
        self._future = import_module("rclpy.task").Future
        self.middleware = str(rclpy.get_rmw_implementation_identifier())
        self._context = rclpy.Context()
        rclpy.init(context=self._context, domain_id=domain)
        self._node = rclpy.create_node(node, context=self._context)
        self._group = groups.ReentrantCallbackGroup()
        """Group of all callbacks: in ROS's usual one an unanswered request keeps all else waiting."""
        self._executor = executors.SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._types: Interfaces | None = None
        self._handled = 0
        """Number of callbacks that have begun or ended."""
        self._open_requests = 0
        self._spinning = False
        self._unsent_responses = 0
        """Number of answers that were given and have not left yet."""

    def interfaces(self, given: Interfaces) -> Interfaces:
        """Return the types of the nodes on the bus, or else of the only package that has them."""
        if self._types is None:
            self._types = found_types(Interfaces(given.package, turtlesim_package(given.turtlesim)), self.graph)
        return self._types

    def graph(self) -> list[Endpoint]:
        """Return the endpoints of all other nodes.

        Endpoints are read topic by topic: for several nodes with one name ROS reports only the topics of the first.
        """
        node = self._node
        nodes = list(node.get_node_names_and_namespaces())
        own = node.get_name(), node.get_namespace()
        if own in nodes:
            nodes.remove(own)  # another node of that name stays: a second arena, with the same endpoints
        found = [end for topic, _ in node.get_topic_names_and_types() for end in self._ends_of(topic)]
        queries: tuple[tuple[EndpointKind, Any], ...] = (
            ("service", node.get_service_names_and_types_by_node),
            ("client", node.get_client_names_and_types_by_node),
        )
        for name, space in nodes:
            full = _full_name(space, name)
            for kind, query in queries:
                with suppress(RuntimeError):  # the node has just gone
                    found += [Endpoint(full, kind, end, word) for end, types in query(name, space) for word in types]
        present = {_full_name(space, name) for name, space in nodes}
        return [end for end in found if end.node in present]

    def _ends_of(self, topic: str) -> Iterator[Endpoint]:
        """Yield the publishers and subscriptions of a topic, and whether their fields are those of ours."""
        node = self._node
        own = node.get_namespace(), node.get_name()
        ends: list[tuple[EndpointKind, Any]] = [("publisher", one) for one in node.get_publishers_info_by_topic(topic)]
        ends += [("subscription", one) for one in node.get_subscriptions_info_by_topic(topic)]
        ours = {one.topic_type: _fields(one) for _, one in ends if (one.node_namespace, one.node_name) == own}
        for kind, one in ends:
            differ = _fields(one) != ours.get(one.topic_type, _fields(one))
            yield Endpoint(_full_name(one.node_namespace, one.node_name), kind, topic, one.topic_type, differ)

    def listeners_to(self, topic: str) -> int:
        """Return the number of a topic's subscriptions."""
        return int(self._node.count_subscribers(topic))

    def publisher(self, topic: str, kind: MessageType) -> Callable[[Any], None]:
        """Announce a topic."""
        made = self._node.create_publisher(ros_class(kind.name), topic, DEPTH)

        def publish(message: Any) -> None:
            if not self._spinning:
                self._send_responses()
            made.publish(to_ros(kind, message, ros_class(kind.name)()))

        return publish

    def subscribe(self, topic: str, kind: MessageType, on_message: Callable[[Any], object]) -> None:
        """Subscribe to a topic."""

        def on_ros_message(message: Any) -> None:
            self._handled += 1
            on_message(from_attributes(kind, message))

        self._node.create_subscription(ros_class(kind.name), topic, on_ros_message, DEPTH, callback_group=self._group)

    def serve(self, service: str, kind: ServiceType, on_request: Callable[[Request], object]) -> None:
        """Answer a service. Its callback is a coroutine, which the executor resumes when there is an answer.

        Answers that are given between two spins leave together, before the next message is published.
        """

        async def handle(request: Any, response: Any) -> Any:
            self._handled += 1
            self._open_requests += 1
            response_future = self._future(executor=self._executor)

            def answer(value: Any) -> None:
                self._unsent_responses += 1
                response_future.set_result(value)

            on_request(Request(from_attributes(kind.request, request), answer))
            value = await response_future
            self._open_requests -= 1
            self._unsent_responses -= 1
            self._handled += 1
            return to_ros(kind.response, value, response)

        self._node.create_service(ros_class(kind.name), service, handle, callback_group=self._group)

    def client(self, service: str, kind: ServiceType) -> Client:
        """Return a client of a service."""
        made = self._node.create_client(ros_class(kind.name), service, callback_group=self._group)

        def call(request: Any) -> Future[Any]:
            answer: Future[Any] = Future()

            def done(ros_future: Any) -> None:
                answer.set_result(from_attributes(kind.response, ros_future.result()))

            made.call_async(to_ros(kind.request, request, ros_class(kind.name).Request())).add_done_callback(done)
            return answer

        return Client(made.service_is_ready, call)

    def publishers_of(self, topic: str) -> int:
        """Return the number of publishers of a topic."""
        return int(self._node.count_publishers(topic))

    def spin(self, timeout_s: float = 0.0) -> None:
        """Handle the messages that have come.

        An executor handles one message in each turn, of all topics and services in turn, and resumes each unanswered
        request in between.
        """
        self._spinning = True
        idle, end = 0, None
        while end is None or (idle <= self._open_requests + 1 and time.monotonic() < end):
            handled_before = self._handled
            self._executor.spin_once(timeout_sec=timeout_s if end is None else 0.0)
            end = end or time.monotonic() + SPIN_S
            idle = 0 if self._handled > handled_before else idle + 1
        self._spinning = False

    def _send_responses(self) -> None:
        self._spinning = True
        end = time.monotonic() + SPIN_S
        while self._unsent_responses and time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.0)
        self._spinning = False

    def close(self) -> None:
        """Leave the bus."""
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()


def _fields(end: Any) -> Any:
    """Return the hash of an endpoint's fields; None in Humble, which has none."""
    return getattr(end, "topic_type_hash", None)


def _full_name(namespace: str, name: str) -> str:
    return f"{namespace.rstrip('/')}/{name}"


def to_ros(kind: MessageType, message: Any, target: Any) -> Any:
    """Fill ROS's message from ours."""
    values = values_by_field(kind, message, lambda word, one: to_ros(word, one, ros_class(word.name)()))
    for name, value in values.items():
        outer, _, inner = name.rpartition(".")
        if name:
            setattr(attrgetter(outer)(target) if outer else target, inner, value)
    return target
