"""The numbers in docs/training.md: what it takes to keep a state, and how fast a learner's loop is.

The second part needs `pip install '.[sb3]'`, and is left out where that is missing.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import catch_arena
from catch_arena.errors import ConfigError

OPPONENTS = {"none: all learn": None, "nearest": "nearest", "patrol": "patrol", "both, drawn": ["nearest", "patrol"]}


@dataclass(frozen=True)
class Arguments:
    """What is measured."""

    arenas: int
    steps: int
    rounds: int
    torch_threads: int


def arguments() -> Arguments:
    """From the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arenas", type=int, default=256, help="arenas of four hunters")
    parser.add_argument("--steps", type=int, default=64, help="steps of a rollout")
    parser.add_argument("--rounds", type=int, default=5, help="the best of so many is told")
    parser.add_argument("--torch-threads", type=int, default=2)
    return Arguments(**vars(parser.parse_args()))


def best_us(call: Callable[[], object], rounds: int) -> float:
    """The best of many short rounds [us a call]: a busy machine holds up most of the long ones."""
    call()
    found = []
    for _ in range(200 * rounds):
        began = time.perf_counter()
        for _ in range(20):
            call()
        found.append((time.perf_counter() - began) / 20 * 1e6)
    return min(found)


def measure_keeping(rounds: int) -> None:
    """One arena, by both interfaces."""
    env, batch = catch_arena.parallel_env(), catch_arena.VectorArena(num_envs=1)
    env.reset(seed=1)
    batch.reset(seed=1)
    many = catch_arena.VectorArena(num_envs=1024)
    many.reset(seed=1)
    print("| what | save [us] | restore [us] | clone [us] |\n|---|---:|---:|---:|")
    for name, arena in (("`parallel_env`", env), ("`VectorArena`, one arena", batch)):
        saved = arena.save()
        times = [best_us(call, rounds) for call in (arena.save, lambda a=arena, s=saved: a.restore(s), arena.clone)]
        print(f"| {name} | {' | '.join(f'{each:.0f}' for each in times)} |")
    row = many.save_row(700)
    times = [best_us(call, rounds) for call in (lambda: many.save_row(700), lambda: many.restore_row(700, row))]
    print(f"| a row of 1024 arenas | {' | '.join(f'{each:.0f}' for each in times)} | |\n")


def measure_loops(given: Arguments) -> None:
    """stable-baselines3's loop: what its policy and buffer take, and the gradient steps too."""
    import torch
    from sb3_contrib import MaskablePPO
    from stable_baselines3 import PPO

    from catch_arena.training import LearnerBatch, SB3VecEnv

    torch.set_num_threads(given.torch_threads)
    print("| opponents | the batch alone | PPO, rollouts | PPO, with learning | MaskablePPO, with learning |")
    print("|---|---:|---:|---:|---:|")
    for name, opponents in OPPONENTS.items():
        settings = {"opponents": opponents, "normalise": True}
        batch = LearnerBatch("standard", given.arenas, **settings)
        batch.reset(1)
        hold = np.ones(batch.num_rows, dtype=np.int64)
        agent_steps = given.arenas * batch.config.hunters * given.steps

        def alone(batch: LearnerBatch = batch, hold: np.ndarray = hold) -> None:
            for _ in range(given.steps):
                batch.step(hold)

        speeds = [agent_steps / best_s(alone, given.rounds)]
        for kind, epochs in ((PPO, 0), (PPO, 4), (MaskablePPO, 4)):
            env = SB3VecEnv("standard", given.arenas, **settings)
            rows = env.num_envs * given.steps
            sizes = {"n_steps": given.steps, "batch_size": rows // 4, "n_epochs": max(1, epochs)}
            model = kind("MlpPolicy", env, seed=1, **sizes)
            if not epochs:
                model.train = lambda: None
            speeds.append(agent_steps / best_s(lambda model=model, rows=rows: model.learn(rows), given.rounds))
        print(f"| {name} | {' | '.join(f'{speed:,.0f}' for speed in speeds)} |", flush=True)


def best_s(call: Callable[[], object], rounds: int) -> float:
    """The best of some rounds [s]."""
    call()
    found = []
    for _ in range(rounds):
        began = time.perf_counter()
        call()
        found.append(time.perf_counter() - began)
    return min(found)


if __name__ == "__main__":
    wanted = arguments()
    measure_keeping(wanted.rounds)
    try:
        measure_loops(wanted)
    except (ConfigError, ModuleNotFoundError) as error:
        print(f"the learner's loop is left out: {error}")
