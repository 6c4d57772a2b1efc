"""What a plan will cost, told before it is played."""

import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Final

from catch_arena.errors import NoContest
from catch_arena.tournament.agent_spec import is_shipped
from catch_arena.tournament.execution.executors import Executor, ProcessExecutor
from catch_arena.tournament.execution.worker import Worker
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import FixedPlan, Plan
from catch_arena.tournament.store import store_bytes

_SAMPLE_S: Final = 2.0
"""How long matches are tried for, at least one."""


@dataclass(frozen=True, slots=True)
class Cost:
    """Of one match."""

    seconds: float
    """Of one process."""
    stored: int
    """Bytes in the store."""
    replay: int
    """Bytes of its replay, 0 where none is made."""
    tried: int
    """How many matches were played for this, and not kept."""
    forfeits: Mapping[str, str]
    """How entrants failed in them, by name: the time of these matches is theirs too."""


@dataclass(frozen=True, slots=True)
class WorstDelay:
    """The most time that agents in processes of their own may take, each by itself."""

    agents: int
    """How many could."""
    hanging_s: float
    """In a match of one that hangs: for its start, and for the step that it is given up in."""
    slow_s: float
    """In a match of one that is only just in time, always, and so does not forfeit."""
    matches: int
    """Of one that hangs in each, before it is out; all of its matches where it never is."""


def worst_delay(worker: Worker, matches: int, max_forfeits: int) -> WorstDelay | None:
    """What slow agents could cost at worst; None where nobody's time is limited.

    Args:
        worker: how a worker plays a match.
        matches: the most that an entrant plays.
        max_forfeits: as of `runner.play_plan`.
    """
    isolated = [entrant for entrant in worker.entrants if not is_shipped(entrant.spec)]
    if worker.limits is None or not isolated:
        return None
    init_s, step_s, bank_s = worker.limits.init_s, worker.limits.step_ms / 1000.0, worker.limits.bank_s
    in_block = Parties.of(worker.config).block_size
    in_blocks = -(-max_forfeits // in_block) * in_block
    return WorstDelay(
        agents=len(isolated),
        hanging_s=init_s + step_s + bank_s,
        slow_s=init_s + worker.config.max_steps * step_s + bank_s,
        matches=min(in_blocks, matches) if max_forfeits else matches,
    )


def measure_cost(worker: Worker, plan: Plan) -> Cost | None:
    """Return what a match of this plan costs here, or None if its first block fails on our side.

    Matches of the first block are tried, and not kept.
    """
    block = next(iter(plan.stage(0, ())))
    seconds, sizes = 0.0, []
    forfeits: dict[str, str] = {}
    foreign = worker.limits is None and not all(is_shipped(entrant.spec) for entrant in worker.entrants)
    # a trusted agent may end the process that it plays in
    with ProcessExecutor(worker, 1) if foreign else Executor(worker) as executor:
        try:
            executor.result(executor.submit(block[:1], {}))  # the first one loads and compiles
            for match in block:
                begin = time.perf_counter()
                ((played, replay),) = executor.result(executor.submit([match], {}))
                seconds += time.perf_counter() - begin
                sizes.append(len(replay))
                for index, forfeit in zip(match.seating, played.result.details, strict=True):
                    if forfeit is not None:
                        forfeits.setdefault(worker.entrants[index].name, str(forfeit))
                if seconds > _SAMPLE_S:
                    break
        except NoContest:
            return None
    tried = len(sizes)
    return Cost(seconds / tried, store_bytes(len(Parties.of(worker.config))), sum(sizes) // tried, tried, forfeits)


def match_counts(
    plan: FixedPlan, entrants: int, progress: Callable[[int, int], None] = lambda *_: None
) -> tuple[tuple[int, int], tuple[int, int]]:
    """How many matches an entrant plays, and how many a pair of them has in common: (least, most) of each."""
    played = [0] * entrants
    met: Counter[tuple[int, ...]] = Counter()
    counted = 0
    for block in plan.blocks():
        counted += len(block)
        progress(counted, plan.size)
        for match in block:
            group = sorted(match.seating)
            for one in group:
                played[one] += 1
            met.update(combinations(group, 2))
    together = [met[pair] for pair in combinations(range(entrants), 2)] or [0]
    return (min(played), max(played)), (min(together), max(together))
