"""The other processes on the DDS bus: which of them a reader or a writer has met, and which use Fast DDS."""

from typing import Any, Final

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader

from catch_arena.ros.middleware.bus import Log, Peer
from catch_arena.ros.middleware.dds_types import ros_name

FAST_DDS: Final = (
    "a node with Fast DDS, ROS's default middleware, {what}, and its services cannot be spoken to over cyclonedds: "
    "start it with RMW_IMPLEMENTATION=rmw_cyclonedds_cpp, or give --bus rclpy or --bus rosbridge"
)
"""The one line, with its ways out."""
_FAST_DDS_VENDOR: Final = "010f"
"""Ids of Fast DDS begin with it; Cyclone's begin with 0110."""
_AT_ONCE: Final = 8
"""Readers and writers that are examined in one spin, each for 0.1 ms, so that hundreds do not hold up a tick."""


class Peers:
    """The processes that a reader or a writer has met.

    Each is looked up once, since that takes 0.1 ms and a node that makes a client for every call brings hundreds. It is
    kept when it has gone, since its last samples may be read later.

    Args:
        end: the reader or the writer.
    """

    def __init__(self, end: "DataReader[Any] | DataWriter[Any]") -> None:
        self._end = end
        self._known: dict[int, Peer] = {}

    def of(self, handle: int) -> Peer | None:
        """Return the process behind a handle of DDS; None if it left before it was looked up."""
        handle &= 2**64 - 1  # some calls return it with a sign
        if handle not in self._known:
            if isinstance(self._end, DataReader):
                found = self._end.get_matched_publication_data(handle)
            else:
                found = self._end.get_matched_subscription_data(handle)
            if found is None:
                return None
            self._known[handle] = str(found.participant_key)
        return self._known[handle]

    def present(self) -> frozenset[Peer]:
        """Return those that are there now."""
        return frozenset(peer for handle in self._handles() if (peer := self.of(handle)) is not None)

    def _handles(self) -> list[int]:
        while True:
            try:
                if isinstance(self._end, DataReader):
                    return list(self._end.get_matched_publications())
                return list(self._end.get_matched_subscriptions())
            except IndexError:  # cyclonedds counts before it lists, and one more came in between
                continue


def is_fast_dds(peer: Peer) -> bool:
    """Return whether a process uses Fast DDS, by the vendor in its id."""
    return peer.replace("-", "").startswith(_FAST_DDS_VENDOR)


class FastDdsWatch:
    """Warns once if a node with Fast DDS has to do with a topic that does not work between it and Cyclone.

    Args:
        participant: of this process.
        log: takes the line.
    """

    def __init__(self, participant: DomainParticipant, log: Log) -> None:
        self._appeared = [
            BuiltinDataReader(participant, kind) for kind in (BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription)
        ]
        self._log = log
        self.topics: set[str] = set()
        """The topics of DDS that do not work."""

    def look(self) -> None:
        """Examine some of the readers and writers that have appeared."""
        found = [one for reader in self._appeared for one in reader.take(_AT_ONCE) if one.sample_info.valid_data]
        for one in found:
            if one.topic_name in self.topics and is_fast_dds(str(one.participant_key)):
                self._log(f"warning: {FAST_DDS.format(what=f'has to do with {ros_name(one.topic_name)}')}")
                self.close()
                return

    def close(self) -> None:
        """Examine no more."""
        self._appeared.clear()
