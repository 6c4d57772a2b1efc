"""R12.7: Matches of one side in an arena with prey; the figures of a side use its own results only.

If a side has several parties in a match, they are compared in that match. If it has one party, matches of a block with
the same other side are joined to one match (`Parties.seatings`). In it, entrants that played the party in turn meet:
they had the same opponents, in the same places.
"""

from collections.abc import Sequence
from typing import NamedTuple

from catch_arena.policy import Side
from catch_arena.tournament.match import Forfeit, PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.ranks import ranks_of_sides


class SideMatch(NamedTuple):
    """Match of the parties of one side, or several matches that are joined to one."""

    block: int
    seating: tuple[int, ...]
    """Player of each party, as an index among the entrants."""
    scores: tuple[int, ...]
    ranks: tuple[int, ...]
    forfeits: tuple[Forfeit | None, ...]


def on_side(played: Sequence[PlayedMatch], parties: Parties | None = None, side: Side = "hunter") -> list[SideMatch]:
    """Return the matches of one side in the order of the plan.

    Args:
        played: matches in whole blocks.
        parties: the parties of the arena; None if all parties of a match are compared.
        side: the side.
    """
    in_order = sorted(played, key=lambda one: one.match)
    cut = slice(None) if parties is None else parties.on(side)
    matches = [
        SideMatch(
            one.match.block,
            one.match.seating[cut],
            one.result.scores[cut],
            one.result.ranks[cut],
            one.result.forfeits[cut],
        )
        for one in in_order
    ]
    if parties is None or len(parties.sides) == 1 or len(parties.seats[cut]) > 1:
        return matches
    other = parties.on("prey" if side == "hunter" else "hunter")
    alike: dict[tuple[int, tuple[int, ...]], list[SideMatch]] = {}
    for one, match in zip(in_order, matches, strict=True):
        alike.setdefault((match.block, one.match.seating[other]), []).append(match)
    return [_join(found, side) for found in alike.values()]


def _join(matches: Sequence[SideMatch], side: Side) -> SideMatch:
    """Return one match that joins matches with one party each."""
    scores = tuple(one.scores[0] for one in matches)
    forfeits = tuple(one.forfeits[0] for one in matches)
    lasted = [None if one is None else one.step for one in forfeits]
    ranks = ranks_of_sides(scores, lasted, len(scores) if side == "hunter" else 0)
    return SideMatch(matches[0].block, tuple(one.seating[0] for one in matches), scores, ranks, forfeits)
