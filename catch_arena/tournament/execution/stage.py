"""The blocks of one stage, played side by side; what comes out is what playing them one after the other gives.

A block may be begun before those ahead of it have ended, as if nobody in them were put out. Where somebody was, it is
played again without the one who is out.
"""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from typing import Final

from catch_arena.errors import WorkerLost
from catch_arena.tournament.execution.executors import Executor
from catch_arena.tournament.execution.streaks import Streaks
from catch_arena.tournament.execution.worker import Outcome
from catch_arena.tournament.plans.schedule import Block

_MOST_TRIES: Final = 3
"""How often a block is played before the loss of its worker is told."""
_MOST_HELD: Final = 256
"""How many blocks that were played may wait, in memory, for one ahead of them."""


@dataclass(slots=True)
class _Turn:
    """A block that was begun."""

    block: Block
    out: Mapping[int, str]
    """Who was out when it was begun."""
    future: Future[list[Outcome]]
    outcomes: list[Outcome] | None = None
    lost: int = 0
    """How often its worker was."""


def play_stage(
    blocks: Iterable[Block], executor: Executor, streaks: Streaks, keep: Callable[[list[Outcome]], None]
) -> None:
    """Play these blocks, a few ahead of the workers: they are not held in memory all at once.

    Args: `keep`, called with the outcomes of each block, in the order of the plan.
    Raises: as `runner.play_out`.
    """
    turns: deque[_Turn] = deque()
    waiting = iter(blocks)
    block = next(waiting, None)

    def begin(block: Block) -> tuple[Mapping[int, str], Future[list[Outcome]]]:
        out = streaks.out_of(block)
        return out, executor.submit(block, out)

    while True:
        under_way = sum(turn.outcomes is None for turn in turns)
        while (
            block is not None
            and under_way < executor.ahead
            and len(turns) < executor.ahead + _MOST_HELD
            and streaks.may_begin(block, [turn.block for turn in turns])
        ):
            turns.append(_Turn(block, *begin(block)))
            under_way += 1
            block = next(waiting, None)
        if not turns:
            return
        done = wait([turn.future for turn in turns if turn.outcomes is None], return_when=FIRST_COMPLETED).done
        for turn in turns:  # in order: the first failure is told
            if turn.future in done:
                try:
                    turn.outcomes = executor.outcome(turn.future)
                except WorkerLost as error:
                    turn.lost += 1
                    if turn.lost == _MOST_TRIES:
                        raise WorkerLost(
                            f"{error}, {_MOST_TRIES} times, while the block of match {turn.block[0].id} was played: "
                            "a trusted agent may have ended it, or the memory ran out; --jobs 1 shows where"
                        ) from None
                    turn.out, turn.future = begin(turn.block)
        while turns and (outcomes := turns[0].outcomes) is not None:
            turns.popleft()
            keep(outcomes)
            if streaks.add(played for played, _ in outcomes):
                for turn in turns:
                    if turn.out != streaks.out_of(turn.block):
                        turn.future.cancel()
                        turn.outcomes = None
                        turn.out, turn.future = begin(turn.block)
