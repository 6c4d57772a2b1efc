"""Names of the topics and services of a match: the exercise's, turtlesim's, and our own."""

from typing import Final

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
