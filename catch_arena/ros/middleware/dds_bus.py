"""The bus over DDS, by the Python package cyclonedds: no ROS is needed on this side.

Topics reach nodes of any DDS middleware of ROS. Services have the layout of rmw_cyclonedds_cpp, in which a request and
its response begin with the client's id and a number; nodes with Fast DDS put both elsewhere, and cannot be answered.
"""

import time
from collections import deque
from collections.abc import Callable
from itertools import count
from typing import Any, Final, NamedTuple

from cyclonedds._clayer import ddspy_take
from cyclonedds.core import DDSException, Policy, Qos, ReadCondition, WaitSet
from cyclonedds.core import InstanceState as Instances
from cyclonedds.core import SampleState as Samples
from cyclonedds.core import ViewState as Views
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from catch_arena.errors import BusError
from catch_arena.ros.middleware.bus import DEPTH, SPIN_S, Call, Log, OnceLog, OnMessage, Peer, Request, WithoutGraph
from catch_arena.ros.middleware.dds_domain import code_of, join
from catch_arena.ros.middleware.dds_peers import FAST_DDS, FastDdsWatch, Peers, is_fast_dds
from catch_arena.ros.middleware.dds_types import idl_struct, ros_name, to_sample
from catch_arena.ros.middleware.interfaces import MessageType, ServiceType, from_attributes
from catch_arena.ros.middleware.names import Backend
from catch_arena.ros.middleware.typestore import type_hash
from catch_arena.text import one_line

_SERVICE_DEPTH: Final = 64
"""Requests and responses that are kept until they are sent or answered."""
_REQUESTS: Final = 16
"""Requests of one sender at one service that are kept between two spins."""
_HISTORY: Final = 512
"""Samples of all senders together that a reader keeps between two spins: a flood of 20,000 a second brings 320 in a
tick, and must not push out what others send.
"""
_ANY: Final[int] = Views.Any | Instances.Any | Samples.Any
_REPLY_WAIT_S: Final = 0.1
"""A response waits so long for its client's reader, which may become known later than the request."""

OnSample = Callable[[Any, Peer | None], None]


