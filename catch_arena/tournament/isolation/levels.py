"""The two levels at which agents are held apart, and which of them this machine can hold."""

from catch_arena.errors import ConfigError
from catch_arena.tournament.isolation.control_groups import delegated_group
from catch_arena.tournament.isolation.limits import Level
from catch_arena.tournament.isolation.namespaces import namespaces_missing


def level_here(asked: Level | None = None) -> Level:
    """The level that agents are held at on this machine.

    Args:
        asked: what it must be; None for the best that there is.

    Raises:
        ConfigError: for a level that this machine cannot hold, in one line that says why.
    """
    if asked is not None and asked != "namespaces":
        return asked
    why = namespaces_missing()
    if why is None:
        return "namespaces"
    if asked is None:
        return "processes"
    raise ConfigError(f"isolation namespaces cannot be held here: {why}")


def level_line(level: Level) -> str:
    """What people are told of how agents are held apart, and of what bounds them."""
    line = f"isolation: {level}" if level == "namespaces" else f"isolation: {level}, see `catch-arena docs isolation`"
    return line if delegated_group() is None else f"{line}; control groups bound memory and processes"
