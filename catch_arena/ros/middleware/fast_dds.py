"""Nodes with Fast DDS, ROS's default middleware: over cyclonedds their services and lists do not work."""

from typing import Final

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription
from cyclonedds.domain import DomainParticipant

from catch_arena.ros.middleware.bus import Log
from catch_arena.ros.middleware.dds_types import ros_name

FAST_DDS: Final = (
    "a node with Fast DDS, ROS's default middleware, {use}, and services of such nodes do not work over cyclonedds: "
    "start it with RMW_IMPLEMENTATION=rmw_cyclonedds_cpp, or use --bus rclpy or --bus rosbridge"
)
"""The warning about a node with Fast DDS, with the ways to use it."""
_VENDOR: Final = "010f"
"""Beginning of the process ids of Fast DDS; Cyclone's begin with 0110."""
_IN_ONE_SPIN: Final = 8
"""Number of readers, and of writers, examined in one spin, 0.1 ms each, so that hundreds do not hold up a tick."""


def is_fast_dds(process: str) -> bool:
    """Return whether a process uses Fast DDS, by the vendor in its id."""
    return process.replace("-", "").startswith(_VENDOR)


class FastDdsWatch:
    """Watch that warns once if a node with Fast DDS uses a topic that does not work between it and Cyclone.

    Args:
        participant: DDS participant of this process.
        log: takes the line.
    """

    def __init__(self, participant: DomainParticipant, log: Log) -> None:
        self._appeared = [
            BuiltinDataReader(participant, kind) for kind in (BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription)
        ]
        self._log = log
        self.topics: set[str] = set()
        """DDS topics that do not work between Fast DDS and Cyclone."""

    def look(self) -> None:
        """Examine some of the readers and writers that have appeared."""
        found = [one for reader in self._appeared for one in reader.take(_IN_ONE_SPIN) if one.sample_info.valid_data]
        for one in found:
            if one.topic_name in self.topics and is_fast_dds(str(one.participant_key)):
                self._log(f"warning: {FAST_DDS.format(use=f'uses {ros_name(one.topic_name)}')}")
                self.close()
                return

    def close(self) -> None:
        """Stop examining readers and writers."""
        self._appeared.clear()
