"""Queue of blocks that are played in parallel and kept in the order of the plan, with the results of serial play.

Only this module plays a match again: if it failed on our side, or if one of its entrants was excluded after its start.
"""

import time
from collections import Counter, deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from typing import Final, Generic, TypeVar

from catch_arena.errors import MatchFailedError
from catch_arena.tournament.execution.executors import Executor, RecordedMatch
from catch_arena.tournament.match import Block, Fault, PlayedMatch

_Task = TypeVar("_Task", bound=Hashable)
_Result = TypeVar("_Result")

_MOST_TRIES: Final = 3
"""Largest number of tries of a block, or of another task, that fails on our side."""
_MOST_HELD: Final = 256
"""Largest number of played blocks that wait in memory for an earlier block."""
_PAUSE_S: Final = 1.0
"""Pause before failed tasks are begun again [s]."""


class WorkQueue(Generic[_Task, _Result]):
    """Tasks that an executor does in parallel, such as blocks to play and submissions to grade.

    One that fails on our side is done again, at most three times in all. The last time nothing else is running, so that
    it costs no other one.

    Args:
        executor: does the tasks.
        begin: begins a task in the executor.
    """

    def __init__(self, executor: Executor, begin: Callable[[_Task], Future[_Result]]) -> None:
        self._executor = executor
        self._begin = begin
        self._running: dict[Future[_Result], _Task] = {}
        self._failures: Counter[_Task] = Counter()  # of tasks that are done again

    def __bool__(self) -> bool:
        """Return whether a begun task has not ended."""
        return bool(self._running or self._failures)

    @property
    def has_room(self) -> bool:
        """True if another task can be begun: the executor has room, and no task is to be done alone."""
        return not self._alone and len(self._running) < self._executor.max_pending

    @property
    def _alone(self) -> list[_Task]:
        return [task for task, failures in self._failures.items() if failures == _MOST_TRIES - 1]

    def begin(self, task: _Task) -> None:
        """Begin a task; if it has begun already, its result is dropped and it begins again."""
        for future in [future for future, one in self._running.items() if one is task]:
            future.cancel()
            del self._running[future]
        self._running[self._begin(task)] = task

    def ended(self) -> Iterator[tuple[_Task, _Result | MatchFailedError]]:
        """Wait, and yield the tasks that have ended, with their results; the error after three failures."""
        if not self._running:
            self.begin(self._alone[0])
        done = wait(list(self._running), return_when=FIRST_COMPLETED).done
        failed = []
        for future in [future for future in self._running if future in done]:
            task = self._running.pop(future)
            result: _Result | MatchFailedError
            try:
                result = self._executor.result(future)
            except MatchFailedError as error:
                self._failures[task] += 1
                if self._failures[task] < _MOST_TRIES:
                    failed.append(task)
                    continue
                result = error
            del self._failures[task]
            yield task, result
        if failed:
            time.sleep(_PAUSE_S)
        for task in failed:
            if task not in self._alone:
                self.begin(task)


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


@dataclass(slots=True, eq=False)
class _QueuedBlock:
    """Block that was begun, and is not kept yet."""

    block: Block
    excluded: Mapping[int, Fault] | None = None
    """Entrants that were excluded when the block was begun, by index, with the reason."""
    matches: list[RecordedMatch] | None = None
    """Matches of the block; None while it is played."""


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

    def begin(one: _QueuedBlock) -> Future[list[RecordedMatch]]:
        one.matches, one.excluded = None, streaks.excluded_from(one.block)
        return executor.submit(one.block, one.excluded)

    work = WorkQueue(executor, begin)
    queue: deque[_QueuedBlock] = deque()
    waiting = iter(blocks)
    block = next(waiting, None)
    while block is not None or queue:
        while block is not None and work.has_room and len(queue) < executor.max_pending + _MOST_HELD:
            queue.append(one := _QueuedBlock(block))
            work.begin(one)
            block = next(waiting, None)
        for one, played in work.ended():
            if isinstance(played, MatchFailedError):
                why = f"match {one.block[0].id} or another one of its block failed {_MOST_TRIES} times: {played}"
                raise MatchFailedError(why)
            one.matches = played
        while queue and (matches := queue[0].matches) is not None:
            yield matches
            queue.popleft()
            if streaks.add(played for played, _ in matches):
                for one in queue:
                    if one.excluded != streaks.excluded_from(one.block):
                        work.begin(one)
