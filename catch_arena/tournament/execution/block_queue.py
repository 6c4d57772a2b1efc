"""Queue of blocks that are played in parallel and kept in the order of the plan, with the results of serial play.

Only this module plays a match of a tournament again: if it failed on our side, or if one of its entrants was excluded
after its start.
"""

import time
from collections import Counter, deque
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from typing import Final

from catch_arena.errors import MatchFailedError
from catch_arena.tournament.execution.executors import Executor, RecordedMatch
from catch_arena.tournament.match import Block, Fault, PlayedMatch

MOST_TRIES: Final = 3
"""Number of tries of a block, or of the grading of a submission, that fails on our side."""
_MOST_HELD: Final = 256
"""Largest number of played blocks that wait in memory for an earlier block."""
_PAUSE_S: Final = 1.0
"""Pause before failed blocks are begun again [s]."""


class ForfeitStreaks:
    """Number of matches that each entrant has forfeited in a row: too many of them exclude it from further matches.

    Forfeits are counted in the order of the plan, whatever order the matches were played in. They are checked at the
    end of a block, so that all matches of a block have the same field.

    Args:
        most: number of forfeits in a row that exclude an entrant; 0 for no limit.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._forfeited: Counter[int] = Counter()
        self.excluded: dict[int, Fault] = {}
        """All excluded entrants, by index, with the reason."""

    def add(self, block: Iterable[PlayedMatch]) -> bool:
        """Count the forfeits of the next block of the plan.

        Returns:
            True if the block excludes an entrant.
        """
        before = len(self.excluded)
        for one in block:
            for index, forfeit in zip(one.match.seating, one.result.forfeits, strict=True):
                if forfeit is None:
                    self._forfeited[index] = 0
                    continue
                self._forfeited[index] += 1
                if self._forfeited[index] == self._most:
                    why = Fault("FORFEIT_OUT", f"it had forfeited {self._most} matches in a row")
                    self.excluded.setdefault(index, why)
        return len(self.excluded) > before

    def excluded_from(self, block: Block) -> Mapping[int, Fault]:
        """Return the excluded entrants of a block, by index, with the reason, after the blocks that were added."""
        players = {index for match in block for index in match.seating}
        return {index: why for index, why in self.excluded.items() if index in players}


@dataclass(slots=True)
class _QueuedBlock:
    """Block that was begun, and is not kept yet."""

    block: Block
    excluded: Mapping[int, Fault] = field(default_factory=dict)
    """Entrants that were excluded when the block was begun, by index, with the reason."""
    future: Future[list[RecordedMatch]] = field(default_factory=Future)
    matches: list[RecordedMatch] | None = None
    """Matches of the block; None while it is played."""
    failures: int = 0


def play_blocks(blocks: Iterable[Block], executor: Executor, streaks: ForfeitStreaks) -> Iterator[list[RecordedMatch]]:
    """Play these blocks, and yield the matches of each in the order of the plan.

    A block may begin before earlier blocks have ended; only a few are begun ahead of the workers, to bound the memory.
    If an earlier block excludes one of its entrants, the block is played again.

    Args:
        blocks: in the order of the plan.
        executor: plays them.
        streaks: decides which entrants are excluded; it is updated.

    Raises:
        MatchFailedError: for a block that failed on our side three times.
    """
    queue: deque[_QueuedBlock] = deque()

    def begin(one: _QueuedBlock) -> None:
        one.matches, one.excluded = None, streaks.excluded_from(one.block)
        one.future = executor.submit(one.block, one.excluded)

    def take(one: _QueuedBlock) -> bool:
        try:
            one.matches = executor.result(one.future)
        except MatchFailedError as error:
            one.failures += 1
            if one.failures == MOST_TRIES:
                raise MatchFailedError(
                    f"match {one.block[0].id} or another one of its block failed {MOST_TRIES} times: {error}"
                ) from None
        return one.matches is not None

    waiting = iter(blocks)
    block = next(waiting, None)
    while block is not None or queue:
        while (
            block is not None
            and sum(one.matches is None for one in queue) < executor.max_pending
            and len(queue) < executor.max_pending + _MOST_HELD
        ):
            queue.append(one := _QueuedBlock(block))
            begin(one)
            block = next(waiting, None)
        playing = [one for one in queue if one.matches is None]
        done = wait([one.future for one in playing], return_when=FIRST_COMPLETED).done
        # in order: the first failure is raised
        if failed := [one for one in playing if one.future in done and not take(one)]:
            time.sleep(_PAUSE_S)
        for one in failed:
            begin(one)
        while queue and (matches := queue[0].matches) is not None:
            yield matches
            queue.popleft()
            if streaks.add(played for played, _ in matches):
                for one in queue:
                    if one.excluded != streaks.excluded_from(one.block):
                        one.future.cancel()
                        begin(one)
