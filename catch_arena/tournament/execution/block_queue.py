"""Blocks played side by side, and kept in the order of the plan: the results are those of one block after the other.

A block that comes to nothing is put in quarantine: it is played by itself when those ahead of it have been kept.

A block may be begun before those ahead of it have ended, on the guess that nobody in them will be excluded. Where
somebody was, it is played again without that entrant.
"""

from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from typing import Final

from catch_arena.errors import NoContest, OutputError, StoreError, WorkerLost
from catch_arena.tournament.execution.executors import Executor
from catch_arena.tournament.execution.forfeit_streaks import ForfeitStreaks
from catch_arena.tournament.execution.quarantine import Quarantine
from catch_arena.tournament.execution.worker import Excluded, RecordedMatch
from catch_arena.tournament.match import Block

_MOST_TRIES: Final = 3
"""How often a block is begun before the loss of its worker is an error."""
_MOST_HELD: Final = 256
"""How many blocks that were played may wait, in memory, for one ahead of them."""


@dataclass(slots=True)
class _QueuedBlock:
    """A block that was begun, and not kept yet."""

    block: Block
    excluded: Excluded = field(default_factory=dict)
    """Who was excluded when it was begun."""
    future: Future[list[RecordedMatch]] = field(default_factory=Future)
    matches: list[RecordedMatch] | None = None
    """None while it is played."""
    lost: int = 0
    """How often it came to nothing."""
    in_quarantine: bool = False
    """Whether it will be played by itself, with its agents apart."""


def play_blocks(
    blocks: Iterable[Block],
    executor: Executor,
    streaks: ForfeitStreaks,
    quarantine: Quarantine,
    keep: Callable[[list[RecordedMatch]], None],
) -> None:
    """Play these blocks, a few ahead of the workers: they are not held in memory all at once.

    `keep` is called with the matches of each block, in the order of the plan. It raises what `runner.play_plan` does.
    """
    _BlockQueue(executor, streaks, quarantine, keep).play(blocks)


class _BlockQueue:
    """The blocks that were begun, in the order of the plan."""

    def __init__(
        self,
        executor: Executor,
        streaks: ForfeitStreaks,
        quarantine: Quarantine,
        keep: Callable[[list[RecordedMatch]], None],
    ) -> None:
        self._executor = executor
        self._streaks = streaks
        self._quarantine = quarantine
        self._keep = keep
        self._queue: deque[_QueuedBlock] = deque()

    def play(self, blocks: Iterable[Block]) -> None:
        waiting = iter(blocks)
        block = next(waiting, None)
        while True:
            while block is not None and self._has_room(block):
                self._begin(one := _QueuedBlock(block), fresh=True)
                self._queue.append(one)
                block = next(waiting, None)
            if not self._queue:
                return
            if running := self._running():
                done = wait([one.future for one in running], return_when=FIRST_COMPLETED).done
                for one in running:  # in order: the first failure is raised
                    if one.future in done:
                        self._take(one)
            elif self._queue[0].in_quarantine:  # nothing else is played: who does harm now is found
                one = self._queue[0]
                one.excluded = self._streaks.excluded_from(one.block)
                one.matches = self._quarantine.play(one.block, one.excluded)
            while self._queue and (matches := self._queue[0].matches) is not None:
                self._keep_first(matches)

    def _running(self) -> list[_QueuedBlock]:
        return [one for one in self._queue if one.matches is None and not one.in_quarantine]

    def _has_room(self, block: Block) -> bool:
        """Whether a block should be begun now; none is while a quarantine is due."""
        return (
            not any(one.in_quarantine for one in self._queue)
            and len(self._running()) < self._executor.max_pending
            and len(self._queue) < self._executor.max_pending + _MOST_HELD
            and self._streaks.may_begin(block, [one.block for one in self._queue])
        )

    def _begin(self, one: _QueuedBlock, *, fresh: bool = False) -> None:
        one.matches, one.excluded = None, self._streaks.excluded_from(one.block)
        one.in_quarantine = fresh and self._quarantine.is_due(one.block, one.excluded)
        if not one.in_quarantine:
            self._quarantine.note_begun(one.block, one.excluded)
            one.future = self._executor.submit(one.block, one.excluded)

    def _take(self, one: _QueuedBlock) -> None:
        """What came of a block."""
        try:
            one.matches = self._executor.result(one.future)
        except NoContest as error:
            one.lost += 1
            if self._quarantine.has_suspects(one.block, one.excluded) and (
                one.lost > self._executor.tolerated_losses or not isinstance(error, WorkerLost)
            ):
                one.in_quarantine = True
            elif not isinstance(error, WorkerLost):
                raise
            elif one.lost == _MOST_TRIES:
                raise WorkerLost(
                    f"{error}, {_MOST_TRIES} times, while the block of match {one.block[0].id} was played: "
                    "a trusted agent may have ended it, or the memory ran out; --jobs 1 shows where"
                ) from None
            else:
                self._begin(one)

    def _keep_first(self, matches: list[RecordedMatch]) -> None:
        try:
            self._keep(matches)
        except (OutputError, StoreError):
            suspected = [one for one in self._running() if self._quarantine.has_suspects(one.block, one.excluded)]
            if not suspected:
                raise
            # an agent that is playing may have filled the disk: there is room again when it has ended
            wait([one.future for one in self._running()])
            self._executor.stop_agents()
            for one in suspected:
                one.in_quarantine = True
            self._keep(matches)
        self._quarantine.note_kept(self._queue.popleft().block)
        if self._streaks.add(played for played, _ in matches):
            for one in self._queue:
                if one.excluded != self._streaks.excluded_from(one.block):
                    one.future.cancel()
                    self._begin(one)
