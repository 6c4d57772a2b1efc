"""Which DDS domain this process is in, and where others of it are looked for: as ROS's variables say."""

import os
from collections.abc import Mapping
from typing import Final, Literal

from cyclonedds.core import DDSException, Qos
from cyclonedds.domain import Domain, DomainParticipant

from catch_arena.errors import BusError
from catch_arena.ros.middleware.bus import LONGEST

_DEFAULTS: Final = ("OFF", "SYSTEM_DEFAULT")
"""The discovery ranges that leave all to DDS: the second says so, and with the first nobody would find anybody."""
_SUBNET: Final = ("", "SUBNET")
_MOST_PROCESSES: Final = 120
"""On one host. Where there is no multicast, each that could be there is asked by its number."""
_INDEXED: Final = (
    f"<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>{_MOST_PROCESSES}</MaxAutoParticipantIndex>"
)
_REACH: Final = {
    "default": "",
    "subnet": f"<Discovery>{_INDEXED}</Discovery>",
    "localhost": '<General><Interfaces><NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces>'
    f'<AllowMulticast>false</AllowMulticast></General><Discovery>{_INDEXED}<Peers><Peer address="127.0.0.1"/></Peers>'
    "</Discovery>",
}
_IN_IT_ALREADY: Final = -4
"""DDS_RETCODE_PRECONDITION_NOT_MET, where a process configures a domain for the second time."""
_domains: Final[dict[int, Domain]] = {}
"""Of this process: a domain is configured once."""


Discovery = Literal["localhost", "subnet", "default"]
"""Where others are looked for: on this machine, in the network, or as DDS's own configuration says."""


def discovery_of(environment: Mapping[str, str]) -> Discovery:
    """Read it from ROS's variables, as rmw_cyclonedds_cpp does.

    ROS_LOCALHOST_ONLY comes first. A ROS_AUTOMATIC_DISCOVERY_RANGE that is not known is LOCALHOST.
    """
    reach = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "")
    if environment.get("ROS_LOCALHOST_ONLY", "").startswith("1"):
        return "localhost"
    if reach in _DEFAULTS:
        return "default"
    return "subnet" if reach in _SUBNET else "localhost"


def join(domain: int, discovery: Discovery, qos: Qos) -> DomainParticipant:
    """A participant of a domain. Where this process is in it already, its first discovery holds.

    Raises:
        BusError: where there is no network interface to use, or where CYCLONEDDS_URI cannot be.
    """
    try:
        if domain not in _domains:
            try:
                _domains[domain] = Domain(domain, configuration(discovery, os.environ.get("CYCLONEDDS_URI", "")))
            except DDSException as error:
                if error.code != _IN_IT_ALREADY:
                    raise
        return DomainParticipant(domain, qos=qos)
    except UnicodeEncodeError:
        raise BusError("CYCLONEDDS_URI must be ASCII, which is all that the package cyclonedds takes") from None
    except DDSException as error:
        raise BusError(f"DDS domain {domain} cannot be joined ({code_of(error)}): {_advice(discovery)}") from None


def configuration(discovery: Discovery, own: str) -> str:
    """Cyclone's, as rmw_cyclonedds_cpp writes it.

    Args:
        discovery: where others are looked for.
        own: the user's, which comes after it and overrides it.
    """
    return (
        f"<CycloneDDS><Domain>{_REACH[discovery]}"
        f"<Internal><MaxSampleSize>{LONGEST} B</MaxSampleSize></Internal></Domain></CycloneDDS>,{own}"
    )


def _advice(discovery: Discovery) -> str:
    if os.environ.get("CYCLONEDDS_URI"):
        return "is CYCLONEDDS_URI right? What cyclonedds says above is about it, or about a network interface"
    alone = "" if discovery == "localhost" else " ROS_LOCALHOST_ONLY=1 keeps to this machine"
    return f"is there a network interface?{alone}"


def code_of(error: DDSException) -> str:
    """What DDS calls it."""
    return str(DDSException.error_message_mapping.get(error.code, (f"code {error.code}", ""))[0])
