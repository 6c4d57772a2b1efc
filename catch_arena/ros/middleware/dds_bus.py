"""The bus over DDS, by the Python package cyclonedds: no ROS is needed on this side.

Topics reach nodes of any DDS middleware of ROS. Services have the layout of rmw_cyclonedds_cpp, in which a request and
its response begin with the client's id and a number; nodes with Fast DDS put both elsewhere, and cannot be answered.
"""

import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any, Final
from uuid import UUID

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
from catch_arena.ros.middleware.bus import DEPTH, SPIN_S, Call, Log, OnMessage, Peer, Request, WithoutGraph
from catch_arena.ros.middleware.dds_domain import Discovery, code_of, join
from catch_arena.ros.middleware.dds_peers import FAST_DDS, PeerWatch, is_fast_dds, own_hash
from catch_arena.ros.middleware.dds_types import idl_struct, ros_name, to_sample
from catch_arena.ros.middleware.interfaces import MessageType, ServiceType, from_attributes
from catch_arena.ros.middleware.names import Backend
from catch_arena.text import one_line

_SERVICE_DEPTH: Final = 64
"""Of what is written, and of responses."""
_REQUESTS: Final = 16
"""Of one sender, at one service, between two spins."""
_HISTORY: Final = 512
"""Samples that a reader keeps until it is looked at, of all senders together: one that floods must not push out what
others send, and 20,000 a second are 320 in a tick.
"""
_ANY: Final[int] = Views.Any | Instances.Any | Samples.Any
_REPLY_WAIT_S: Final = 0.1
"""A client may be asking before its reader of responses is known here: so long a response waits for it."""


class DdsBus(WithoutGraph):
    """See `catch_arena.ros.middleware.bus.Bus`.

    Args:
        node: what the node is called.
        domain: from 0 to 232.
        discovery: where others are looked for.
        log: takes one line whenever there is something that people should know.

    Raises:
        BusError: where it cannot be joined.
    """

    def __init__(self, node: str, domain: int, discovery: Discovery, *, log: Log) -> None:
        user = Policy.Userdata(b"enclave=/;")  # what ROS looks for in a participant that is one of its own
        self._participant = join(domain, discovery, Qos(user))
        self._node, self._log = node, log
        self._waiting = WaitSet(self._participant)
        self._readers: list[_Reader] = []
        self._topics: dict[str, _Reader] = {}
        self._late: list[_Reply] = []
        self._unsent: set[str] = set()
        self._ids = count(1)
        self._watch = PeerWatch(self._participant, log)

    @property
    def backend(self) -> Backend:
        """Which one it is."""
        return "cyclonedds"

    def publisher(self, topic: str, kind: MessageType) -> Callable[[Any], None]:
        """Announce a topic."""
        writer = self._writer(f"rt{_absolute(topic)}", kind, _announced(kind))

        def publish(message: Any) -> None:
            self._write(writer, to_sample(kind, message))

        return publish

    def subscribe(self, topic: str, kind: MessageType, on_message: OnMessage) -> None:
        """Hear a topic."""

        def on_sample(sample: Any, peer: Peer | None) -> None:
            on_message(from_attributes(kind, sample), peer)

        self._topics[topic] = self._reader(f"rt{_absolute(topic)}", kind, DEPTH, on_sample, _announced(kind))

    def unsubscribe(self, topic: str) -> None:
        """Hear it no more; the reader ends with its last reference."""
        gone = self._topics.pop(topic)
        gone.waiting.clear()
        self._readers.remove(gone)
        self._waiting.detach(gone.fresh)

    def serve(self, service: str, kind: ServiceType, on_request: Callable[[Request], object]) -> None:
        """Answer a service."""
        name = _absolute(service)
        self._watch.serve(name, f"rr{name}Reply")
        self._serve(name, kind, on_request)

    def client(self, service: str, kind: ServiceType, on_failure: Log | None = None) -> "_DdsClient":
        """Call a service."""
        del on_failure  # DDS does not tell
        user = Policy.Userdata(f"clientid={self._next_id()};".encode())
        name = _absolute(service)
        writer = self._writer(f"rq{name}Request", kind.request, user, header=True)
        client = _DdsClient(service, kind, writer, self._write)
        client.reader = self._reader(
            f"rr{name}Reply", kind.response, _SERVICE_DEPTH, client.on_sample, user, header=True
        ).reader
        return client

    def publishers_of(self, topic: str) -> frozenset[Peer] | None:
        """Who publishes on a topic that was subscribed to."""
        reader = self._topics[topic]
        return frozenset(
            peer for handle in _matched(reader.reader.get_matched_publications) if (peer := reader.peer(handle))
        )

    def spin(self, timeout_s: float = 0.0) -> None:
        """Take what has come."""
        if timeout_s > 0.0 and not any(reader.waiting for reader in self._readers):
            self._waiting.wait(duration(seconds=min(timeout_s, _REPLY_WAIT_S) if self._late else timeout_s))
        end = time.monotonic() + SPIN_S
        for reader in self._readers:
            reader.take()
        busy, senders = tuple(self._readers), max((len(reader.waiting) for reader in self._readers), default=0)
        while busy and (senders > 0 or time.monotonic() <= end):  # on a busy machine to take it all may have taken long
            busy = tuple(reader for reader in busy if reader.hand_out(self._log))
            senders -= 1
        if self._late:
            self._late = [reply for reply in self._late if not reply.send()]
        self._watch.look()

    def close(self) -> None:
        """Leave the bus."""
        self._watch.close()
        self._readers.clear()
        self._topics.clear()
        self._late.clear()
        del self._waiting, self._participant

    def _serve(self, name: str, kind: ServiceType, on_request: Callable[[Request], object]) -> None:
        user = Policy.Userdata(f"serviceid={self._next_id()};".encode())
        clients = _Clients(self._writer(f"rr{name}Reply", kind.response, user, header=True))

        def on_sample(sample: Any, peer: Peer | None) -> None:
            reply = _Reply(self._write, clients, kind.response, sample.client, sample.number, peer)
            on_request(
                Request(from_attributes(kind.request, sample), peer, lambda response: self._answer(reply, response))
            )

        self._reader(f"rq{name}Request", kind.request, _REQUESTS, on_sample, user, header=True)

    def _answer(self, reply: "_Reply", response: Any) -> None:
        reply.sample = to_sample(reply.kind, response, client=reply.client, number=reply.number)
        if not reply.send(may_wait=len(self._late) < _SERVICE_DEPTH):
            self._late.append(reply)

    def _write(self, writer: DataWriter[Any], sample: Any) -> None:
        """What cannot be sent, as a text with a zero byte in it, or too long a one, is left out: a stranger's name may
        be so.
        """
        try:
            writer.write(sample)
        except Exception as error:  # noqa: BLE001 - the package raises nothing narrower for what is too long
            topic = ros_name(writer.topic.name)
            if topic not in self._unsent:
                self._unsent.add(topic)
                why = code_of(error) if isinstance(error, DDSException) else one_line(str(error.__cause__ or error))
                self._log(f"warning: a message on {topic} cannot be sent ({why})")

    def _next_id(self) -> str:
        """What tells which reader and which writer belong to one end of a service."""
        head = self._participant.guid.bytes[:12]
        return ".".join(f"{byte:x}" for byte in head + next(self._ids).to_bytes(4, "big"))

    def _writer(self, topic: str, kind: MessageType, *policies: Any, header: bool = False) -> DataWriter[Any]:
        self._watch.expect(topic, kind)
        qos = _qos(DEPTH if not header else _SERVICE_DEPTH, Policy.WriterDataLifecycle(autodispose=False), *policies)
        made: DataWriter[Any] = DataWriter(self._participant, self._topic(topic, kind, header=header), qos=qos)
        return made

    def _reader(
        self,
        topic: str,
        kind: MessageType,
        depth: int,
        on_sample: Callable[[Any, Peer | None], None],
        *policies: Any,
        header: bool = False,
    ) -> "_Reader":
        self._watch.expect(topic, kind)
        reader: DataReader[Any] = DataReader(
            self._participant, self._topic(topic, kind, header=header), qos=_qos(_HISTORY, *policies)
        )
        made = _Reader(topic, reader, depth, on_sample)
        self._readers.append(made)
        self._waiting.attach(made.fresh)
        return made

    def _topic(self, topic: str, kind: MessageType, *, header: bool) -> Topic[Any]:
        return Topic(self._participant, topic, idl_struct(kind, header=header))


