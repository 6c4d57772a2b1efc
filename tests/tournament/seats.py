"""Parties of arenas by their number of hunters, and plans of given matches."""

from collections.abc import Iterable, Sequence
from itertools import groupby

from catch_arena.config import ArenaConfig
from catch_arena.tournament.match import Block, Match
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import Plan


def hunters(count: int) -> Parties:
    """Return the parties of an arena without teams and prey."""
    return Parties.of(ArenaConfig(hunters=count))


def listed(matches: Sequence[Match]) -> Plan:
    """Return the plan of these very matches, which stand by block."""
    return Plan({"format": "listed"}, len(matches), lambda: iter(blocks_of(matches)))


def blocks_of(matches: Iterable[Match]) -> list[Block]:
    """Return the matches by block, in the order of the plan."""
    return [tuple(block) for _, block in groupby(matches, key=lambda match: match.block)]
