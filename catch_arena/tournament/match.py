"""Matches of a plan, the answers of their players, and their results."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Literal

from msgspec import Struct

MAX_FORFEITS: Final = 10
"""Usual number of forfeits in a row that exclude an agent."""
MOST_TIMEOUTS: Final = 2
"""Number of timeouts of an agent after which grade and check-agent stop: each costs seconds."""


@dataclass(frozen=True, slots=True, order=True)
class Match:
    """Match of a plan."""

    id: str
    """Id, which follows from the plan alone; ids sort in the order of the plan."""
    block: int
    """Block of the match, from 0: matches of one block share their seed, and so their targets (R3.3)."""
    seed: int = field(repr=False)
    """Seed of the arena. No message shows it or `agent_seeds`: other matches of the block may not be played yet."""
    seating: tuple[int, ...]
    """Index of the player among the entrants, by party (parties.py)."""
    agent_seeds: tuple[int, ...] = field(default=(), repr=False)
    """Seed of the player, by party."""

    def title(self, block_size: int) -> str:
        """Return the text that names the match for people, such as "round 1, match 5"."""
        turn, group, place = (int(part[1:]) for part in self.id.split("-")[:3])  # r00001-g000002-s03: g counts blocks
        return f"round {turn}, match {(group - 1) * block_size + place + 1}"


Block = tuple[Match, ...]
"""Matches with one seed, in every rotation of their players through the parties (docs/howto/tournaments.md)."""


ForfeitCode = Literal["FORFEIT_CRASH", "FORFEIT_TIMEOUT", "FORFEIT_ILLEGAL", "FORFEIT_INIT", "FORFEIT_OUT"]
"""Kinds of failure, in this order: the agent raises or dies; it takes too long; its answer is no legal action; it
cannot begin; it has failed in too many matches in a row, and is not started any more.
"""


@dataclass(frozen=True, slots=True)
class Fault:
    """Reason for which a seat cannot go on."""

    code: ForfeitCode
    reason: str
    late: bool = False
    """True if the seat was too slow."""


# plain tuples: a trusted match makes thousands of them
Observation = tuple[list[float], list[int]]
"""Observation of a seat in a step: the vector of R7.1 or R12.4, and the mask of R7.2; empty if the seat has none."""
Move = tuple[Any, float, Fault | None]
"""Answer of a seat: action, unchecked (None if there is a fault); time taken [s]; fault (None if there is none)."""


class MoveTimes(Struct, frozen=True, array_like=True):
    """Wall-clock times of one party's moves [s], for all its seats together."""

    moves: int
    """Number of requests for an action, the failed one included."""
    total_s: float
    longest_s: float

    @classmethod
    def of_all(cls, times: "Sequence[MoveTimes]") -> "MoveTimes":
        """Return the times of all these moves together."""
        longest_s = max((one.longest_s for one in times), default=0.0)
        return cls(sum(one.moves for one in times), sum(one.total_s for one in times), longest_s)

    @property
    def mean_ms(self) -> float:
        """Mean time of a move [ms]; NaN without moves."""
        return 1000.0 * self.total_s / self.moves if self.moves else math.nan


