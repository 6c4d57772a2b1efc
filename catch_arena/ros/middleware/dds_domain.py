"""Which DDS domain this process is in, and where others of it are looked for: as ROS's variables say."""

import os
import socket
from collections.abc import Mapping
from typing import Final, NamedTuple

from cyclonedds.core import DDSException, Qos
from cyclonedds.domain import Domain, DomainParticipant

from catch_arena.errors import BusError
from catch_arena.ros.middleware.bus import LONGEST, Log

_DEFAULTS: Final = ("OFF", "SYSTEM_DEFAULT")
"""The discovery ranges that leave all to DDS: the second says so, and with the first nobody would find anybody."""
_SUBNET: Final = ("", "SUBNET")
_MOST_PROCESSES: Final = 120
"""On one host. Where there is no multicast, each that could be there is asked by its number."""
_THIS_MACHINE: Final = "127.0.0.1"
_LOOPBACK: Final = f'<NetworkInterface address="{_THIS_MACHINE}" multicast="false"/>'  # it has no multicast
_NETWORK: Final = '<NetworkInterface autodetermine="true"/>'
_IN_IT_ALREADY: Final = -4
"""DDS_RETCODE_PRECONDITION_NOT_MET, where a process configures a domain for the second time."""
_domains: Final[dict[int, Domain]] = {}
"""Of this process: a domain is configured once."""


class Discovery(NamedTuple):
    """Where others are looked for."""

    localhost: bool = False
    """On this machine only, besides the peers; else in the network too."""
    peers: tuple[str, ...] = ()
    """Hosts by their IPv4 addresses, some with a port."""
    is_default: bool = False
    """Whether all is left to DDS's own configuration."""


def discovery_of(environment: Mapping[str, str], log: Log) -> Discovery:
    """As ROS and rmw_cyclonedds_cpp read it.

    ROS_LOCALHOST_ONLY comes first, and leaves no peers. A ROS_AUTOMATIC_DISCOVERY_RANGE that is not known is LOCALHOST.
    A host of ROS_STATIC_PEERS that is not known is left out: cyclonedds would end the process.

    Args:
        environment: the variables.
        log: takes one line for each that is left out.
    """
    reach = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "")
    named = [word for part in environment.get("ROS_STATIC_PEERS", "").split(";") if (word := part.strip())]
    is_alone = environment.get("ROS_LOCALHOST_ONLY", "").startswith("1")
    if is_alone or reach in _DEFAULTS:
        if named:
            why = "ROS_LOCALHOST_ONLY=1" if is_alone else f"ROS_AUTOMATIC_DISCOVERY_RANGE={reach}"
            log(f"warning: ROS_STATIC_PEERS is ignored because of {why}, as in ROS")
        return Discovery(localhost=is_alone, is_default=not is_alone)
    peers = []
    for name in named:
        address = _address(name)
        if address is None:
            log(f"warning: ROS_STATIC_PEERS must name hosts, as 192.168.0.7;robot.local: {name[:80]!r} is left out")
        else:
            peers.append(address)
    return Discovery(localhost=reach not in _SUBNET, peers=tuple(peers))


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
        f"<CycloneDDS><Domain>{'' if discovery.is_default else _reach(discovery)}"
        f"<Internal><MaxSampleSize>{LONGEST} B</MaxSampleSize></Internal></Domain></CycloneDDS>,{own}"
    )


def _reach(discovery: Discovery) -> str:
    general, peers = "", discovery.peers
    if discovery.localhost:
        is_alone = all(peer.startswith("127.") for peer in peers)
        interfaces = _LOOPBACK if is_alone else _NETWORK + _LOOPBACK  # what comes by any other is not heard
        general = f"<General><Interfaces>{interfaces}</Interfaces><AllowMulticast>false</AllowMulticast></General>"
        peers = (_THIS_MACHINE, *peers)
    listed = "".join(f'<Peer address="{peer}"/>' for peer in peers)
    return (
        f"{general}<Discovery><ParticipantIndex>auto</ParticipantIndex>"
        f"<MaxAutoParticipantIndex>{_MOST_PROCESSES}</MaxAutoParticipantIndex>"
        f"{f'<Peers>{listed}</Peers>' if listed else ''}</Discovery>"
    )


def _advice(discovery: Discovery) -> str:
    if os.environ.get("CYCLONEDDS_URI"):
        return "is CYCLONEDDS_URI right? What cyclonedds says above is about it, or about a network interface"
    alone = "" if discovery.localhost else " ROS_LOCALHOST_ONLY=1 keeps to this machine"
    return f"is there a network interface?{alone}"


def code_of(error: DDSException) -> str:
    """What DDS calls it."""
    return str(DDSException.error_message_mapping.get(error.code, (f"code {error.code}", ""))[0])


def _address(peer: str) -> str | None:
    """Of a host, or of a host and its port; None where there is none."""
    host, colon, port = peer.partition(":")
    if colon and not (port.isascii() and port.isdecimal() and 0 < int(port[:6]) < 2**16):
        return None
    try:
        found = socket.getaddrinfo(host, None, socket.AF_INET)
    except (OSError, UnicodeError):
        return None
    return f"{found[0][4][0]}{colon}{port}"
