"""Cost of a plan in time and space, estimated before it is played."""

import time
from collections import Counter
from dataclasses import dataclass
from itertools import combinations
from typing import Final

from catch_arena.errors import MatchFailedError
from catch_arena.tournament.agent_spec import is_shipped
from catch_arena.tournament.execution.executors import Executor, ProcessExecutor, Worker
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import Plan

_SAMPLE_S: Final = 2.0
"""Time for trying matches [s]; at least one is tried."""


@dataclass(frozen=True, slots=True)
class Cost:
    """Mean cost of one match."""

    seconds: float
    """Time in one process [s]."""
    stored: int
    """Approximate size in the store [bytes] (docs/howto/long_runs.md)."""
    replay: int
    """Size of the replay [bytes]; 0 if none is made."""


def measure_cost(worker: Worker, plan: Plan) -> Cost | None:
    """Return the cost of a match of this plan on this machine, or None if it fails on our side.

    Matches of the first block are tried, and not kept.
    """
    block = next(plan.blocks())
    seconds, sizes = 0.0, []
    foreign = worker.quotas is None and not all(is_shipped(entrant.spec) for entrant in worker.entrants)
    try:
        # a trusted agent may end the process that it plays in
        with ProcessExecutor(worker, 1) if foreign else Executor(worker) as executor:
            executor.result(executor.run(worker.play_block, block[:1], {}))  # the first one loads and compiles
            for match in block:
                begin = time.perf_counter()
                ((_, replay),) = executor.result(executor.run(worker.play_block, [match], {}))
                seconds += time.perf_counter() - begin
                sizes.append(len(replay))
                if seconds > _SAMPLE_S:
                    break
    except MatchFailedError:
        return None
    tried, stored = len(sizes), 400 + 90 * len(Parties.of(worker.config))
    return Cost(seconds / tried, stored, sum(sizes) // tried)


def match_counts(plan: Plan, entrants: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return (least, most) of the matches of an entrant, and (least, most) of the common matches of a pair."""
    played: Counter[int] = Counter()
    met: Counter[tuple[int, ...]] = Counter()
    for match in plan:
        played.update(match.seating)
        met.update(combinations(sorted(match.seating), 2))
    each = [played[one] for one in range(entrants)]
    together = [met[pair] for pair in combinations(range(entrants), 2)] or [0]
    return (min(each), max(each)), (min(together), max(together))
