"""Matches of an entrant that its page plays and whose replays stay: the worst, the best, and the newest ones."""

from collections.abc import Sequence
from typing import Final, NamedTuple

from catch_arena.classroom.moments import merit
from catch_arena.tournament.match import Forfeit, PlayedMatch
from catch_arena.tournament.parties import Parties

_NEWEST: Final = 3
"""Number of the newest matches of an entrant whose replays stay."""


class Part(NamedTuple):
    """Match of an entrant, and the party that it played."""

    one: PlayedMatch
    party: int

    @property
    def forfeit(self) -> Forfeit | None:
        """Failure of the party in the match; None if it did not fail."""
        return self.one.result.forfeits[self.party]


def best_and_worst(parts: Sequence[Part], parties: Parties) -> tuple[Part, Part] | None:
    """Return the matches in which an entrant was best and worst as a hunter; None if it played none.

    Matches in which it did not begin count only if there are no others.
    """
    hunted = [part for part in parts if part.party < parties.hunting]
    if not hunted:
        return None
    begun = [part for part in hunted if part.forfeit is None or part.forfeit.step] or hunted

    def merit_in(part: Part) -> tuple[bool, int]:
        return merit(part.one.result, part.party, parties.hunting)

    return max(begun, key=merit_in), min(begun, key=merit_in)


def matches_kept(parts: Sequence[Part], parties: Parties) -> set[str]:
    """Return the ids of the matches of an entrant whose replays stay."""
    return {part.one.match.id for part in (*(best_and_worst(parts, parties) or ()), *parts[-_NEWEST:])}
