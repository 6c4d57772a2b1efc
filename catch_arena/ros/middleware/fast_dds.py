"""Nodes with Fast DDS, ROS's default middleware: over cyclonedds their services and lists do not work."""

from typing import Final

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription
from cyclonedds.domain import DomainParticipant

from catch_arena.ros.middleware.bus import Log
from catch_arena.ros.middleware.dds_types import ros_name

FAST_DDS: Final = (
    "a node with Fast DDS, ROS's default middleware, {what}, and its services cannot be spoken to over cyclonedds: "
    "start it with RMW_IMPLEMENTATION=rmw_cyclonedds_cpp, or give --bus rclpy or --bus rosbridge"
)
"""The one line, with its ways out."""
_VENDOR: Final = "010f"
"""Ids of Fast DDS begin with it; Cyclone's begin with 0110."""
_IN_ONE_SPIN: Final = 8
"""Readers and writers that are examined in one spin, each for 0.1 ms, so that hundreds do not hold up a tick."""


def is_fast_dds(process: str) -> bool:
    """Return whether a process uses Fast DDS, by the vendor in its id."""
    return process.replace("-", "").startswith(_VENDOR)


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
        found = [one for reader in self._appeared for one in reader.take(_IN_ONE_SPIN) if one.sample_info.valid_data]
        for one in found:
            if one.topic_name in self.topics and is_fast_dds(str(one.participant_key)):
                self._log(f"warning: {FAST_DDS.format(what=f'has to do with {ros_name(one.topic_name)}')}")
                self.close()
                return

    def close(self) -> None:
        """Examine no more."""
        self._appeared.clear()