class _Reader:
    """One reader, and what its samples are given to. Each sender has a queue of its own, and they take turns.

    Args:
        topic: as DDS calls it.
        reader: DDS's.
        depth: of each sender's queue.
        on_sample: takes a sample, and who sent it.
    """

    def __init__(
        self, topic: str, reader: DataReader[Any], depth: int, on_sample: Callable[[Any, Peer | None], None]
    ) -> None:
        self.reader = reader
        self.fresh = ReadCondition(reader, Views.Any | Instances.Any | Samples.NotRead)
        self.waiting: dict[Peer | None, deque[bytes]] = {}
        """What has come, by its sender; whose turn it is comes first."""
        self._topic, self._depth, self._on_sample = topic, depth, on_sample
        self._peers: dict[int, Peer | None] = {}
        self._warned = False

    def take(self) -> None:
        """All that lies there, as bytes: to decode it takes longer, and much of a flood is lost before."""
        taken = ddspy_take(self.reader._ref, _ANY, _HISTORY)  # noqa: SLF001 - the package's own take decodes at once
        if isinstance(taken, int):
            raise DDSException(taken, f"on {ros_name(self._topic)}")
        for data, info in taken:
            if info.valid_data:
                peer = self.peer(info.publication_handle)
                self.waiting.setdefault(peer, deque(maxlen=self._depth)).append(data)

    def hand_out(self, log: Log) -> bool:
        """The oldest sample of the sender whose turn it is; whether there was one."""
        if not self.waiting:
            return False
        peer, queue = next(iter(self.waiting.items()))
        del self.waiting[peer]
        data = queue.popleft()
        if queue:  # behind the others
            self.waiting[peer] = queue
        try:
            sample = self.reader.topic.data_type.deserialize(data)
        except Exception as error:  # noqa: BLE001 - what strangers send may fail anywhere in the decoder
            if not self._warned:
                self._warned = True
                log(f"warning: a message on {ros_name(self._topic)} cannot be read: {type(error).__name__}")
        else:
            self._on_sample(sample, peer)
        return True

    def peer(self, handle: int) -> Peer | None:
        """Whose writer it is; kept, since a writer may be gone before its last sample is taken."""
        handle &= 2**64 - 1  # some calls tell it with a sign
        if handle not in self._peers:
            found = self.reader.get_matched_publication_data(handle)
            if found is None:
                return None
            self._peers[handle] = str(found.participant_key)
        return self._peers[handle]


