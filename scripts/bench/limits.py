"""What a target that is missed comes up against: the parts of one arena's step, of a batch's memory and of a cold
start, and what this machine gains by a second thread at all.
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import ours

import catch_arena

CONTROLS = ("target", "velocity", "full")
_COMPILES = """
import json, time
from collections import Counter
import numba.core.event
spent, running = Counter(), []

class Passes(numba.core.event.Listener):
    def on_start(self, event):
        running.append([event.data["name"].partition(" [")[0], time.process_time(), 0.0])

    def on_end(self, event):
        name, begin, inner = running.pop()
        whole = time.process_time() - begin
        spent[name] += whole - inner
        if running:
            running[-1][2] += whole

numba.core.event.register("numba:run_pass", Passes())
import catch_arena
begin = time.process_time()
env = catch_arena.parallel_env()
env.reset(seed=1)
env.step(dict.fromkeys(env.agents, 1))
print(json.dumps({"passes": spent, "whole": time.process_time() - begin}))
"""
_EMIT = ("catch_arena_lower_whole",)
_TRANSLATE = ("catch_arena_lower_part", "catch_arena_lower_outlined")
_TYPE = ("nopython_type_inference",)


def limits(*, quick: bool) -> dict[str, Any]:
    """All of it: see the functions below."""
    return {
        "one_arena_us": one_arena(calls=20 if quick else 2000, rounds=3 if quick else 31),
        "memory_bytes": memory(40 if quick else 16384),
        "two_threads": two_threads(rounds=1 if quick else 9),
        **({} if quick else {"cold_cpu_s": cold()}),
    }


def one_arena(calls: int, rounds: int) -> dict[str, dict[str, float]]:
    """CPU-microseconds of one arena's step by control: whole, the engine's alone, and that of an env with nothing in
    it, which only makes PettingZoo's five dicts.
    """
    steps: dict[str, dict[str, Callable[[], object]]] = {
        control: {"whole": ours.one_arena(control).step, "engine": _engine_step(control), "five dicts": _null_step()}
        for control in CONTROLS
    }
    spent: dict[str, dict[str, list[float]]] = {control: {what: [] for what in steps[control]} for control in CONTROLS}
    for _ in range(rounds):
        for control in CONTROLS:
            for what, step in steps[control].items():
                begin = time.process_time()
                for _ in range(calls):
                    step()
                spent[control][what].append(1e6 * (time.process_time() - begin) / calls)
    return {
        control: {what: statistics.median(one) for what, one in by_what.items()} for control, by_what in spent.items()
    }


def _engine_step(control: str) -> Callable[[], object]:
    config = catch_arena.scenario("standard", control=control, max_cycles=10**6)
    engine = catch_arena.Engine(config)
    engine.reset([1])
    choices = np.full((1, config.hunters), control != "velocity", dtype=np.int64)
    commands = np.full((1, config.hunters, 2), (0.8, 0.3), dtype=np.float32)
    return lambda: engine.step(choices, commands)


def _null_step() -> Callable[[], object]:
    env = catch_arena.parallel_env("standard")
    agents = env.possible_agents
    seen = np.zeros((len(agents), *env.observation_space(agents[0]).shape), np.float32)
    rewards = np.zeros(len(agents))
    nobody, infos = dict.fromkeys(agents, False), {agent: {} for agent in agents}

    def step() -> tuple[dict[str, Any], ...]:
        observations = dict(zip(agents, seen.copy(), strict=True))
        return (
            observations,
            dict(zip(agents, rewards.tolist(), strict=True)),
            nobody.copy(),
            nobody.copy(),
            infos.copy(),
        )

    return step


def memory(envs: int) -> dict[str, float]:
    """Bytes an arena of a batch, by part."""
    engine = catch_arena.Engine(catch_arena.scenario("standard"), envs)
    parts = {
        "state": engine.blocks.nbytes / envs,
        "observations": engine.observations.nbytes / envs,
        "last observations of finished episodes": engine.observations.nbytes / envs,
        "masks, rewards, ends": (engine.masks.nbytes + engine.rewards.nbytes + engine.ends.nbytes) / envs,
    }
    whole = ours.bytes_of_an_arena(envs)
    return {**parts, "figures of episodes, and the rest": whole - sum(parts.values()), "whole": whole}


def two_threads(rounds: int) -> dict[str, float]:
    """How many times as fast two threads are as one, on the wall: at sines of numbers that fit a first cache, and at
    filling memory that fits none.
    """
    small = [np.linspace(0.0, 1.0, 1024) for _ in range(2)]
    large = [np.zeros(1 << 23) for _ in range(2)]
    work = {
        "numbers": (lambda part: [np.sin(small[part], out=small[part]) for _ in range(2000)]),
        "memory": (lambda part: [large[part].fill(1.0) for _ in range(4)]),
    }
    with ThreadPoolExecutor(2) as pool:
        for one in work.values():
            list(pool.map(one, range(2)))  # the memory is there from now on
        return {what: statistics.median(_gain(one, pool) for _ in range(rounds)) for what, one in work.items()}


def _gain(work: Callable[[int], object], pool: ThreadPoolExecutor) -> float:
    """Of both parts at once, beside one after the other."""
    begin = time.perf_counter()
    for part in range(2):
        work(part)
    between = time.perf_counter()
    list(pool.map(work, range(2)))
    return (between - begin) / (time.perf_counter() - between)


def cold() -> dict[str, float]:
    """CPU-seconds of a first step of one arena for which nothing is compiled yet, by what Numba does."""
    with tempfile.TemporaryDirectory() as cache:
        done = subprocess.run(
            [sys.executable, "-c", _COMPILES],
            env={**os.environ, "NUMBA_CACHE_DIR": cache},
            check=True,
            capture_output=True,
            text=True,
        )
    found = json.loads(done.stdout.splitlines()[-1])
    passes: Mapping[str, float] = found["passes"]

    def of(names: Sequence[str]) -> float:
        return sum(passes[name] for name in names)

    parts = {
        "LLVM optimises the whole and makes machine code": of(_EMIT),
        "functions are translated for LLVM": of(_TRANSLATE),
        "types are inferred": of(_TYPE),
    }
    parts["Numba's other passes"] = sum(passes.values()) - sum(parts.values())
    return {**parts, "between the passes, and the step": found["whole"] - sum(passes.values()), "whole": found["whole"]}
