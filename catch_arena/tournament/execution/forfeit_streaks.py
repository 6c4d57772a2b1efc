"""Exclusion of entrants: an agent that has forfeited the allowed number of matches in a row plays no further ones.

Forfeits are counted in the order of the plan, whatever order the matches were played in. They are checked at the end of
a block, so that all matches of a block have the same field.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from catch_arena.tournament.match import Block, PlayedMatch, players_of
from catch_arena.tournament.players import Fault

MAX_FORFEITS: Final = 10
"""Usual number of forfeits in a row that exclude an agent."""


class ForfeitStreaks:
    """Number of matches that each entrant has forfeited in a row, block by block.

    Args:
        most: number of forfeits in a row that exclude an entrant; 0 for no limit.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._forfeited: Counter[int] = Counter()
        self._finished: set[int] = set()
        self._excluded: dict[int, Fault] = {}

    def add(self, block: Iterable[PlayedMatch]) -> bool:
        """Count the forfeits of the next block of the plan.

        Returns:
            True if the block excludes an entrant.
        """
        before = len(self._excluded)
        for one in block:
            for index, forfeit in zip(one.match.seating, one.result.forfeits, strict=True):
                if forfeit is None:
                    self._forfeited[index] = 0
                    self._finished.add(index)
                    continue
                self._forfeited[index] += 1
                if self._forfeited[index] == self._most:
                    why = Fault("FORFEIT_OUT", f"it had forfeited {self._most} matches in a row")
                    self._excluded.setdefault(index, why)
        return len(self._excluded) > before

    @property
    def excluded(self) -> Mapping[int, Fault]:
        """All excluded entrants, by index, with the reason."""
        return self._excluded

    def excluded_from(self, block: Block) -> Mapping[int, Fault]:
        """Return the excluded entrants of a block, by index, with the reason, after the blocks that were added."""
        players = players_of(block)
        return {index: why for index, why in self._excluded.items() if index in players}

    def may_begin(self, block: Block, before: Sequence[Block]) -> bool:
        """Return whether to begin a block while the blocks in `before` are still played.

        An agent that finished its last match is expected to finish the next ones. For any other agent, no more matches
        are begun than it may forfeit: an agent that hangs costs time.
        """
        if not self._most:
            return True
        doubtful = {
            index
            for index in players_of(block)
            if index not in self._excluded and (self._forfeited[index] or index not in self._finished)
        }
        begun = Counter(index for other in before for match in other for index in match.seating if index in doubtful)
        return all(self._forfeited[index] + begun[index] < self._most for index in doubtful)
