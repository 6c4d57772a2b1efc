"""R12.7: Matches of one side in an arena with prey; the figures of a side use its own results only.

If a side has several parties in a match, they are compared in that match. If it has one party, matches of a block with
the same other side are joined to one match (`Parties.seatings`). In it, entrants that played the party in turn meet:
they had the same opponents, in the same places.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby
from typing import Any, Final

from catch_arena.policy import Side
from catch_arena.tournament.match import PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.ranks import ranks_of_sides

_BY_PARTY: Final = (
    "scores",
    "verdicts",
    "contests_won",
    "contests_lost",
    "lost_to_mates",
    "forfeits",
    "thinking",
)
"""Parts of a result that are tuples by party, and keep their values in the matches of one side."""


def on_side(played: Sequence[PlayedMatch], parties: Parties, side: Side) -> Sequence[PlayedMatch]:
    """Return the matches of one side; without prey they are unchanged.

    Args:
        played: matches in whole blocks.
        parties: the parties of the arena.
        side: the side.
    """
    if len(parties.sides) == 1:
        return played
    cut = parties.on(side)
    if len(parties.seats[cut]) > 1:
        return [_slice_parties(one, cut) for one in played]
    other = parties.on("prey" if side == "hunter" else "hunter")

    def opponents(one: PlayedMatch) -> tuple[int, tuple[int, ...]]:
        return one.match.block, one.match.seating[other]

    alike = groupby(sorted(played, key=lambda one: (*opponents(one), one.match.id)), key=opponents)
    return [_join([_slice_parties(one, cut) for one in matches], side) for _, matches in alike]


def _slice_parties(one: PlayedMatch, cut: slice) -> PlayedMatch:
    match, result = one.match, one.result
    return replace(
        one,
        match=replace(match, seating=match.seating[cut], agent_seeds=match.agent_seeds[cut]),
        result=replace(result, **{name: getattr(result, name)[cut] for name in (*_BY_PARTY, "ranks", "logs")}),
    )


def _join(matches: Sequence[PlayedMatch], side: Side) -> PlayedMatch:
    """Return one match that joins matches with one party each."""
    first, results = matches[0], [one.result for one in matches]
    joined: dict[str, Any] = {
        name: tuple(value for result in results for value in getattr(result, name)) for name in _BY_PARTY
    }
    lasted = [None if one is None else one.step for one in joined["forfeits"]]
    ranks = ranks_of_sides(joined["scores"], lasted, len(lasted) if side == "hunter" else 0)
    return replace(
        first,
        match=replace(first.match, seating=tuple(index for one in matches for index in one.match.seating)),
        result=replace(first.result, **joined, ranks=ranks, logs=()),
        replay=None,
    )
