"""Who else is on the DDS bus, as far as something would go wrong with them: told once, in one line."""

import re
from importlib.util import find_spec
from typing import Any, Final
from uuid import UUID

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription
from cyclonedds.core import Policy
from cyclonedds.domain import DomainParticipant

from catch_arena.ros.middleware.bus import Log
from catch_arena.ros.middleware.dds_types import dds_name
from catch_arena.ros.middleware.interfaces import MessageType
from catch_arena.ros.middleware.type_hashes import type_hash

FAST_DDS: Final = (
    "a node with Fast DDS, ROS's default middleware, {what}, and its services cannot be spoken to over cyclonedds: "
    "start it with RMW_IMPLEMENTATION=rmw_cyclonedds_cpp, or give --bus rclpy or --bus rosbridge"
)
"""The one line, with its ways out."""
_FAST_DDS_VENDOR: Final = b"\x01\x0f"
"""What Fast DDS's ids begin with; Cyclone's begin with 01 10."""
_TYPE_HASH: Final = re.compile(rb"typehash=(RIHS01_[0-9a-f]{64});")
_AT_ONCE: Final = 8
"""Of those that appeared, so many are read at a time, each for a tenth of a millisecond: a node that makes a client for
every call brings hundreds, which must not hold up one tick.
"""


class PeerWatch:
    """Reads which writers and readers appear on the bus.

    Args:
        participant: of this process.
        log: takes one line for each that something would go wrong with.
    """

    def __init__(self, participant: DomainParticipant, log: Log) -> None:
        self._appeared = [
            (BuiltinDataReader(participant, BuiltinTopicDcpsPublication), True),
            (BuiltinDataReader(participant, BuiltinTopicDcpsSubscription), False),
        ]
        self._own = participant.guid
        self._log = log
        self._expected: dict[str, MessageType] = {}
        self._served: dict[str, str] = {}
        self._warned: set[tuple[str, str]] = set()
        self._knows_fast_dds = False

    def expect(self, topic: str, kind: MessageType) -> None:
        """What is sent on a topic of DDS's."""
        self._expected[topic] = kind

    def serve(self, service: str, replies: str) -> None:
        """A service of this process, which nobody else should serve, and DDS's topic of its responses."""
        self._served[replies] = service

    def look(self) -> None:
        """At some of those who have appeared."""
        for reader, writes in self._appeared:
            for endpoint in reader.take(_AT_ONCE):
                if endpoint.sample_info.valid_data and endpoint.participant_key != self._own:
                    self._check(endpoint, writes=writes)

    def close(self) -> None:
        """Look no more."""
        self._appeared.clear()

    def _check(self, endpoint: Any, *, writes: bool) -> None:
        topic, kind = endpoint.topic_name, self._expected.get(endpoint.topic_name)
        if writes and topic in self._served:
            self._warn_once(
                topic,
                f"another node serves {self._served[topic]} too, so that whoever asks gets two answers: end a "
                "turtlesim or a spawner, whose part is played here; --domain gives another arena a domain of its own",
            )
            self._served.clear()  # one line, however many they have in common
        if kind is None:
            return
        if endpoint.type_name != dds_name(kind):
            self._warn_once(
                topic,
                f"{_ros_type(endpoint.type_name)} is what another node has on {topic[2:]}, where we have {kind.name}: "
                "they do not hear each other; --interfaces and --turtlesim name the packages",
            )
            return
        fails = topic.startswith("rq") or _has_list(kind)
        if fails and not self._knows_fast_dds and is_fast_dds(endpoint.participant_key):
            self._knows_fast_dds = True  # one line, whatever else such nodes call or hear
            self._warn_once(topic, FAST_DDS.format(what=f"has to do with {topic[2:].removesuffix('Request')}"))
        if topic.startswith("rt") and (announced := announced_hash(endpoint)) not in {None, own_hash(kind)}:
            self._warn_once(
                topic,
                f"another node has other fields in {kind.name}, on {topic[2:]}, so that numbers arrive as garbage: "
                f"ours are {_fields(kind)} ({announced})",
            )

    def _warn_once(self, topic: str, line: str) -> None:
        if (topic, line) not in self._warned:
            self._warned.add((topic, line))
            self._log(f"warning: {line}")


def _has_list(kind: MessageType) -> bool:
    """Fast DDS 3.2 takes no type of Cyclone's that holds a list."""
    return any(field.is_sequence for field in kind.fields)


def is_fast_dds(participant: UUID) -> bool:
    """By the vendor in its id."""
    return participant.bytes[:2] == _FAST_DDS_VENDOR


def announced_hash(endpoint: Any) -> str | None:
    """What a node of Iron or later says about its fields; older ones say nothing."""
    for policy in endpoint.qos:
        if isinstance(policy, Policy.Userdata) and (found := _TYPE_HASH.search(policy.data)):
            return found[1].decode()
    return None


def own_hash(kind: MessageType) -> str | None:
    """What a node of Iron or later would say about ours; None without rosbags, which works it out."""
    return type_hash(kind) if find_spec("rosbags") is not None else None


def _fields(kind: MessageType) -> str:
    """Of a message and of those in it, where the difference may be."""
    inner = {field.type.name: field.type for field in kind.fields if isinstance(field.type, MessageType)}
    own = f"«{'; '.join(kind.definition.splitlines())}»"
    return ", ".join([own, *(f"in {name} {_fields(one)}" for name, one in inner.items())])


def _ros_type(name: str) -> str:
    return name.replace("::dds_::", "/").replace("::", "/").removesuffix("_")
