"""Plays a plan, and keeps every match as it ends; what comes out does not depend on where it is played."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from itertools import count
from pathlib import Path
from typing import Final

from catch_arena.config import ArenaConfig
from catch_arena.errors import WorkerLost
from catch_arena.replay import write_whole
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution.executors import Executor, InThisProcess, Processes
from catch_arena.tournament.execution.worker import Outcome, Worker
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.plans.schedule import Block, Match, Plan, Played, listed
from catch_arena.tournament.records.logs import Logs
from catch_arena.tournament.records.store import Store, Tournament

REPLAYS: Final = "replays"
LOGS: Final = "logs"
"""In the tournament's folder."""
_MOST_TRIES: Final = 3
"""How often a block is played before the loss of its worker is told."""


def run(
    config: ArenaConfig,
    entrants: Sequence[Entrant],
    matches: Sequence[Match] | Plan,
    *,
    jobs: int = 1,
    limits: AgentLimits | None = None,
    record: Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[Played]:
    """Play every match, without a store on disk; the results come in the order of the plan.

    Args: `jobs`, how many processes play, 1 for this one alone; `limits`, those of isolated agents, None where all are
    trusted; `record`, a tournament's folder, for replays and logs; `progress`, called with (played, in all).
    Raises: as `play_out`.
    """
    plan = listed(matches) if isinstance(matches, Sequence) else matches
    worker = Worker(config, tuple(entrants), record=record is not None, limits=limits)
    done = 0

    def told(played: Sequence[Played]) -> None:
        nonlocal done
        done += len(played)
        if progress is not None:
            progress(done, plan.size)

    with (
        Store.begin(Tournament(config, tuple(entrants), plan.words)) as store,
        InThisProcess(worker) if jobs == 1 else Processes(worker, jobs) as executor,
    ):
        play_out(store, plan, executor, folder=record, told=told)
        return list(store.played())


def play_out(
    store: Store,
    plan: Plan,
    executor: Executor,
    *,
    folder: Path | None = None,
    told: Callable[[Sequence[Played]], None] | None = None,
) -> None:
    """Play what is not in the store yet, stage by stage, until the plan has no further.

    A stage is written to the store before it is played, and each match when its block has ended. Whatever breaks it
    off, the same call goes on where it was.

    Args: `folder`, in which agents' logs are kept, and replays where the executor's worker makes them; `told`, called
    with what was played before, and then with the matches of each block.
    Raises: NoContest for a match that could not be held, or whose worker was lost, time and again; AgentError for an
    agent that another machine has not; OutputError and StoreError for what cannot be written. No process is left
    behind.
    """
    logs = None if folder is None else Logs(folder / LOGS, store.tournament.entrants)

    def keep(outcomes: Iterable[Outcome]) -> None:
        played = []
        for one, replay in outcomes:  # files first, so that what is kept has them
            if folder is not None and replay:
                (folder / REPLAYS).mkdir(exist_ok=True)
                write_whole(folder / REPLAYS / f"{one.match.id}.replay", replay)
            if logs is not None:
                logs.add(one)
            store.keep(one)
            played.append(one)
        if told is not None:
            told(played)

    if told is not None:
        told(list(store.played()))
    planned = 0
    for number in count():
        stage = store.plan(plan.stage(number, store.played(planned)))
        if not stage:
            return
        planned += stage
        _play_stage(store.waiting(), executor, keep)


def _play_stage(blocks: Iterable[Block], executor: Executor, keep: Callable[[Iterable[Outcome]], None]) -> None:
    """Play these blocks, a few ahead of the workers: they are not held in memory all at once."""
    tries: Counter[Block] = Counter()
    under_way: dict[Future[list[Outcome]], Block] = {}

    def submit(block: Block) -> None:
        under_way[executor.submit(block)] = block

    waiting = iter(blocks)
    while True:
        while len(under_way) < executor.ahead and (block := next(waiting, None)):
            submit(block)
        if not under_way:
            return
        done = wait(under_way, return_when=FIRST_COMPLETED).done
        for future in [future for future in under_way if future in done]:  # in order: the first failure is told
            block = under_way.pop(future)
            try:
                outcomes = executor.outcome(future)
            except WorkerLost as error:
                tries[block] += 1
                if tries[block] == _MOST_TRIES:
                    raise WorkerLost(
                        f"{error}, {_MOST_TRIES} times, while the block of match {block[0].id} was played: "
                        "a trusted agent may have ended it, or the memory ran out; --jobs 1 shows where"
                    ) from None
                submit(block)
            else:
                tries.pop(block, None)
                keep(outcomes)
