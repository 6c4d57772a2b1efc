"""The bus over DDS, by the Python package cyclonedds: no ROS is needed on this side.

Topics reach nodes of any DDS middleware of ROS. Services have the layout of rmw_cyclonedds_cpp, in which a request and
its response begin with the client's id and a number; nodes with Fast DDS put both elsewhere, and cannot be answered.
"""

import time
from collections.abc import Callable
from concurrent.futures import Future
from functools import cache, partial
from itertools import count
from typing import Any, Final

from cyclonedds._clayer import ddspy_take
from cyclonedds.core import DDSException, Policy, Qos, ReadCondition, WaitSet
from cyclonedds.core import InstanceState as Instances
from cyclonedds.core import SampleState as Samples
from cyclonedds.core import ViewState as Views
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.idl.annotations import final
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from catch_arena.errors import BusError
from catch_arena.ros.middleware.bus import DEPTH, SERVICE_DEPTH, SPIN_S, Bus, Client, Log, OnceLog, Request
from catch_arena.ros.middleware.dds_domain import FAST_DDS, code_of, fast_dds_watch, is_fast_dds, join, ros_name
from catch_arena.ros.middleware.interfaces import MessageType, ServiceType, from_attributes, values_by_field
from catch_arena.ros.middleware.typestore import type_hash
from catch_arena.text import one_line

_ANY: Final[int] = Views.Any | Instances.Any | Samples.Any
_REPLY_WAIT_S: Final = 0.1
"""Longest wait of a response for its client's reader, which may be discovered after the request [s]."""
_MISSING_MEMBER: Final = "structure_needs_at_least_one_member"
"""The byte that ROS puts into a type without fields."""
_WORDS: Final[dict[str, Any]] = {"bool": bool, "string": str}
"""The package's types that have other names than ROS's."""
_sequence: Final[Any] = types.sequence

OnSample = Callable[[Any], object]


class DdsBus(Bus):
    """See `catch_arena.ros.middleware.bus.Bus`."""

    backend = "cyclonedds"

    def __init__(self, domain: int, *, log: Log) -> None:
        user = Policy.Userdata(b"enclave=/;")  # ROS recognises its own participants by it
        self._participant = join(domain, Qos(user))
        self._log = OnceLog(log)
        self._waiting = WaitSet(self._participant)
        self._readers: dict[str, tuple[DataReader[Any], OnSample]] = {}
        """Readers by their DDS topics, and the functions that handle their samples."""
        self._late_replies: list[Callable[[], None]] = []
        """Functions that send responses to clients whose readers were not matched before."""
        self._ids = count(1)
        self._not_with_fast_dds: set[str] = set()
        """DDS topics that do not work between Fast DDS and Cyclone."""
        self._watch = fast_dds_watch(self._participant, self._not_with_fast_dds, log)

    def publisher(self, topic: str, kind: MessageType) -> Callable[[Any], None]:
        """Announce a topic."""
        writer = self._writer(f"rt{topic}", kind)
        return lambda message: self._write(writer, to_sample(kind, message))

    def subscribe(self, topic: str, kind: MessageType, on_message: Callable[[Any], object]) -> None:
        """Subscribe to a topic."""
        self._reader(f"rt{topic}", kind, lambda sample: on_message(from_attributes(kind, sample)))

    def serve(self, service: str, kind: ServiceType, on_request: Callable[[Request], object]) -> None:
        """Answer a service."""
        user = f"serviceid={self._next_id()};"
        writer = self._writer(f"rr{service}Reply", kind.response, user)

        def on_sample(sample: Any) -> None:
            def answer(response: Any) -> None:
                reply = to_sample(kind.response, response, client=sample.client, number=sample.number)
                self._reply(writer, requests, reply, time.monotonic() + _REPLY_WAIT_S)

            on_request(Request(from_attributes(kind.request, sample), answer))

        requests = self._reader(f"rq{service}Request", kind.request, on_sample, user)

    def client(self, service: str, kind: ServiceType) -> Client:
        """Return a client of a service."""
        user = f"clientid={self._next_id()};"
        writer = self._writer(f"rq{service}Request", kind.request, user)
        own = writer.get_instance_handle() & 2**64 - 1
        numbers = count(1)
        calls: dict[int, Future[Any]] = {}

        def on_sample(sample: Any) -> None:  # all clients of the service share this topic
            if sample.client == own and (call := calls.pop(sample.number, None)) is not None:
                call.set_result(from_attributes(kind.response, sample))

        replies = self._reader(f"rr{service}Reply", kind.response, on_sample, user)

        def ready() -> bool:
            servers = writer.get_matched_subscriptions()
            for server in map(writer.get_matched_subscription_data, servers):
                if server is not None and is_fast_dds(str(server.participant_key)):
                    # Such a server never answers, and may run out of memory over the request.
                    raise BusError(FAST_DDS.format(use=f"serves {service}"))
            return bool(servers and replies.get_matched_publications())

        def call(request: Any) -> Future[Any]:
            number, answer = next(numbers), Future[Any]()
            calls[number] = answer
            if len(calls) > SERVICE_DEPTH:
                calls.pop(next(iter(calls)))
            self._write(writer, to_sample(kind.request, request, client=own, number=number))
            return answer

        return Client(ready, call)

    def publishers_of(self, topic: str) -> int:
        """Return the number of publishers of a subscribed topic."""
        return len(self._readers[f"rt{topic}"][0].get_matched_publications())

    def spin(self, timeout_s: float = 0.0) -> None:
        """Handle the samples that have come, one of each topic and service in each round."""
        if timeout_s > 0.0:
            self._waiting.wait(duration(seconds=min(timeout_s, _REPLY_WAIT_S) if self._late_replies else timeout_s))
        end = time.monotonic() + SPIN_S
        while sum(self._dispatch(*one) for one in tuple(self._readers.values())) and time.monotonic() <= end:
            pass
        late, self._late_replies = self._late_replies, []
        for reply in late:
            reply()
        next(self._watch, None)

    def close(self) -> None:
        """Leave the bus."""
        self._watch.close()
        self._readers.clear()
        self._late_replies.clear()
        del self._waiting, self._participant

    def _dispatch(self, reader: DataReader[Any], on_sample: OnSample) -> int:
        """Handle the oldest sample of a reader, and return the number of taken samples: 0 or 1."""
        taken = ddspy_take(reader._ref, _ANY, 1)  # noqa: SLF001 - the package's take cannot skip a bad sample
        topic = reader.topic
        if isinstance(taken, int):
            raise DDSException(taken, f"on {ros_name(topic.name)}")
        for data, info in taken:
            if not info.valid_data:
                continue
            try:
                sample = topic.data_type.deserialize(data)
            except Exception as error:  # noqa: BLE001 - messages of other nodes may fail anywhere in the decoder
                problem = f"a message on {ros_name(topic.name)} cannot be read"
                self._log.warn(f"{problem} ({type(error).__name__})", problem)
            else:
                on_sample(sample)
        return len(taken)

    def _reply(self, writer: DataWriter[Any], requests: DataReader[Any], sample: Any, due_s: float) -> None:
        """Send a response, before the monotonic time `due_s` [s] only if the readers of all clients are matched."""
        unmatched = len(writer.get_matched_subscriptions()) < len(requests.get_matched_publications())
        if unmatched and time.monotonic() < due_s and len(self._late_replies) < SERVICE_DEPTH:
            self._late_replies.append(partial(self._reply, writer, requests, sample, due_s))
        else:
            self._write(writer, sample)

    def _write(self, writer: DataWriter[Any], sample: Any) -> None:
        """Send a sample, or drop it with a warning if that fails: a requested name may hold a zero byte."""
        try:
            writer.write(sample)
        except Exception as error:  # noqa: BLE001 - the package raises nothing narrower for a value that is too long
            cause = code_of(error) if isinstance(error, DDSException) else one_line(str(error.__cause__ or error))
            problem = f"a message on {ros_name(writer.topic.name)} cannot be sent"
            self._log.warn(f"{problem} ({cause})", problem)

    def _next_id(self) -> str:
        """Return a new id by which other nodes match the reader and the writer of a service or a client."""
        head = self._participant.guid.bytes[:12]
        return ".".join(f"{byte:x}" for byte in head + next(self._ids).to_bytes(4, "big"))

    def _writer(self, topic: str, kind: MessageType, user: str = "") -> DataWriter[Any]:
        made: DataWriter[Any] = DataWriter(self._participant, self._topic(topic, kind), qos=_qos(kind, user))
        return made

    def _reader(self, topic: str, kind: MessageType, on_sample: OnSample, user: str = "") -> DataReader[Any]:
        made: DataReader[Any] = DataReader(self._participant, self._topic(topic, kind), qos=_qos(kind, user))
        self._waiting.attach(ReadCondition(made, Views.Any | Instances.Any | Samples.NotRead))
        self._readers[topic] = made, on_sample
        return made

    def _topic(self, topic: str, kind: MessageType) -> Topic[Any]:
        if topic.startswith("rq") or any(field.is_sequence for field in kind.fields):
            self._not_with_fast_dds.add(topic)  # Fast DDS 3.2 takes no type of Cyclone's that holds a list
        return Topic(self._participant, topic, idl_struct(kind))


