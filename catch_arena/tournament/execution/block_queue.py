"""Blocks, or other tasks, that an executor does in parallel, with the results of serial play in the order of the plan.

Only this module plays a match again: if it failed on our side, or if one of its entrants was excluded after its start.
"""

import time
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, wait
from functools import partial
from itertools import islice
from typing import Any, Final, TypeVar

from catch_arena.errors import MatchFailedError
from catch_arena.tournament.execution.executors import Executor, RecordedMatch
from catch_arena.tournament.match import Block, Fault, PlayedMatch

_Task = TypeVar("_Task", bound=Hashable)
_Result = TypeVar("_Result")

_MOST_TRIES: Final = 3
"""Largest number of tries of a block, or of another task, that fails on our side."""
_MOST_HELD: Final = 256
"""Largest number of results that wait in memory for an earlier one."""
_PAUSE_S: Final = 1.0
"""Pause before a failed task is begun again [s]."""


def do_in_order(
    tasks: Iterable[_Task],
    executor: Executor,
    begin: Callable[[_Task], Future[_Result]],
    is_outdated: Callable[[_Task], bool] = lambda _: False,
) -> Iterator[tuple[_Task, _Result | MatchFailedError]]:
    """Do tasks in parallel, and yield each with its result, in the order of the tasks.

    A task may begin before earlier ones have ended; only a few are begun ahead of the workers, to bound the memory. One
    that fails on our side is done again, at most three times in all. The last time nothing else is running, so that it
    costs no other one; if it fails again, its result is the error. No two tasks are equal. After each result,
    `is_outdated` is asked whether a task that was begun must begin again.
    """
    waiting = iter(tasks)
    begun: dict[_Task, Future[_Result]] = {}  # in the order of the tasks
    failures: Counter[_Task] = Counter()
    rested: set[Future[_Result]] = set()  # those that had ended before the last pause: one is enough for all of them
    while True:
        running = sum(not future.done() for future in begun.values())
        room = min(executor.max_pending - running, executor.max_pending + _MOST_HELD - len(begun))
        for task in islice(waiting, max(0, room)):
            begun[task] = begin(task)
        if not begun:
            return
        first = next(iter(begun))
        if not begun[first].done():
            wait([future for future in begun.values() if not future.done()], return_when=FIRST_COMPLETED)
            continue
        result: _Result | MatchFailedError
        try:
            result = executor.result(begun[first])
        except MatchFailedError as error:
            failures[first] += 1
            if failures[first] < _MOST_TRIES:
                if begun[first] not in rested:
                    time.sleep(_PAUSE_S)
                    rested = {future for future in begun.values() if future.done()}
                alone = failures[first] == _MOST_TRIES - 1
                if alone:
                    wait(begun.values())
                begun[first] = begin(first)
                if alone:
                    wait([begun[first]])
                continue
            result = error
        del begun[first]
        yield first, result
        for task in filter(is_outdated, begun):
            begun[task].cancel()
            begun[task] = begin(task)


def do_here(work: Callable[..., _Result], *arguments: Any, **options: Any) -> _Result:
    """Do a task in this process, as `do_in_order` does it; raise the MatchFailedError of the last try."""
    here = Executor()
    ((_, result),) = do_in_order([work], here, lambda task: here.run(partial(task, *arguments, **options)))
    if isinstance(result, MatchFailedError):
        raise result
    return result


class ForfeitStreaks:
    """Number of matches that each entrant has forfeited in a row: `most` of them exclude it; 0 is no limit.

    Forfeits are counted in the order of the plan, whatever order the matches were played in. They are checked at the
    end of a block, so that all matches of a block have the same field.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._forfeited: Counter[int] = Counter()
        self.excluded: dict[int, Fault] = {}
        """All excluded entrants, by index, with the reason."""

    def add(self, block: Iterable[PlayedMatch]) -> None:
        """Count the forfeits of the next block of the plan."""
        for one in block:
            for index, forfeit in zip(one.match.seating, one.result.forfeits, strict=True):
                if forfeit is None:
                    self._forfeited[index] = 0
                    continue
                self._forfeited[index] += 1
                if self._forfeited[index] == self._most:
                    why = Fault("FORFEIT_OUT", f"it had forfeited {self._most} matches in a row")
                    self.excluded.setdefault(index, why)

    def excluded_from(self, block: Block) -> Mapping[int, Fault]:
        """Return the excluded entrants of a block, by index, with the reason, after the blocks that were added."""
        return {index: why for index, why in self.excluded.items() if any(index in match.seating for match in block)}


def play_blocks(blocks: Iterable[Block], executor: Executor, streaks: ForfeitStreaks) -> Iterator[list[RecordedMatch]]:
    """Play blocks in parallel, and yield the matches of each in the order of the blocks, which is that of the plan.

    A block is played again if the forfeits in an earlier one exclude one of its entrants. One that failed on our side
    three times raises MatchFailedError.
    """
    excluded: dict[Block, Mapping[int, Fault]] = {}  # when each block was begun

    def begin(block: Block) -> Future[list[RecordedMatch]]:
        excluded[block] = streaks.excluded_from(block)
        return executor.run(executor.worker.play_block, block, excluded[block])

    def is_outdated(block: Block) -> bool:
        return excluded[block] != streaks.excluded_from(block)

    for block, matches in do_in_order(blocks, executor, begin, is_outdated):
        del excluded[block]
        if isinstance(matches, MatchFailedError):
            why = f"match {block[0].id} or another one of its block failed {_MOST_TRIES} times: {matches}"
            raise MatchFailedError(why)
        yield matches  # the caller stores them before their forfeits count
        streaks.add(played for played, _ in matches)
