"""Choice of a back-end, and joining the bus by it."""

import os
import sys
from collections.abc import Mapping
from importlib import import_module
from typing import Final

from catch_arena.errors import BusError, ConfigError, install_hint
from catch_arena.ros.middleware.bus import BACKENDS, Backend, Bus, Log
from catch_arena.ros.middleware.interfaces import Interfaces
from catch_arena.text import one_line

BRIDGE_URL: Final = "ws://127.0.0.1:9090"
"""Usual address of rosbridge's server."""
_HIGHEST_DOMAIN: Final = 232
"""The highest DDS domain id; the ports of higher ones do not exist."""
_MODULES: Final[Mapping[Backend, str]] = {"cyclonedds": "cyclonedds", "rosbridge": "websockets", "rclpy": "rclpy.node"}
_INSTALL: Final = install_hint("ros")


def open_bus(bus: str | None = None, *, node: str = "catch_arena", log: Log = print) -> Bus:
    """Join a ROS 2 bus, over DDS in the domain ROS_DOMAIN_ID, or 0; over rclpy with a node of this name.

    `bus` is a back-end, or the address of a rosbridge server, which is BRIDGE_URL for "rosbridge". None takes the first
    of BACKENDS that works here.
    """
    domain = _domain()
    url = bus if bus is not None and bus.startswith(("ws://", "wss://")) else None
    named = "rosbridge" if url is not None else bus
    backend = next((one for one in BACKENDS if one == named), None)
    if bus is None:
        backend = _first_that_works(log)
    elif backend is None:
        raise ConfigError(f"--bus must be {', '.join(BACKENDS)}, or an address such as {BRIDGE_URL}, got {bus!r}")
    elif _import_fault(backend):
        raise BusError(_missing(backend))
    if backend == "cyclonedds":
        from catch_arena.ros.middleware.dds_bus import DdsBus

        return DdsBus(domain, log=log)
    if backend == "rosbridge":
        from catch_arena.ros.middleware.rosbridge_bus import RosbridgeBus

        return RosbridgeBus(url or BRIDGE_URL, log=log)
    from catch_arena.ros.middleware.rclpy_bus import RclpyBus

    return RclpyBus(node, domain)


def describe_bus(bus: Bus, interfaces: Interfaces) -> str:
    """Return one line on how nodes reach this bus, and with which types."""
    where = "" if bus.backend == "rosbridge" else f", domain {_domain()}"
    middleware = f", {bus.middleware}" if bus.middleware else ""
    python = f"Python {sys.version_info.major}.{sys.version_info.minor}"
    return f"bus: {bus.backend}{where}{middleware}, {python}, interfaces of {interfaces.package}"


def _domain() -> int:
    """Return the DDS domain; a rosbridge server has its own."""
    word = os.environ.get("ROS_DOMAIN_ID", "").strip() or "0"
    if not (word.isascii() and word.isdecimal()) or int(word) > _HIGHEST_DOMAIN:
        raise ConfigError(f"ROS_DOMAIN_ID must be a whole number from 0 to {_HIGHEST_DOMAIN}, got {word}")
    return int(word)


def _first_that_works(log: Log) -> Backend:
    faults = {}
    for backend in BACKENDS:
        if not (fault := _import_fault(backend)):
            break
        faults[backend] = fault
    else:
        raise BusError(f"a ROS 2 bus needs rclpy, cyclonedds or websockets: {_INSTALL}")
    if backend != "rclpy" and "ROS_DISTRO" in os.environ:
        log(
            f"warning: ROS is sourced, but rclpy cannot be imported ({faults['rclpy']}), so {backend} is used: "
            "make the virtual environment with ROS's own Python: python3 -m venv --system-site-packages"
        )
    return backend


def _import_fault(backend: Backend) -> str:
    """Return why a back-end cannot be imported; empty if it can. rclpy may be there and not be sourced."""
    try:
        import_module(_MODULES[backend])
    except ImportError as error:
        return one_line(str(error))
    return ""


def _missing(backend: Backend) -> str:
    if backend == "rclpy":
        return "rclpy cannot be imported: source ROS first (source /opt/ros/jazzy/setup.bash), and use ROS's own Python"
    where = "" if backend == "rosbridge" else " (no wheels for Linux on ARM: use --bus rosbridge)"
    return f"{backend} needs {_MODULES[backend]}, which is not installed: {_INSTALL}{where}"
