"""Exclusion of entrants: an agent that has forfeited the allowed number of matches in a row plays no further ones.

Forfeits are counted in the order of the plan, whatever order the matches were played in. They are checked at the end of
a block, so that all matches of a block have the same field.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Final

from catch_arena.tournament.match import Block, Fault, PlayedMatch

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
        players = {index for match in block for index in match.seating}
        return {index: why for index, why in self._excluded.items() if index in players}
