"""What the topics and services of a match are called on the bus: the exercise's names, turtlesim's, and our own."""

from typing import Final

TURTLE: Final = "turtle1"
"""The one hunter of the exercise, and turtlesim's first turtle."""

ALIVE_TURTLES: Final = "/alive_turtles"
RULINGS: Final = "/rulings"
STANDINGS: Final = "/standings"
CLOCK: Final = "/clock"

CATCH_TURTLE: Final = "/catch_turtle"
"""Shared by all hunters; each may have one of its own too."""
SPAWN: Final = "/spawn"
KILL: Final = "/kill"
CLEAR: Final = "/clear"
RESET: Final = "/reset"

POSE: Final = "/pose"
"""Behind a turtle's name."""


def pose_of(turtle: str) -> str:
    """The topic on which a turtle's pose is told."""
    return f"/{turtle}{POSE}"


def cmd_vel_of(turtle: str) -> str:
    """The topic that drives it."""
    return f"/{turtle}/cmd_vel"


def catch_turtle_of(turtle: str) -> str:
    """The service of its own."""
    return f"/{turtle}{CATCH_TURTLE}"