class DdsBus(WithoutGraph):
    """See `catch_arena.ros.middleware.bus.Bus`.

    Args:
        domain: from 0 to 232.
        log: takes one line whenever there is something that people should know.

    Raises:
        BusError: if it cannot be joined.
    """

    def __init__(self, domain: int, *, log: Log) -> None:
        user = Policy.Userdata(b"enclave=/;")  # ROS recognises participants of its own by it
        self._participant = join(domain, Qos(user))
        self._log_once = OnceLog(log)
        self._waiting = WaitSet(self._participant)
        self._readers: list[_Reader] = []
        self._topics: dict[str, _Reader] = {}
        self._late: list[_Reply] = []
        self._ids = count(1)
        self._watch = FastDdsWatch(self._participant, log)

    @property
    def backend(self) -> Backend:
        """Name of the back-end."""
        return "cyclonedds"

    def publisher(self, topic: str, kind: MessageType) -> Callable[[Any], None]:
        """Announce a topic."""
        writer = self._writer(f"rt{_absolute(topic)}", kind, _announced(kind))
        return lambda message: self._write(writer, to_sample(kind, message))

    def subscribe(self, topic: str, kind: MessageType, on_message: OnMessage) -> None:
        """Subscribe to a topic."""

        def on_sample(sample: Any, peer: Peer | None) -> None:
            on_message(from_attributes(kind, sample), peer)

        self._topics[topic] = self._reader(f"rt{_absolute(topic)}", kind, DEPTH, on_sample, _announced(kind))

    def unsubscribe(self, topic: str) -> None:
        """End a subscription; DDS's reader ends with its last reference."""
        gone = self._topics.pop(topic)
        gone.queues.clear()
        self._readers.remove(gone)
        self._waiting.detach(gone.fresh)

    def serve(self, service: str, kind: ServiceType, on_request: Callable[[Request], object]) -> None:
        """Answer a service."""
        name = _absolute(service)
        user = Policy.Userdata(f"serviceid={self._next_id()};".encode())
        writer = self._writer(f"rr{name}Reply", kind.response, user, header=True)
        clients = Peers(writer)

        def on_sample(sample: Any, peer: Peer | None) -> None:
            def answer(response: Any) -> None:
                answered = to_sample(kind.response, response, client=sample.client, number=sample.number)
                self._reply(_Reply(writer, clients, peer, answered, time.monotonic() + _REPLY_WAIT_S))

            on_request(Request(from_attributes(kind.request, sample), peer, answer))

        self._reader(f"rq{name}Request", kind.request, _REQUESTS, on_sample, user, header=True)

    def client(self, service: str, kind: ServiceType, on_failure: Log | None = None) -> "_DdsClient":
        """Return a client of a service."""
        del on_failure  # DDS does not tell
        user = Policy.Userdata(f"clientid={self._next_id()};".encode())
        name = _absolute(service)
        writer = self._writer(f"rq{name}Request", kind.request, user, header=True)
        client = _DdsClient(service, kind, writer, self._write)
        reader = self._reader(f"rr{name}Reply", kind.response, _SERVICE_DEPTH, client.on_sample, user, header=True)
        client.answering = reader.peers
        return client

    def publishers_of(self, topic: str) -> frozenset[Peer] | None:
        """Return who publishes on a topic that was subscribed to."""
        return self._topics[topic].peers.present()

    def spin(self, timeout_s: float = 0.0) -> None:
        """Handle what has come, one sample of each sender in each round."""
        if timeout_s > 0.0 and not any(queue for reader in self._readers for queue in reader.queues.values()):
            self._waiting.wait(duration(seconds=min(timeout_s, _REPLY_WAIT_S) if self._late else timeout_s))
        end = time.monotonic() + SPIN_S
        for reader in self._readers:
            reader.take()
        while sum(reader.hand_out() for reader in tuple(self._readers)) and time.monotonic() <= end:
            pass
        late, self._late = self._late, []
        for reply in late:
            self._reply(reply)
        self._watch.look()

    def close(self) -> None:
        """Leave the bus."""
        self._watch.close()
        self._readers.clear()
        self._topics.clear()
        self._late.clear()
        del self._waiting, self._participant

    def _reply(self, reply: "_Reply") -> None:
        """Send a response if its client's reader is known or has been waited for long enough; else keep it."""
        is_early = time.monotonic() < reply.due_s and len(self._late) < _SERVICE_DEPTH
        if is_early and reply.peer not in reply.clients.present():
            self._late.append(reply)
        else:
            self._write(reply.writer, reply.sample)

    def _write(self, writer: DataWriter[Any], sample: Any) -> None:
        """Send a sample; one that cannot be sent is left out, since a stranger's name may hold a zero byte."""
        try:
            writer.write(sample)
        except Exception as error:  # noqa: BLE001 - the package raises nothing narrower for what is too long
            why = code_of(error) if isinstance(error, DDSException) else one_line(str(error.__cause__ or error))
            self._warn_once(f"a message on {ros_name(writer.topic.name)} cannot be sent", why)

    def _warn_once(self, what: str, why: str) -> None:
        self._log_once(f"warning: {what} ({why})", what)

    def _next_id(self) -> str:
        """Return the id by which a service's reader and writer are known to belong together."""
        head = self._participant.guid.bytes[:12]
        return ".".join(f"{byte:x}" for byte in head + next(self._ids).to_bytes(4, "big"))

    def _writer(self, topic: str, kind: MessageType, *policies: Any, header: bool = False) -> DataWriter[Any]:
        qos = _qos(DEPTH if not header else _SERVICE_DEPTH, Policy.WriterDataLifecycle(autodispose=False), *policies)
        made: DataWriter[Any] = DataWriter(self._participant, self._topic(topic, kind, header=header), qos=qos)
        return made

    def _reader(
        self, topic: str, kind: MessageType, depth: int, on_sample: OnSample, *policies: Any, header: bool = False
    ) -> "_Reader":
        reader: DataReader[Any] = DataReader(
            self._participant, self._topic(topic, kind, header=header), qos=_qos(_HISTORY, *policies)
        )
        made = _Reader(reader, depth, on_sample, self._warn_once)
        self._readers.append(made)
        self._waiting.attach(made.fresh)
        return made

    def _topic(self, topic: str, kind: MessageType, *, header: bool) -> Topic[Any]:
        if topic.startswith("rq") or any(field.is_sequence for field in kind.fields):
            self._watch.topics.add(topic)  # Fast DDS 3.2 takes no type of Cyclone's that holds a list
        return Topic(self._participant, topic, idl_struct(kind, header=header))


