"""The node that this process is in ROS's graph, as `ros2 node list` shows it: the topic ros_discovery_info.

On it each ROS process tells which of its DDS readers and writers belong to which node. What stands for a reader or a
writer there, its gid, has 24 bytes up to Humble and 16 from Iron on, under one name of the type. So nothing is told
until a ROS process has appeared: whether that one announces a hash of the type says which it is, and who nobody
listens to need not tell.
"""

from collections.abc import Sequence
from functools import cache
from typing import Any, Final
from uuid import UUID

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.idl.annotations import final
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from catch_arena.ros.middleware.dds_peers import announced_hash

_TOPIC: Final = "ros_discovery_info"
_HUMBLE, _IRON = 24, 16
"""Bytes of a gid: up to the one, and from the other on."""
_LONGEST_NAME: Final = 256
_array: Final[Any] = types.array
_sequence: Final[Any] = types.sequence
_bounded_text: Final[Any] = types.bounded_str


class Graph:
    """Tells which readers and writers the node has, whenever it has others than before.

    Args:
        participant: of this process.
        node: what the node is called.
    """

    def __init__(self, participant: DomainParticipant, node: str) -> None:
        self._participant, self._node = participant, node
        self._readers: list[UUID] = []
        self._writers: list[UUID] = []
        self._size = _IRON
        self._writer: DataWriter[Any] | None = None
        self._changed = True

    def add_reader(self, guid: UUID) -> None:
        """The node has one more."""
        self._readers.append(guid)
        self._changed = True

    def remove_reader(self, guid: UUID) -> None:
        """The node has one less."""
        self._readers.remove(guid)
        self._changed = True

    def add_writer(self, guid: UUID) -> None:
        """The node has one more."""
        self._writers.append(guid)
        self._changed = True

    def hear_of(self, writer: Any) -> None:
        """A writer of another process; the first one of a ROS process says which layout is spoken."""
        if writer.topic_name == _TOPIC and self._writer is None:
            told = announced_hash(writer)
            self._size = _HUMBLE if told is None else _IRON
            self._writer = self._make_writer("" if told is None else f"typehash={told};")

    def tell(self) -> None:
        """Where there is news, and a ROS process that may hear it."""
        if self._writer is not None and self._changed:
            self._writer.write(self._info())
            self._changed = False

    def close(self) -> None:
        """Tell no more; the others forget the node with its participant."""
        self._writer = None

    def _make_writer(self, user: str) -> "DataWriter[Any]":
        """With the hash that the other announced, which is of the same type."""
        qos = Qos(
            Policy.Reliability.Reliable(duration(milliseconds=100)),
            Policy.Durability.TransientLocal,
            Policy.History.KeepLast(1),
            Policy.DataRepresentation(use_cdrv0_representation=True),
            Policy.WriterDataLifecycle(autodispose=False),
            Policy.Userdata(user.encode()),
        )
        info, _, _ = _structs(self._size)
        return DataWriter(self._participant, Topic(self._participant, _TOPIC, info), qos=qos)

    def _info(self) -> Any:
        info, node, gid = _structs(self._size)

        def gid_of(guid: UUID) -> Any:
            return gid(data=list(guid.bytes.ljust(self._size, b"\0")))

        def gids_of(guids: Sequence[UUID]) -> list[Any]:
            return list(map(gid_of, guids))

        own = node(
            node_namespace="/",
            node_name=self._node,
            reader_gid_seq=gids_of(self._readers),
            writer_gid_seq=gids_of(self._writers),
        )
        return info(gid=gid_of(self._participant.guid), node_entities_info_seq=[own])


@cache
def _structs(size: int) -> tuple[Any, Any, Any]:
    """ParticipantEntitiesInfo, and what is in it, with gids of so many bytes."""
    gid = _struct("Gid", data=_array[types.uint8, size])
    node = _struct(
        "NodeEntitiesInfo",
        node_namespace=_bounded_text[_LONGEST_NAME],
        node_name=_bounded_text[_LONGEST_NAME],
        reader_gid_seq=_sequence[gid],
        writer_gid_seq=_sequence[gid],
    )
    return _struct("ParticipantEntitiesInfo", gid=gid, node_entities_info_seq=_sequence[node]), node, gid


def _struct(name: str, **fields: Any) -> Any:
    return final(make_idl_struct(name, f"rmw_dds_common::msg::dds_::{name}_", fields))
