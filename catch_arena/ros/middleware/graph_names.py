"""Names of the topics and services of a match: the exercise's, turtlesim's, and our own; checks of given names."""

import re
from typing import Final

from catch_arena.errors import ConfigError
from catch_arena.text import shortened

_SERVICE: Final = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")
_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")

TURTLE: Final = "turtle1"
"""The one hunter of the exercise, and turtlesim's first turtle."""

ALIVE_TURTLES: Final = "/alive_turtles"
RULINGS: Final = "/rulings"
STANDINGS: Final = "/standings"
CLOCK: Final = "/clock"

CATCH_TURTLE: Final = "/catch_turtle"
"""Catch service that all hunters share; each hunter may also have its own."""
SPAWN: Final = "/spawn"
KILL: Final = "/kill"
CLEAR: Final = "/clear"
RESET: Final = "/reset"

POSE: Final = "/pose"
"""Ending of a pose's topic, after the turtle's name."""


def pose_of(turtle: str) -> str:
    """Return the topic of a turtle's pose."""
    return f"/{turtle}{POSE}"


def cmd_vel_of(turtle: str) -> str:
    """Return the topic that drives a turtle."""
    return f"/{turtle}/cmd_vel"


def set_pen_of(turtle: str) -> str:
    """Return the service that sets the colour of a turtle's trail."""
    return f"/{turtle}/set_pen"


def catch_turtle_of(turtle: str) -> str:
    """Return a hunter's own catch service."""
    return f"/{turtle}{CATCH_TURTLE}"


def checked_name(setting: str, name: str, example: str) -> str:
    """Return a valid name of a turtle or a package, or its beginning; an invalid name of a turtle ends turtlesim."""
    if not _NAME.fullmatch(name):
        raise ConfigError(
            f"{setting} must be letters, digits and underscores, such as {example}, got {shortened(name)}"
        )
    return name


def checked_service(setting: str, given: str, prefix: str = "") -> str:
    """Return a valid name of a service, which is given after a prefix."""
    name = given.removeprefix(prefix)
    if not _SERVICE.fullmatch(name):
        raise ConfigError(
            f"{setting} must be given as {prefix}/NAME, such as {prefix}{CATCH_TURTLE}, got {shortened(given)}"
        )
    return name
