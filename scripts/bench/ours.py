"""Catch Arena's own interfaces: the env of one arena, and the batch in many sizes.

By public names only: `--against` measures older versions with this file.
"""

import mmap
import tracemalloc
from collections.abc import Callable, Iterator, Sequence
from inspect import signature
from typing import Any

import numpy as np
from gymnasium import spaces
from measure import Subject, Work

import catch_arena

ENV, BATCH, HUNTERS, TARGETS, RESET = "one arena", "batches", "more hunters", "more targets", "reset"
REFERENCES = 3
"""How many of ours stand beside the peers: the first subjects of all."""
_AGES, _NEIGHBOURS = 32, 32
"""How many different ones a large batch has, and how many different arenas of each."""
_FULL = {"initial_targets": 16, "spawn_frequency_hz": 10.0}
"""Targets enough that the arena stays full."""
USUAL = "4 hunters, 16 targets"
"""The arena beside which others are put in the tables of growing cost."""


def arena_name(control: str) -> str:
    """Of the env under that control."""
    return f"Catch Arena, one arena, {control} control"


def batch_name(control: str) -> str:
    """Of batches under that control."""
    return f"Catch Arena, batch, {control} control"


def hunters_name(hunters: int) -> str:
    """Of batches with so many hunters in each arena."""
    return f"{hunters} hunters, 16 targets"


def _work(config: catch_arena.ArenaConfig, seen: spaces.Space) -> Work:
    return Work(seen.shape[0], f"{config.control_period_ms / 16:g}", arbiter=True)


def one_arena(control: str, *, masks_read: bool = False) -> Subject:
    """The PettingZoo parallel env: 4 hunters who all chase the nearest target, or drive with fixed velocities; infos
    are made only where somebody reads them.
    """
    env = catch_arena.parallel_env("standard", control=control)
    env.reset(seed=1)
    velocity = np.array((0.8, 0.3), dtype=np.float32)
    action = {"target": 1, "velocity": velocity, "full": {"cmd_vel": velocity, "catch": 1}}[control]
    actions = dict.fromkeys(env.possible_agents, action)

    def step() -> None:
        infos = env.step(actions)[4]
        if masks_read:
            for agent in actions:
                infos[agent]["action_mask"]
        if not env.agents:
            env.reset()

    name = arena_name(control) + (", masks read" if masks_read else "")
    return Subject(
        ENV, name, step, env.config.hunters, _work(env.config, env.observation_space(env.possible_agents[0]))
    )


def _played(
    envs: int, threads: int = 1, control: str = "target", *, ranks_differ: bool = False, **overrides: object
) -> tuple[Callable[[], object], int, Work]:
    """A batch's step with fixed actions, its number of hunters, and what a step is."""
    config = catch_arena.scenario("standard", control=control, **overrides)
    arena = catch_arena.VectorArena(config, envs, num_threads=threads)
    _, infos = arena.reset(1)
    ranks = np.ones((envs, config.hunters), dtype=np.int64)
    if ranks_differ:
        ranks += np.arange(config.hunters) % (infos["action_mask"].shape[-1] - 1)
    velocities = np.random.default_rng(1).uniform(-1, 1, (envs, config.hunters, 2)).astype(np.float32)
    actions = {"target": (ranks,), "velocity": (None, velocities), "full": (ranks, velocities)}[control]
    if "choices" not in signature(arena.step).parameters:  # of an older commit, where they were one argument
        actions = ({"target": ranks, "velocity": velocities, "full": {"cmd_vel": velocities, "catch": ranks}}[control],)
    if envs >= _AGES * _NEIGHBOURS:  # a smaller one plays whole episodes in a turn
        spread(arena, actions)
    return lambda: arena.step(*actions), config.hunters, _work(config, arena.observation_space())