class _Reader:
    """One reader, with a queue for each sender.

    Args:
        reader: DDS's.
        depth: of each queue, which loses its oldest.
        on_sample: takes a sample, and who sent it.
        warn: takes what is wrong, and why.
    """

    def __init__(
        self, reader: DataReader[Any], depth: int, on_sample: OnSample, warn: Callable[[str, str], None]
    ) -> None:
        self.fresh = ReadCondition(reader, Views.Any | Instances.Any | Samples.NotRead)
        self.peers = Peers(reader)
        self.queues: dict[Peer | None, deque[bytes]] = {}
        """Samples that have come, as bytes, by their sender."""
        self._reader, self._depth, self._on_sample, self._warn = reader, depth, on_sample, warn
        self._name = ros_name(reader.topic.name)

    def take(self) -> None:
        """Take all samples as bytes: decoding takes longer, and most of a flood is lost before it."""
        taken = ddspy_take(self._reader._ref, _ANY, _HISTORY)  # noqa: SLF001 - the package's own take decodes too
        if isinstance(taken, int):
            raise DDSException(taken, f"on {self._name}")
        for data, info in taken:
            if info.valid_data:
                peer = self.peers.of(info.publication_handle)
                self.queues.setdefault(peer, deque(maxlen=self._depth)).append(data)

    def hand_out(self) -> int:
        """Handle the oldest sample of each sender, and return their number."""
        waiting = [(peer, queue) for peer, queue in self.queues.items() if queue]
        for peer, queue in waiting:
            try:
                sample = self._reader.topic.data_type.deserialize(queue.popleft())
            except Exception as error:  # noqa: BLE001 - what strangers send may fail anywhere in the decoder
                self._warn(f"a message on {self._name} cannot be read", type(error).__name__)
            else:
                self._on_sample(sample, peer)
        return len(waiting)


class _Reply(NamedTuple):
    """A response that is to go to one client."""

    writer: DataWriter[Any]
    clients: Peers
    """The processes that read responses."""
    peer: Peer | None
    """The client's process."""
    sample: Any
    due_s: float
    """The time at which it is sent in any case."""


class _DdsClient:
    """See `catch_arena.ros.middleware.bus.Client`."""

    answering: Peers
    """The processes that send responses."""

    def __init__(
        self,
        service: str,
        kind: ServiceType,
        writer: DataWriter[Any],
        write: Callable[[DataWriter[Any], Any], None],
    ) -> None:
        self._service, self._kind, self._writer, self._write = service, kind, writer, write
        self._servers = Peers(writer)
        self._own = writer.get_instance_handle() & 2**64 - 1
        self._numbers = count(1)
        self._calls: dict[int, Call] = {}

    @property
    def ready(self) -> bool:
        """True if a node serves it."""
        servers = self._servers.present()
        if any(map(is_fast_dds, servers)):  # it never answers, and may run out of memory over the request
            raise BusError(FAST_DDS.format(what=f"serves {self._service}"))
        return bool(servers & self.answering.present())

    def call(self, request: Any) -> Call:
        """Send a request."""
        number = next(self._numbers)
        self._calls[number] = call = Call()
        if len(self._calls) > _SERVICE_DEPTH:  # the oldest is not waited for any more
            del self._calls[next(iter(self._calls))]
        self._write(self._writer, to_sample(self._kind.request, request, client=self._own, number=number))
        return call

    def on_sample(self, sample: Any, peer: Peer | None) -> None:
        """Handle a response on the topic that all clients of the service share."""
        del peer
        if sample.client == self._own and (call := self._calls.pop(sample.number, None)) is not None:
            call.response = from_attributes(self._kind.response, sample)


def _qos(depth: int, *policies: Any) -> Qos:
    """Return ROS's usual quality of service, which its clients and services have too."""
    return Qos(
        Policy.Reliability.Reliable(duration(milliseconds=100)),
        Policy.Durability.Volatile,
        Policy.History.KeepLast(depth),
        Policy.DataRepresentation(use_cdrv0_representation=True),
        *policies,
    )


def _announced(kind: MessageType) -> Any:
    """Return the policy that announces a type's hash: nodes of Iron and later warn of each topic without one."""
    return Policy.Userdata(f"typehash={type_hash(kind)};".encode())


def _absolute(name: str) -> str:
    return name if name.startswith("/") else f"/{name}"
