"""How agents that are not trusted run: at which of two levels they are held apart, and with which limits."""

from dataclasses import dataclass, field
from typing import Literal, get_args

from catch_arena.config import require_choice
from catch_arena.errors import ConfigError
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.namespaces import namespaces_missing

Level = Literal["namespaces", "processes"]
"""Namespaces of its own for each agent, or only processes (docs/isolation.md)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Isolation:
    """How agents that are not trusted run; it can be sent to another process, and to another machine."""

    limits: AgentLimits = field(default_factory=AgentLimits)
    level: Level | None = None
    """At least this; None for the best that works."""
    entrants: tuple[str, ...] = ()
    """The specs of all who play: no agent sees the files of another."""
    hidden: tuple[str, ...] = ()
    """Whole paths of files and folders that no agent sees."""


def level_here(asked: Level | None = None) -> Level:
    """The level that agents are held at on this machine.

    Args:
        asked: what it must be; None for the best that works.

    Raises:
        ConfigError: for a level that this machine cannot hold, in one line that says why.
    """
    if asked is None:
        return "processes" if namespaces_missing() else "namespaces"
    require_choice("isolation", asked, get_args(Level))
    if asked == "namespaces" and (why := namespaces_missing()):
        raise ConfigError(f"isolation namespaces cannot be held here: {why}")
    return asked
