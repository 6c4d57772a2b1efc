"""Measure the speed of Catch Arena beside a peer, in one run on one machine, and print medians and ratios.

Rounds of ours and the peer alternate, so that a busy machine slows both. Start-up is measured in fresh processes.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

ROUNDS = 7
SECONDS = 1.0


def steps_per_second(step: Callable[[], None]) -> float:
    """How often `step` runs per CPU-second, over about SECONDS."""
    count, begin = 0, time.process_time()
    while (spent := time.process_time() - begin) < SECONDS:
        for _ in range(50):
            step()
        count += 50
    return count / spent


def our_stepper(control: str) -> Callable[[], None]:
    """One step of the one-arena env, 4 hunters, with a new episode where one ends."""
    import catch_arena

    env = catch_arena.parallel_env("standard", control=control)
    env.reset(seed=1)
    actions = {agent: env.action_space(agent).sample() for agent in env.possible_agents}
    if control == "target":
        actions = dict.fromkeys(env.possible_agents, 1)

    def step() -> None:
        env.step(actions)
        if not env.agents:
            env.reset()

    return step


def mpe2_stepper() -> Callable[[], None]:
    """One step of mpe2's simple_tag_v3, parallel API: 4 agents, no arbiter."""
    from mpe2 import simple_tag_v3

    env = simple_tag_v3.parallel_env(max_cycles=600)
    env.reset(seed=1)
    actions = dict.fromkeys(env.agents, 1)

    def step() -> None:
        env.step(actions)
        if not env.agents:
            env.reset()

    return step


def seconds_to_first_step(cache: str) -> float:
    """From the start of a process to the end of its first step."""
    code = "import catch_arena as c; env = c.parallel_env(); env.reset(seed=1); env.step(dict.fromkeys(env.agents, 1))"
    begin = time.perf_counter()
    subprocess.run(
        [sys.executable, "-c", code],
        check=True,
        env={**os.environ, "NUMBA_CACHE_DIR": cache},
        stderr=subprocess.DEVNULL,
    )
    return time.perf_counter() - begin


def seconds_to_import(module: str) -> float:
    """What an import adds to a bare interpreter."""

    def run(code: str) -> float:
        begin = time.perf_counter()
        subprocess.run([sys.executable, "-c", code], check=True)
        return time.perf_counter() - begin

    with_it, without = [], []
    for _ in range(5):
        with_it.append(run(f"import {module}"))
        without.append(run("pass"))
    return statistics.median(with_it) - statistics.median(without)


def main() -> None:
    """Measure, print a table, and write JSON where that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, help="also write the figures to this file")
    arguments = parser.parse_args()
    figures: dict[str, float] = {"import_s": seconds_to_import("catch_arena")}
    with tempfile.TemporaryDirectory() as cache:
        figures["first_step_cold_s"] = seconds_to_first_step(cache)
        figures["first_step_warm_s"] = statistics.median(seconds_to_first_step(cache) for _ in range(5))
    steppers = {f"one arena, {control}": our_stepper(control) for control in ("target", "velocity", "full")}
    try:
        steppers["mpe2 simple_tag_v3"] = mpe2_stepper()
    except ImportError:
        print("mpe2 simple_tag_v3: skipped, not installed")
    rounds: dict[str, list[float]] = {name: [] for name in steppers}
    for _ in range(ROUNDS):
        for name, stepper in steppers.items():
            rounds[name].append(steps_per_second(stepper))
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    print(f"import of catch_arena        {figures['import_s']:8.3f} s")
    print(f"first step, cold cache       {figures['first_step_cold_s']:8.2f} s")
    print(f"first step, warm cache       {figures['first_step_warm_s']:8.2f} s")
    peer = statistics.median(rounds.get("mpe2 simple_tag_v3", [float("nan")]))
    for name, measured in rounds.items():
        median = figures[name] = statistics.median(measured)
        print(f"{name:28} {median:8,.0f} env-steps per CPU-second, {median / peer:6.1f} times mpe2")
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
