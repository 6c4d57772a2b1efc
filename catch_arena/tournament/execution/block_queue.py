"""Blocks played side by side, and kept in the order of the plan: the results are those of one block after the other.

A block may be begun before those ahead of it have ended, on the guess that nobody in them will be excluded. Where
somebody was, it is played again without that entrant.
"""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from typing import Final

from catch_arena.errors import WorkerLost
from catch_arena.tournament.execution.executors import Executor
from catch_arena.tournament.execution.forfeit_streaks import ForfeitStreaks
from catch_arena.tournament.execution.worker import RecordedMatch
from catch_arena.tournament.match import Block

_MOST_TRIES: Final = 3
"""How often a block is begun before the loss of its worker is an error."""
_MOST_HELD: Final = 256
"""How many blocks that were played may wait, in memory, for one ahead of them."""


@dataclass(slots=True)
class _QueuedBlock:
    """A block that was begun, and not kept yet."""

    block: Block
    excluded: Mapping[int, str]
    """Who was excluded when it was begun."""
    future: Future[list[RecordedMatch]]
    matches: list[RecordedMatch] | None = None
    """None while it is played."""
    lost: int = 0
    """How often its worker was."""


def play_blocks(
    blocks: Iterable[Block], executor: Executor, streaks: ForfeitStreaks, keep: Callable[[list[RecordedMatch]], None]
) -> None:
    """Play these blocks, a few ahead of the workers: they are not held in memory all at once.

    `keep` is called with the matches of each block, in the order of the plan. It raises what `runner.play_plan` does.
    """
    queue: deque[_QueuedBlock] = deque()
    waiting = iter(blocks)
    block = next(waiting, None)

    def begin(block: Block) -> tuple[Mapping[int, str], Future[list[RecordedMatch]]]:
        excluded = streaks.excluded_from(block)
        return excluded, executor.submit(block, excluded)

    while True:
        under_way = sum(one.matches is None for one in queue)
        while (
            block is not None
            and under_way < executor.lookahead
            and len(queue) < executor.lookahead + _MOST_HELD
            and streaks.may_begin(block, [one.block for one in queue])
        ):
            queue.append(_QueuedBlock(block, *begin(block)))
            under_way += 1
            block = next(waiting, None)
        if not queue:
            return
        done = wait([one.future for one in queue if one.matches is None], return_when=FIRST_COMPLETED).done
        for one in queue:  # in order: the first failure is raised
            if one.future in done:
                try:
                    one.matches = executor.result(one.future)
                except WorkerLost as error:
                    one.lost += 1
                    if one.lost == _MOST_TRIES:
                        raise WorkerLost(
                            f"{error}, {_MOST_TRIES} times, while the block of match {one.block[0].id} was played: "
                            "a trusted agent may have ended it, or the memory ran out; --jobs 1 shows where"
                        ) from None
                    one.excluded, one.future = begin(one.block)
        while queue and (matches := queue[0].matches) is not None:
            queue.popleft()
            keep(matches)
            if streaks.add(played for played, _ in matches):
                for one in queue:
                    if one.excluded != streaks.excluded_from(one.block):
                        one.future.cancel()
                        one.matches = None
                        one.excluded, one.future = begin(one.block)
