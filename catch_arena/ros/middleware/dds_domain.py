"""The DDS domain of this process and its discovery of other processes, by ROS's environment variables."""

import os
from collections.abc import Mapping
from typing import Final

from cyclonedds.core import DDSException, Qos
from cyclonedds.domain import Domain, DomainParticipant

from catch_arena.errors import BusError
from catch_arena.ros.middleware.bus import LONGEST

_INDEXED: Final = "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>120</MaxAutoParticipantIndex>"
"""Settings that allow discovery without multicast: each possible process of a host is asked by its number."""
_SUBNET: Final = f"<Discovery>{_INDEXED}</Discovery>"
_LOCALHOST: Final = (
    '<General><Interfaces><NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces>'
    f'<AllowMulticast>false</AllowMulticast></General><Discovery>{_INDEXED}<Peers><Peer address="127.0.0.1"/></Peers>'
    "</Discovery>"
)
_domains: Final[dict[int, Domain]] = {}
"""Domains that this process has configured; each can be configured only once."""


def join(domain: int, qos: Qos) -> DomainParticipant:
    """Return a participant of a domain.

    Raises:
        BusError: if there is no network interface to use, or if CYCLONEDDS_URI is wrong.
    """
    try:
        if domain not in _domains:
            _domains[domain] = Domain(domain, configuration(os.environ))
        return DomainParticipant(domain, qos=qos)
    except UnicodeEncodeError:
        raise BusError(
            "CYCLONEDDS_URI must be ASCII, because the package cyclonedds takes no other characters"
        ) from None
    except DDSException as error:
        advice = "is there a network interface?"
        if os.environ.get("CYCLONEDDS_URI"):
            advice = "is CYCLONEDDS_URI right? The lines of cyclonedds above are about it, or about a network interface"
        elif not is_localhost_only(os.environ):
            advice += " ROS_LOCALHOST_ONLY=1 limits ROS to this machine"
        raise BusError(f"DDS domain {domain} cannot be joined ({code_of(error)}): {advice}") from None


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