class _Clients:
    """Who hears a service's responses. The exercise's controller makes a client for each call, and keeps them all: each
    is looked up once, which takes longer than to list them all.
    """

    def __init__(self, writer: DataWriter[Any]) -> None:
        self.writer = writer
        self._peers: dict[int, Peer] = {}

    def __contains__(self, peer: Peer) -> bool:
        known, self._peers = self._peers, {}
        for handle in _matched(self.writer.get_matched_subscriptions):
            if handle in known:
                self._peers[handle] = known[handle]
            elif (found := self.writer.get_matched_subscription_data(handle)) is not None:
                self._peers[handle] = str(found.participant_key)
        return peer in self._peers.values()


@dataclass(slots=True)
class _Reply:
    """A response that is to go to one client."""

    write: Callable[[DataWriter[Any], Any], None]
    clients: _Clients
    kind: MessageType
    client: int
    number: int
    peer: Peer | None
    sample: Any = None
    since: float = 0.0

    def send(self, *, may_wait: bool = True) -> bool:
        """Whether it was sent: it is where the client's reader is known, or has been waited for long enough."""
        now = time.monotonic()
        self.since = self.since or now
        may_wait = may_wait and now < self.since + _REPLY_WAIT_S
        if may_wait and self.peer is not None and self.peer not in self.clients:
            return False
        self.write(self.clients.writer, self.sample)
        return True


class _DdsClient:
    """See `catch_arena.ros.middleware.bus.Client`."""

    reader: DataReader[Any]

    def __init__(
        self,
        service: str,
        kind: ServiceType,
        writer: DataWriter[Any],
        write: Callable[[DataWriter[Any], Any], None],
    ) -> None:
        self._service, self._kind, self._writer, self._write = service, kind, writer, write
        self._own = writer.get_instance_handle() & 2**64 - 1
        self._numbers = count(1)
        self._calls: dict[int, Call] = {}
        self._order: deque[int] = deque()

    @property
    def ready(self) -> bool:
        """Whether somebody serves it."""
        servers = _participants(
            self._writer.get_matched_subscription_data, _matched(self._writer.get_matched_subscriptions)
        )
        if any(map(is_fast_dds, servers)):  # it would be called in vain, and may run out of memory over it
            raise BusError(FAST_DDS.format(what=f"serves {self._service}"))
        answering = _participants(
            self.reader.get_matched_publication_data, _matched(self.reader.get_matched_publications)
        )
        return bool(servers & answering)

    def call(self, request: Any) -> Call:
        """Ask."""
        number = next(self._numbers)
        self._calls[number] = call = Call()
        self._order.append(number)
        if len(self._order) > _SERVICE_DEPTH:  # nobody waits for one so old
            self._calls.pop(self._order.popleft(), None)
        self._write(self._writer, to_sample(self._kind.request, request, client=self._own, number=number))
        return call

    def on_sample(self, sample: Any, peer: Peer | None) -> None:
        """A response on the topic that all clients of the service share."""
        del peer
        if sample.client == self._own and (call := self._calls.pop(sample.number, None)) is not None:
            call.response = from_attributes(self._kind.response, sample)


def _matched(handles: Callable[[], list[int]]) -> list[int]:
    """Whom a reader or a writer has met. cyclonedds counts them first and lists them then: who comes in between is
    beyond the list's end.
    """
    while True:
        try:
            return handles()
        except IndexError:
            continue


def _participants(data_of: Callable[[int], Any], handles: Sequence[int]) -> set[UUID]:
    return {found.participant_key for handle in handles if (found := data_of(handle)) is not None}


def _qos(depth: int, *policies: Any) -> Qos:
    """ROS's usual quality of service, which its clients and services have too."""
    return Qos(
        Policy.Reliability.Reliable(duration(milliseconds=100)),
        Policy.Durability.Volatile,
        Policy.History.KeepLast(depth),
        Policy.DataRepresentation(use_cdrv0_representation=True),
        *policies,
    )


def _announced(kind: MessageType) -> Any:
    """The hash of a topic's type, as nodes of Iron and later announce it: they warn of each topic that says nothing."""
    told = own_hash(kind)
    return Policy.Userdata(b"" if told is None else f"typehash={told};".encode())


def _absolute(name: str) -> str:
    return name if name.startswith("/") else f"/{name}"
