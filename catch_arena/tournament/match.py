"""One match, as a plan has it, and what came of it."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from msgspec import Struct

from catch_arena.tournament.players import ForfeitCode, Observation

MOST_TIMEOUTS: Final = 2
"""After so many of an agent, grade and check-agent know enough: each costs seconds."""


@dataclass(frozen=True, slots=True, order=True)
class Match:
    """One match of a plan."""

    id: str
    """The same for the same plan, whenever it is made; ids sort in the order of the plan."""
    block: int
    """Its block, from 0: matches of one block share their seed, and so their targets (R3.3)."""
    seed: int = field(repr=False)
    """The arena's. Like `agent_seeds` no message shows it: other matches of its block may not have been played yet."""
    seating: tuple[int, ...]
    """By party (parties.py): the index of its player among the entrants."""
    agent_seeds: tuple[int, ...] = field(default=(), repr=False)
    """By party: what its player is told as its seed; where there are none they follow from the match's own."""

    def with_players(self, players: Sequence[int]) -> "Match":
        """The same match, where the numbers of its seating were roles: player `players[0]` in place of 0, and so on."""
        return replace(self, seating=tuple(players[role] for role in self.seating))


Block = tuple[Match, ...]
"""One seed, played in every rotation of its players through the parties (docs/tournaments.md)."""


class MoveTimes(Struct, frozen=True, array_like=True):
    """How long one party took over its moves, by the clock on the wall; all its seats together."""

    moves: int
    """How often it was asked, the step that it failed in among them."""
    total_s: float
    longest_s: float


class Forfeit(Struct, frozen=True, array_like=True):
    """How one party failed: that of one of its seats is that of all (R11.1)."""

    code: ForfeitCode
    step: int
    """The step that it gave no action for, from 1; 0 where it could not begin."""
    reason: str
    """One line for people, as `text.one_line` makes it."""
    observation: Observation | None = None
    """What it was shown in that step; a store does not keep it."""
    seat: int = -1
    """Which of its seats failed, likewise."""

    late: bool = False
    """True if it was too slow, which may be FORFEIT_INIT as well; a store does not keep it."""

    def __str__(self) -> str:
        """For people."""
        return f"{self.code} {f'in step {self.step}' if self.step else 'before the first step'}: {self.reason}"


@dataclass(frozen=True, slots=True)
class MatchResult:
    """What came out of one match; tuples are by party (parties.py), the hunting ones first."""

    scores: tuple[int, ...]
    """R11.1, R12.5: a team's catches; of prey, how often it was caught."""
    ranks: tuple[int, ...]
    """R6.1, R12.5: 1 is best, on either side by itself; equal scores share a rank, and the ranks that they use up are
    left out (1, 1, 3). Those who forfeited come last, whatever their scores: of hunters, the longer one lasted, the
    better; of prey, the less often it was caught.
    """
    verdicts: tuple[dict[str, int], ...]
    """How many of its requests met each verdict, by its name; verdicts that it never met are left out."""
    contests_won: tuple[int, ...]
    """How many contests it won (R5.4): targets, killed or not, that others in reach requested in the same step. Here
    and in `contests_lost` one is counted once for a team, and not at all where only team-mates took part.
    """
    contests_lost: tuple[int, ...]
    steps: int
    digest: str
    """The final state's (A.8): matches that agree in it ended alike."""
    forfeits: tuple[str | None, ...]
    """One of players.ForfeitCode where it failed, as FORFEIT_CRASH."""
    thinking: tuple[MoveTimes, ...] = field(compare=False)
    """Like `details` and `logs`, no part of what another run of the match repeats. Stores and exports have this name.
    """
    details: tuple[Forfeit | None, ...] = field(default=(), compare=False)
    """More about each of `forfeits`."""
    logs: tuple[str, ...] = field(default=(), compare=False)
    """What isolated agents printed, tracebacks included, as far as it is kept; control characters are escapes in it.
    A store does not hold it.
    """
    lost_to_mates: tuple[int, ...] = ()
    """How many of its requests lost to a team-mate (R11.3). It is left out where no team has several hunters; another
    run repeats it.
    """
    catches: tuple[int, ...] = ()
    """By seat: each hunter's catches, then how often each prey was caught. It is left out likewise, as `scores` says
    it; another run repeats it.
    """


@dataclass(frozen=True, slots=True)
class PlayedMatch:
    """A match of the plan, and what came out of it."""

    match: Match
    result: MatchResult
    replay: str | None = None
    """The digest of its replay's file, where one was kept."""


def players_of(block: Block) -> frozenset[int]:
    """Who plays in any of its matches, by index among the entrants."""
    return frozenset(index for match in block for index in match.seating)
