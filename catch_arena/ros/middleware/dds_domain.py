"""The DDS domain of this process: discovery of others by ROS's environment variables, and nodes with Fast DDS in it.

Over cyclonedds, services and lists of nodes with Fast DDS, ROS's default middleware, do not work.
"""

import atexit
import os
from collections.abc import Collection, Generator, Mapping
from typing import Final

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription
from cyclonedds.core import DDSException, Qos
from cyclonedds.domain import Domain, DomainParticipant

from catch_arena.errors import BusError
from catch_arena.ros.middleware.bus import LONGEST, Log

_INDEXED: Final = "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>120</MaxAutoParticipantIndex>"
"""Settings that allow discovery without multicast: each possible process of a host is asked by its number."""
_SUBNET: Final = f"<Discovery>{_INDEXED}</Discovery>"
_LOCALHOST: Final = (
    '<General><Interfaces><NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces>'
    f'<AllowMulticast>false</AllowMulticast></General><Discovery>{_INDEXED}<Peers><Peer address="127.0.0.1"/></Peers>'
    "</Discovery>"
)
FAST_DDS: Final = (
    "a node with Fast DDS, ROS's default middleware, {use}, and services of such nodes do not work over cyclonedds: "
    "start it with RMW_IMPLEMENTATION=rmw_cyclonedds_cpp, or use --bus rclpy or --bus rosbridge"
)
"""The warning about a node with Fast DDS, with the ways to use it."""
_IN_ONE_SPIN: Final = 8
"""Number of readers, and of writers, examined in one spin, 0.1 ms each, so that hundreds do not hold up a tick."""
_domains: Final[dict[int, Domain]] = {}
"""Domains that this process has configured; each can be configured only once."""
atexit.register(_domains.clear)  # later, Cyclone's threads could not take Python's lock, and the exit would hang


def join(domain: int, qos: Qos) -> DomainParticipant:
    """Return a participant of a domain."""
    try:
        if domain not in _domains:
            _domains[domain] = Domain(domain, configuration(os.environ))
        return DomainParticipant(domain, qos=qos)
    except (DDSException, UnicodeEncodeError) as error:  # the package takes a configuration in ASCII
        cause = code_of(error) if isinstance(error, DDSException) else "its configuration is not ASCII"
        raise BusError(
            f"DDS domain {domain} cannot be joined ({cause}): is there a network interface, and is CYCLONEDDS_URI "
            "right, if it is set? ROS_LOCALHOST_ONLY=1 limits ROS to this machine"
        ) from None


def is_localhost_only(environment: Mapping[str, str]) -> bool:
    """Return whether ROS's environment variables limit discovery to this machine; ROS_LOCALHOST_ONLY comes first."""
    if environment.get("ROS_LOCALHOST_ONLY", "").startswith("1"):
        return True
    return environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "").upper() == "LOCALHOST"


def configuration(environment: Mapping[str, str]) -> str:
    """Return Cyclone's configuration, as rmw_cyclonedds_cpp writes it; CYCLONEDDS_URI comes last and overrides it."""
    return (
        f"<CycloneDDS><Domain>{_LOCALHOST if is_localhost_only(environment) else _SUBNET}"
        f"<Internal><MaxSampleSize>{LONGEST} B</MaxSampleSize></Internal></Domain></CycloneDDS>,"
        f"{environment.get('CYCLONEDDS_URI', '')}"
    )


def code_of(error: DDSException) -> str:
    """Return DDS's name of an error."""
    return str(DDSException.error_message_mapping.get(error.code, (f"code {error.code}", ""))[0])


def ros_name(topic: str) -> str:
    """Return ROS's name of a DDS topic."""
    return topic[2:].removesuffix("Request" if topic.startswith("rq") else "Reply" if topic.startswith("rr") else "")


def is_fast_dds(process: str) -> bool:
    """Return whether a process uses Fast DDS, by the vendor that its id begins with; Cyclone's begin with 0110."""
    return process.replace("-", "").startswith("010f")


def fast_dds_watch(participant: DomainParticipant, topics: Collection[str], log: Log) -> Generator[None, None, None]:
    """Examine some of the readers and writers that have appeared, again for each `next`; end with the first warning.

    It is about a node with Fast DDS that uses one of these DDS topics, to which more may be added.
    """
    readers = [
        BuiltinDataReader(participant, kind) for kind in (BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription)
    ]
    while True:
        for one in (one for reader in readers for one in reader.take(_IN_ONE_SPIN) if one.sample_info.valid_data):
            if one.topic_name in topics and is_fast_dds(str(one.participant_key)):
                log(f"warning: {FAST_DDS.format(use=f'uses {ros_name(one.topic_name)}')}")
                return
        yield
