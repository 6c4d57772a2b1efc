"""Rows that measure Catch Arena.

They use public names only, since `--against` measures older versions with this file.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
from subject import Row, Subject

import catch_arena

ONE_ARENA, BATCH, LARGE = "one arena, target control", "batch of 1,024", "batch of 16,384"
"""Names of the rows that are compared with the peers."""
_AGES, _NEIGHBOURS = 32, 32
"""Number of ages in a large batch, and of different arenas of each age."""
_FIRST_STEP = (
    "import catch_arena; env = catch_arena.parallel_env(); env.reset(seed=1); env.step(dict.fromkeys(env.agents, 1))"
)
_MEMORY = """
import catch_arena, resource
def taken(): return int(open("/proc/self/statm").read().split()[1]) * resource.getpagesize()
catch_arena.VectorArena("standard", 2).reset(1)
before = taken()
arena = catch_arena.VectorArena("standard", {envs})
arena.reset(1)
print((taken() - before) / {envs})
"""
_AGENTS = ("nearest", "contested", "contested_by_time", "patrol")


def rows() -> dict[str, Row]:
    """Return all rows by name."""
    large, agents = 16384, 65536  # arenas; hunters of all arenas together
    step, arena = "ns per agent-step", "us per step"
    full = {"initial_targets": 16, "spawn_frequency_hz": 10.0}  # enough targets to keep the arena full
    sizes = (4, 16, 64)
    hunters = {f"{n} hunters": partial(batch, agents // n, ranks_differ=True, hunters=n, **full) for n in sizes}
    targets = {f"{n} targets": partial(batch, large, **full | {"max_targets": n, "initial_targets": n}) for n in sizes}
    return {
        "batch of 32": Row("batch", step, partial(batch, 32)),
        BATCH: Row("batch", step, partial(batch, 1024)),
        LARGE: Row("batch", step, partial(batch, large)),
        f"{LARGE}, two threads": Row("threads", step, partial(batch, large, threads=2)),
        f"{LARGE}, velocity control": Row("controls", step, partial(batch, large, control="velocity")),
        f"{LARGE}, full control": Row("controls", step, partial(batch, large, control="full")),
        **{name: Row("hunters", step, make) for name, make in hunters.items()},
        **{name: Row("targets", step, make) for name, make in targets.items()},
        ONE_ARENA: Row("one-arena", arena, partial(one_arena, "target")),
        f"{ONE_ARENA}, masks read": Row("one-arena", arena, partial(one_arena, "target", masks_read=True)),
        "one arena, velocity control": Row("one-arena", arena, partial(one_arena, "velocity")),
        "one arena, full control": Row("one-arena", arena, partial(one_arena, "full")),
        "LearnerBatch, nearest": Row("learners", step, partial(learners, 256, "nearest")),
        "LearnerBatch, patrol": Row("learners", step, partial(learners, 256, "patrol")),
        "reset of one arena": Row("resets", "us per reset", reset),
        "reset of a batch of 16,384": Row("resets", "us per reset", partial(reset, large)),
        "env.render()": Row("render", "ms per frame", render),
        "video of 10 s, 1280 x 720": Row("render", "CPU-s", video),
        "tournament, trusted": Row("isolation", "s", partial(tournament, "--trusted")),
        **{
            f"tournament, {level}": Row("isolation", "s", partial(tournament, f"--limit=isolation={level}"))
            for level in ("processes", "namespaces")
        },
        "first step, warm": Row("warm", "CPU-s", first_step),
        "first step, cold": Row("cold", "CPU-s", partial(first_step, cold=True)),
        "memory": Row("memory", "bytes per arena", partial(memory, large)),
    }


def one_arena(control: str, *, masks_read: bool = False) -> Subject:
    """Make the PettingZoo parallel env: 4 hunters that all chase the nearest target, or drive with fixed velocities."""
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

    return Subject(step, len(actions), floats=env.observation_space(env.possible_agents[0]).shape[0])


def batch(
    envs: int, threads: int = 1, control: str = "target", *, ranks_differ: bool = False, **overrides: object
) -> Subject:
    """Make a batch of the standard scenario with fixed actions.

    All hunters chase the nearest target, or with `ranks_differ` each chases a rank of its own: many hunters that chase
    the nearest soon stand in one place, and only the arbiter and the order of equally near rivals would be measured.
    """
    config = catch_arena.scenario("standard", control=control, **overrides)
    arena = catch_arena.VectorArena(config, envs, num_threads=threads)
    _, infos = arena.reset(1)
    ranks = np.ones((envs, config.hunters), dtype=np.int64)
    if ranks_differ:
        ranks += np.arange(config.hunters) % (infos["action_mask"].shape[-1] - 1)
    velocities = np.random.default_rng(1).uniform(-1, 1, (envs, config.hunters, 2)).astype(np.float32)
    actions = {"target": (ranks,), "velocity": (None, velocities), "full": (ranks, velocities)}[control]
    if "choices" not in signature(arena.step).parameters:  # older commits have one argument for all actions
        actions = ({"target": ranks, "velocity": velocities, "full": {"cmd_vel": velocities, "catch": ranks}}[control],)
    if envs >= _AGES * _NEIGHBOURS:  # a smaller batch plays whole episodes in a turn
        spread(arena, actions)
    floats = arena.observation_space().shape[0]
    return Subject(lambda: arena.step(*actions), config.hunters, envs, floats, threads=threads)


def spread(arena: catch_arena.VectorArena, actions: Sequence[Any]) -> None:
    """Put the arenas at all ages of an episode, with neighbours at the same age.

    Late in an episode a step costs more than early. Without this, a turn shorter than an episode would depend on its
    first step.
    """
    few = catch_arena.VectorArena(arena.config, _NEIGHBOURS)
    few.reset(1)
    first = [_few(one) for one in actions]
    # older commits have methods of their own for one row
    save = few.save if not hasattr(few, "save_row") else few.save_row
    restore = arena.restore if not hasattr(arena, "restore_row") else lambda state, row: arena.restore_row(row, state)
    saved = []
    for age in range(_AGES):
        saved += [save(row) for row in range(_NEIGHBOURS)]
        for _ in range(arena.config.max_steps * age // _AGES, arena.config.max_steps * (age + 1) // _AGES):
            few.step(*first)
    for row in range(arena.num_envs):
        restore(saved[row % len(saved)], row)


def _few(actions: Any) -> Any:
    if isinstance(actions, dict):
        return {name: _few(one) for name, one in actions.items()}
    return None if actions is None else actions[:_NEIGHBOURS]


def learners(envs: int, opponents: str) -> Subject:
    """Make the batch of one learner in each arena and three opponents; all four are agents of a step."""
    from catch_arena.training import LearnerBatch

    arena = LearnerBatch("standard", envs, opponents=opponents, normalise=True)
    arena.reset(1)
    hold = np.ones(arena.num_rows, dtype=np.int64)
    return Subject(lambda: arena.step(hold), arena.config.hunters, envs)


def reset(envs: int = 0) -> Subject:
    """Make a batch that is reset all the time, or one env."""
    if not envs:
        return Subject(catch_arena.parallel_env("standard").reset)
    arena = catch_arena.VectorArena("standard", envs)
    return Subject(lambda: arena.reset(1), envs=envs)


def render() -> Subject:
    """Make an env that draws each step into an array."""
    env = catch_arena.parallel_env("standard", render_mode="rgb_array")
    env.reset(seed=1)
    actions = dict.fromkeys(env.possible_agents, 1)

    def step() -> None:
        env.step(actions)
        env.render()
        if not env.agents:
            env.reset()

    return Subject(step)


def video() -> Subject:
    """Make a process that renders a match of 10 s, at 60 frames a second."""
    folder = tempfile.TemporaryDirectory()
    replay = Path(folder.name, "match.replay")
    match = ("-m", "catch_arena", "match", "nearest", "first", "--scenario=duel", "--set=time_limit_s=10", "--seed=1")
    _process(*match, "-o", str(replay))()
    step = _process("-m", "catch_arena", "render", str(replay), "--size=1280x720", "--fps=60", "-o", "match.mp4")
    return Subject(lambda: (folder, step()))  # the folder lives as long as the step


def first_step(*, cold: bool = False) -> Subject:
    """Make a process that ends after the first step of one arena; `cold` has nothing compiled before."""
    return Subject(_process("-c", _FIRST_STEP, cold=cold))


def tournament(isolation: str) -> Subject:
    """Make a tournament of four scripted agents, each given as a file, from its command to its end.

    Its wall time is measured: nothing adds up the CPU time of processes that end with their namespaces.
    """
    folder = Path(catch_arena.__file__).parents[1] / "agents"
    files = [str(folder / f"{name}.py") for name in _AGENTS]
    words = ("-m", "catch_arena", "tournament", *files, isolation, "--rounds=6", "--seed=1", "--jobs=1")
    play = _process(*words)

    def wall_s() -> float:
        begun = time.perf_counter()
        play()
        return time.perf_counter() - begun

    return Subject(play, value=wall_s)


def _process(*words: str, cold: bool = False) -> Callable[[], str]:
    """Return a function that runs Python with these arguments in a new folder, and returns the output."""

    def step() -> str:
        folder = tempfile.mkdtemp()
        try:
            environment = {**os.environ, "NUMBA_CACHE_DIR": folder} if cold else os.environ
            done = subprocess.run(
                [sys.executable, *words], cwd=folder, env=environment, check=False, capture_output=True, text=True
            )
            if done.returncode:
                raise RuntimeError((done.stderr.strip().splitlines() or ["it failed, and printed no error"])[-1])
            return done.stdout
        finally:
            shutil.rmtree(folder)

    return step


def memory(envs: int) -> Subject:
    """Make a process that measures the memory which a batch of that size holds for each arena (Linux)."""
    measure = _process("-c", _MEMORY.format(envs=envs))
    return Subject(measure, value=lambda: float(measure()))
