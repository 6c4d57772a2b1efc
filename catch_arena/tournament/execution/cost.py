"""What a plan will cost, told before it is played."""

import time
from collections import Counter
from dataclasses import dataclass
from itertools import combinations
from typing import Final

from catch_arena.tournament.execution.worker import Worker
from catch_arena.tournament.plans.schedule import FixedPlan, Plan

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


def store_bytes(seats: int) -> int:
    """What a match takes in the store, about: scripts/measure_store.py."""
    return 120 + 62 * seats


def measured(worker: Worker, plan: Plan) -> Cost:
    """What a match of this plan costs here: its first block is tried, and none of it kept. Raises: NoContest."""
    block = next(iter(plan.stage(0, ())))
    seconds, sizes = 0.0, []
    try:
        worker.play(block[:1])  # the first one loads and compiles
        for match in block:
            begin = time.perf_counter()
            ((_, replay),) = worker.play([match])
            seconds += time.perf_counter() - begin
            sizes.append(len(replay))
            if seconds > _SAMPLE_S:
                break
    finally:
        worker.close()
    tried = len(sizes)
    return Cost(seconds / tried, store_bytes(worker.config.hunters), sum(sizes) // tried, tried)


def shares(plan: FixedPlan, entrants: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """How many matches an entrant plays, and how many a pair of them has in common: (least, most) of each."""
    played = [0] * entrants
    met: Counter[tuple[int, ...]] = Counter()
    for block in plan.blocks():
        group = sorted(block[0].seating)
        for one in group:
            played[one] += len(block)
        for pair in combinations(group, 2):
            met[pair] += len(block)
    together = [met[pair] for pair in combinations(range(entrants), 2)] or [0]
    return (min(played), max(played)), (min(together), max(together))