def _is_of_service(kind: MessageType) -> bool:
    return "/srv/" in kind.name


def _qos(kind: MessageType, user: str) -> Qos:
    """Return ROS's usual quality of service, and a text for other nodes; services have deeper queues.

    Without another text a type's hash is announced: nodes of Iron and later warn of each topic without one.
    """
    return Qos(
        Policy.Reliability.Reliable(duration(milliseconds=100)),
        Policy.Durability.Volatile,
        Policy.History.KeepLast(SERVICE_DEPTH if _is_of_service(kind) else DEPTH),
        Policy.DataRepresentation(use_cdrv0_representation=True),
        Policy.WriterDataLifecycle(autodispose=False),
        Policy.Userdata((user or f"typehash={type_hash(kind)};").encode()),
    )


def dds_name(kind: MessageType) -> str:
    """Return DDS's name of a type: turtlesim::msg::dds_::Pose_."""
    package, folder, name = kind.name.split("/")
    return f"{package}::{folder}::dds_::{name}_"


@cache
def idl_struct(kind: MessageType) -> Any:
    """Return the package's own type of a message; those of services begin with the client's id and a number."""
    fields: dict[str, Any] = {"client": types.uint64, "number": types.int64} if _is_of_service(kind) else {}
    for name, word, is_sequence in kind.fields:
        one: Any = idl_struct(word) if isinstance(word, MessageType) else _WORDS.get(word) or getattr(types, word)
        fields[name] = _sequence[one] if is_sequence else one
    if not kind.fields:
        fields[_MISSING_MEMBER] = types.uint8
    return final(make_idl_struct(kind.name.rpartition("/")[2], dds_name(kind), fields))


def to_sample(kind: MessageType, message: Any, **header: int) -> Any:
    """Return a message as an object of the package's own type."""
    values = values_by_field(kind, message, to_sample) or {_MISSING_MEMBER: 0}
    return idl_struct(kind)(**header, **values)
