"""Plan that goes on until the order of all entrants is clear, or its budget is spent."""

from collections.abc import Callable, Iterable, Sequence
from itertools import islice
from typing import Final

from catch_arena.errors import ConfigError
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import Block, PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import Plan
from catch_arena.tournament.statistics.outcomes import SideResults
from catch_arena.tournament.statistics.separation import Separation, next_look, separation

BUDGET: Final = 10_000
"""Default budget of a plan [matches]."""


class UntilSeparated(Plan):
    """Plan of whole rounds of a format, which ends after the first stage whose standings have a clear order.

    The budget is not one of the plan's parameters: a resumed tournament may raise it.

    Args:
        rounds: function that makes the format's plan with a given number of rounds.
        budget: largest number of matches.
        parties: the parties of the arena; with prey the order of each side must be clear.

    Raises:
        ConfigError: for a confidence outside [0.5, 1), or a budget smaller than the matches of one round.
    """

    def __init__(
        self,
        entrants: Sequence[Entrant],
        confidence: float,
        budget: int,
        rounds: Callable[[int], Plan],
        parties: Parties,
    ) -> None:
        if not 0.5 <= confidence < 1:
            raise ConfigError(f"confidence must lie in [0.5, 1), such as 0.95, got {confidence}")
        one = rounds(1)
        if budget < one.size:
            raise ConfigError(f"max_matches must be at least {one.size}, the matches of one round, got {budget}")
        whole = rounds(budget // one.size)
        kept = {name: value for name, value in one.parameters.items() if name != "rounds"}
        super().__init__({**kept, "until_separated": confidence}, whole.size, whole.blocks)
        self._round = one.size // parties.block_size
        self._entrants, self._parties = entrants, parties
        # with two orders, each gets half of the allowed error
        self._confidence = confidence if len(parties.sides) == 1 else (1.0 + confidence) / 2.0
        self.last: Separation | None = None
        """Result of the last look at the standings; None before the first one."""

    def stage(self, number: int, played: Iterable[PlayedMatch]) -> Iterable[Block]:
        """Return the blocks of the rounds until the next look; none if the order is clear."""
        del number
        matches = list(played)
        blocks = len({one.match.block for one in matches})
        if matches:
            sides = (SideResults.of(self._entrants, matches, self._parties, side) for side in self._parties.sides)
            looks = [separation(side, self._confidence) for side in sides]
            self.last = max(looks, key=lambda look: (not look.clear, look.p))
            if self.last.clear:
                return ()
        rounds_then = -(-next_look(blocks) // self._round)
        return islice(self.blocks(), blocks, rounds_then * self._round)
