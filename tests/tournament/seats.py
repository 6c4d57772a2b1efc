"""Arenas by their number of hunters, for plans."""

from catch_arena.config import ArenaConfig
from catch_arena.tournament.parties import Parties


def hunters(count: int) -> Parties:
    """Return the parties of an arena without teams and prey."""
    return Parties.of(ArenaConfig(hunters=count))
