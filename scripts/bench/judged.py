"""Which figure of a run each target judges."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import ours
from measure import Subject, ratio
from peers import MPE2, PEERS, PUFFERLIB
from startup import ONE_ARENA_WARM
from wanted import (
    BESIDE_PEERS,
    BESIDE_PUFFERLIB,
    BESIDE_TARGET_CONTROL,
    MANY_HUNTERS,
    MEMORY,
    ONE_ARENA_BESIDE_MPE2,
    TWO_THREADS,
    WARM_START,
    Wanted,
)


class Judged(NamedTuple):
    """A figure, None where it was not measured, and what it ought to be."""

    what: str
    measured: float | None
    wanted: Wanted


def judged(figures: Mapping[str, Any], subjects: Sequence[Subject]) -> Iterator[Judged]:
    """Every target that one run can judge."""
    _, small, large = subjects[: ours.REFERENCES]

    def first(name: str, envs: int | None = None, threads: int = 1) -> Subject | None:
        alike = (one for one in subjects if (one.name, one.threads) == (name, threads) and envs in {None, one.envs})
        return next(alike, None)

    for name, wanted in BESIDE_PEERS.items():
        sizes = [one for one in subjects if (one.group, one.name) == (PEERS, name)]
        best = max(sizes, key=lambda one: one.agent_steps, default=None)
        for batch in (small, large):
            what = f"batch of {batch.envs:,} beside the best of {name}, agent-steps"
            yield Judged(what, _faster(batch, best, per_agent=True), wanted)
    for goals, wanted in BESIDE_PUFFERLIB.items():
        name = f"{PUFFERLIB}, {goals} goals"
        what = f"batch of {small.envs:,} beside {name}, agent-steps"
        yield Judged(what, _faster(small, first(name), per_agent=True), wanted)
    for control, wanted in ONE_ARENA_BESIDE_MPE2.items():
        found = _faster(first(ours.arena_name(control)), first(MPE2))
        yield Judged(f"one arena, {control} control, beside {MPE2}, env-steps", found, wanted)
    for control, wanted in BESIDE_TARGET_CONTROL.items():
        found = _faster(first(ours.batch_name(control), large.envs), large)
        yield Judged(f"batch of {large.envs:,}, {control} control beside target control", found, wanted)

    two = first(large.name, large.envs, threads=2)
    found = ratio(two.env_steps_on_the_wall, large.env_steps_on_the_wall) if two else None
    yield Judged(f"batch of {large.envs:,}, two threads beside one, on the wall", found, TWO_THREADS)
    found = _faster(first(ours.hunters_name(4)), first(ours.hunters_name(64)), per_agent=True)
    yield Judged("cost of an agent-step, 64 hunters beside 4", found, MANY_HUNTERS)
    warm = figures.get("startup", {}).get(ONE_ARENA_WARM, {})
    yield Judged(f"{ONE_ARENA_WARM}, CPU-s", warm.get("cpu_s"), WARM_START)
    held = figures.get("bytes_per_arena", {})
    yield Judged(f"memory of a batch of {large.envs:,}, bytes an arena", held.get(large.envs), MEMORY)


def _faster(one: Subject | None, other: Subject | None, *, per_agent: bool = False) -> float | None:
    """How many times as many steps one plays."""
    if one is None or other is None:
        return None
    return ratio(one.env_steps, other.env_steps) * (one.agents / other.agents if per_agent else 1)