def spread(arena: catch_arena.VectorArena, actions: Sequence[Any]) -> None:
    """Have the arenas at all ages of an episode, and neighbours at the same one: late in an episode a step costs more
    than early, so a turn that is shorter than an episode would depend on where it begins, and on how many came before.
    """
    few = catch_arena.VectorArena(arena.config, _NEIGHBOURS)
    few.reset(1)
    first = [_few(one) for one in actions]
    saved = []
    for age in range(_AGES):
        saved += [few.save_row(row) for row in range(_NEIGHBOURS)]
        for _ in range(arena.config.max_steps * age // _AGES, arena.config.max_steps * (age + 1) // _AGES):
            few.step(*first)
    for row in range(arena.num_envs):
        arena.restore_row(row, saved[row % len(saved)])


def _few(actions: Any) -> Any:
    if isinstance(actions, dict):
        return {name: _few(one) for name, one in actions.items()}
    return None if actions is None else actions[:_NEIGHBOURS]


def batch(envs: int, threads: int = 1, control: str = "target") -> Subject:
    """The standard scenario, arena by arena in one array."""
    step, hunters, work = _played(envs, threads, control)
    return Subject(BATCH, batch_name(control), step, hunters, work, envs=envs, threads=threads)


def by_hunters(hunters: int, envs: int) -> Subject:
    """Few or many hunters; callers keep the number in the whole batch, and so the memory that a step moves.

    Each has a rank of its own to chase. If all chased the nearest, they would soon stand in one place: then the arbiter
    and the order of rivals at equal distances would be measured, and nothing else.
    """
    step, _, work = _played(envs, ranks_differ=True, hunters=hunters, **_FULL)
    return Subject(HUNTERS, hunters_name(hunters), step, hunters, work, envs=envs)


def by_targets(targets: int, envs: int) -> Subject:
    """4 hunters, few or many targets."""
    step, hunters, work = _played(envs, **{**_FULL, "max_targets": targets, "initial_targets": targets})
    return Subject(TARGETS, f"4 hunters, {targets} targets", step, hunters, work, envs=envs)


def resets(envs: int) -> Iterator[Subject]:
    """What a reset of one arena costs, alone and in a batch."""
    env = catch_arena.parallel_env("standard")
    env.reset(seed=1)
    arena = catch_arena.VectorArena("standard", envs)
    work = _work(arena.config, arena.observation_space())
    yield Subject(RESET, "Catch Arena, one arena, reset", env.reset, 4, work)
    yield Subject(RESET, "Catch Arena, batch, reset", lambda: arena.reset(1), 4, work, envs=envs)


def reference(*, quick: bool) -> list[Subject]:
    """Those that stand beside the peers."""
    return [one_arena("target"), *(batch(envs) for envs in _sizes(quick=quick)[-3:-1])]


def _sizes(*, quick: bool) -> tuple[int, ...]:
    return (1, 33, 40) if quick else (1, 32, 1024, 16384, 65536)


def all_others(*, quick: bool) -> list[Subject]:
    """Every other figure of ours."""
    sizes = _sizes(quick=quick)
    usual = sizes[-2]
    at_once = 64 if quick else 65536
    return [
        one_arena("target", masks_read=True),
        *(one_arena(control) for control in ("velocity", "full")),
        *(batch(envs) for envs in sizes if envs not in sizes[-3:-1]),
        *(batch(envs, threads=2) for envs in sizes),
        *(batch(usual, control=control) for control in ("velocity", "full")),
        *(by_hunters(hunters, at_once // hunters) for hunters in (2, 4, 8, 16, 32, 64)),
        *(by_targets(targets, at_once // 4) for targets in (4, 8, 16, 32, 64)),
        *resets(usual),
    ]


def bytes_per_arena(*, quick: bool) -> dict[int, float]:
    """What batches hold in memory for each arena, by their size."""
    return {envs: bytes_of_an_arena(envs) for envs in _sizes(quick=quick)}


class _Pages(mmap.mmap):
    """Memory that is asked of the system itself, as large batches do, and of which tracemalloc hears nothing."""

    taken = 0
    """[bytes], by all of them."""

    def __new__(cls, fileno: int, length: int, *arguments: Any, **options: Any) -> "_Pages":
        cls.taken += length
        return super().__new__(cls, fileno, length, *arguments, **options)


def bytes_of_an_arena(envs: int) -> float:
    """What a batch of that size holds in memory for each arena; without what is loaded once, for all batches."""
    catch_arena.VectorArena("standard", 2).reset(1)
    usual, _Pages.taken = mmap.mmap, 0
    mmap.mmap = _Pages  # type: ignore[misc]
    tracemalloc.start()
    try:
        arena = catch_arena.VectorArena("standard", envs)
        arena.reset(1)
        return (tracemalloc.get_traced_memory()[0] + _Pages.taken) / envs
    finally:
        tracemalloc.stop()
        mmap.mmap = usual  # type: ignore[misc]
