"""Blocks played side by side, and kept in the order of the plan: the results are those of one block after the other.

This is the only place that plays a match again: if it failed on our side, or if an entrant was excluded after it began.
"""

import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from typing import Final

from catch_arena.errors import NoContest
from catch_arena.tournament.execution.executors import Executor
from catch_arena.tournament.execution.forfeit_streaks import ForfeitStreaks
from catch_arena.tournament.execution.worker import RecordedMatch
from catch_arena.tournament.match import Block
from catch_arena.tournament.players import Fault

_MOST_TRIES: Final = 3
"""Tries of a block that fails on our side."""
_PAUSE_S: Final = 1.0
"""Pause before what failed is begun again."""
_MOST_HELD: Final = 256
"""Blocks that were played and wait, in memory, for one ahead of them."""


@dataclass(slots=True)
class _QueuedBlock:
    """A block that was begun, and is not kept yet."""

    block: Block
    excluded: Mapping[int, Fault] = field(default_factory=dict)
    """Entrants that were excluded when it was begun."""
    future: Future[list[RecordedMatch]] = field(default_factory=Future)
    matches: list[RecordedMatch] | None = None
    """None while it is played."""
    failures: int = 0


def play_blocks(
    blocks: Iterable[Block],
    executor: Executor,
    streaks: ForfeitStreaks,
    keep: Callable[[list[RecordedMatch]], None],
) -> None:
    """Play these blocks, a few ahead of the workers: they are not held in memory all at the same time.

    A block may begin before those ahead of it have ended. If these exclude one of its entrants, it is played again.

    Args:
        blocks: in the order of the plan.
        executor: plays them.
        streaks: decides which entrants are excluded; it is updated.
        keep: called with the matches of each block, in the order of the plan.

    Raises:
        NoContest: for a block that failed on our side three times.
    """
    queue: deque[_QueuedBlock] = deque()

    def begin(one: _QueuedBlock) -> None:
        one.matches, one.excluded = None, streaks.excluded_from(one.block)
        one.future = executor.submit(one.block, one.excluded)

    def take(one: _QueuedBlock) -> bool:
        try:
            one.matches = executor.result(one.future)
        except NoContest as error:
            one.failures += 1
            if one.failures == _MOST_TRIES:
                raise NoContest(
                    f"match {one.block[0].id} or another one of its block failed {_MOST_TRIES} times: {error}"
                ) from None
        return one.matches is not None

    def has_room(block: Block) -> bool:
        return (
            sum(one.matches is None for one in queue) < executor.max_pending
            and len(queue) < executor.max_pending + _MOST_HELD
            and streaks.may_begin(block, [one.block for one in queue])
        )

    waiting = iter(blocks)
    block = next(waiting, None)
    while block is not None or queue:
        while block is not None and has_room(block):
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
            keep(matches)
            queue.popleft()
            if streaks.add(played for played, _ in matches):
                for one in queue:
                    if one.excluded != streaks.excluded_from(one.block):
                        one.future.cancel()
                        begin(one)