class Forfeit(Struct, frozen=True, array_like=True, eq=False):
    """Failure of one party: a failure in one of its seats counts for all (R11.1).

    Forfeits with one code and step are equal, because another run of the match may give another reason.
    """

    code: ForfeitCode
    step: int
    """Step without an action, from 1; 0 if the party could not begin."""
    reason: str
    """Reason in one line, as `text.one_line` makes it."""
    observation: Observation | None = None
    """Observation in that step; None if there was none. A store does not keep it."""
    seat: int = -1
    """Seat that failed; -1 if unknown."""

    late: bool = False
    """True if the party was too slow, also with the code FORFEIT_INIT."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Forfeit) and (self.code, self.step) == (other.code, other.step)

    def __hash__(self) -> int:
        return hash((self.code, self.step))

    def __str__(self) -> str:
        """Return the code, the step and the reason in one line."""
        return f"{self.code} {f'in step {self.step}' if self.step else 'before the first step'}: {self.reason}"


@dataclass(frozen=True, slots=True)
class MatchResult:
    """Result of one match; tuples are by party (parties.py), the hunting parties first."""

    scores: tuple[int, ...]
    """R11.1, R12.5: Catches of a team; for prey, the number of times that it was caught."""
    ranks: tuple[int, ...]
    """R6.1, R12.5: Rank on its side, 1 is best. Equal scores share a rank, and the next ranks are left out (1, 1, 3).
    Parties that forfeited come last, whatever their scores: hunters in the order of their last steps, the latest first;
    prey by the number of times that it was caught, the smallest first.
    """
    verdicts: tuple[dict[str, int], ...]
    """Number of requests with each verdict, by the verdict's name; verdicts with 0 are left out."""
    contests_won: tuple[int, ...]
    """Number of contests won (R5.4): targets, killed or not, that others in reach requested in the same step. Here and
    in `contests_lost`, a contest counts once for a team, and not at all if only team-mates took part.
    """
    contests_lost: tuple[int, ...]
    steps: int
    digest: str
    """Digest of the final state (A.8): matches with equal digests ended in the same state."""
    forfeits: tuple[Forfeit | None, ...]
    """Failure of each party; None if it did not fail."""
    thinking: tuple[MoveTimes, ...] = field(compare=False)
    """Times of moves; another run of the match does not repeat them, nor `logs`. Stores and exports use this name."""
    logs: tuple[str, ...] = field(default=(), compare=False)
    """Output of isolated agents up to a limit, with control characters as escapes. A store does not keep it."""
    lost_to_mates: tuple[int, ...] = ()
    """Number of requests lost to a team-mate (R11.3); empty if no team has several hunters. Another run repeats it."""
    catches: tuple[int, ...] = ()
    """Catches of each hunter, then the number of times that each prey was caught, by seat. Empty if no team has several
    hunters, as `scores` has the same numbers; another run repeats it.
    """

    @property
    def forfeit_codes(self) -> tuple[ForfeitCode | None, ...]:
        """Code of each party's failure; None if it did not fail."""
        return tuple(None if one is None else one.code for one in self.forfeits)

    def win_share(self, party: int, side: slice) -> float:
        """Return the share of the win on its side: 1 for a win, less if parties share the first rank, 0 for others.

        A party that forfeited does not win, even if all others forfeited too.
        """
        won = self.ranks[party] == 1 and self.forfeits[party] is None
        return won / self.ranks[side].count(1)


@dataclass(frozen=True, slots=True)
class PlayedMatch:
    """Match of the plan, and its result."""

    match: Match
    result: MatchResult
    replay: str | None = None
    """Digest of the replay's file; None if no replay was kept."""


def ranks_of_sides(scores: Sequence[int], lasted: Sequence[int | None], hunting: int) -> tuple[int, ...]:
    """Return the ranks by party, separately for each side: of `hunting` teams by R11.1, then of prey.

    R12.5: The prey that was caught least comes first; withdrawn prey comes after all other. `scores` are the catches of
    each team, then the number of times that each prey was caught; `lasted` are the steps of forfeits, as in `ranks_of`.
    """
    prey = [(end is not None, caught) for caught, end in zip(scores[hunting:], lasted[hunting:], strict=True)]
    ranks = ranks_of(scores[:hunting], lasted[:hunting])
    return *ranks, *(1 + sum(other < one for other in prey) for one in prey)


def ranks_of(scores: Sequence[int], lasted: Sequence[int | None] | None = None) -> tuple[int, ...]:
    """R6.1, R11.1: Return the ranks: 1 + the number of hunters or teams that did better.

    `lasted` is the step at which each forfeited; None for no forfeit, which is better than any forfeit.
    """
    merits = [
        (math.inf, score) if end is None else (end, 0)
        for score, end in zip(scores, lasted or [None] * len(scores), strict=True)
    ]
    return tuple(1 + sum(other > merit for other in merits) for merit in merits)
