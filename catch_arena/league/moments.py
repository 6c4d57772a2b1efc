"""Matches of an entrant that its page plays and whose replays stay: the worst, the best, and the newest ones."""

from collections.abc import Sequence
from typing import Final, NamedTuple

from catch_arena.classroom.moments import Moment, merit, moment_of
from catch_arena.explanation import explain
from catch_arena.replay import Replay
from catch_arena.tournament.match import Forfeit, MatchResult, PlayedMatch
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


def best_moment(replay: Replay, party: int, result: MatchResult) -> Moment | None:
    """Return the contest of a match that a party won by least, or its last catch, or the start; None if it failed.

    Raises:
        ReplayError: if the match does not play as recorded.
    """
    if result.forfeits[party] is not None:
        return None
    seat = Parties.of(replay.config).seats[party][0]
    match = explain(replay, seat)
    won = [contest for contest in match.contests if contest.claims[0].seat == seat and not contest.claims[1].mate]
    caught = [catch for catch in match.catches if catch.seat == seat]
    if won:
        closest = min(won, key=lambda contest: contest.margin_um or 0)
        return moment_of(replay, seat, closest.judged_ms, match.sentence(closest))
    if caught:
        return moment_of(
            replay, seat, caught[-1].judged_ms, f"Catch {len(caught)} of {len(caught)}, without a contest."
        )
    return moment_of(replay, seat, 0, "The start of the match; it catches nothing.")
