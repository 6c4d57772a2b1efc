"""Measure `tag` beside mpe2's simple_tag, for docs/simple_tag.md: `python scripts/measure_simple_tag.py`.

Steps a CPU second are those of the environments alone, with fixed actions, in turn. Scores are of policies that are the
same in both: pursuers choose at random, or go straight for the prey; prey does so too, or goes straight away from the
nearest pursuer. mpe2 counts touches, in each step one for every pursuer that touches the prey; ours counts catches.
mpe2 is in the extra `bench`.
"""

import argparse
import math
import platform
import statistics
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from random import Random
from typing import Any

import numpy as np

from catch_arena import PreyLimits, PreyView, VectorArena, parallel_env
from catch_arena.agents.flee import steer
from catch_arena.agents.patrol import drive
from catch_arena.errors import install_hint
from catch_arena.policy import Limits, View

BATCH = 1024
TOUCH = 10.0
"""What simple_tag pays every pursuer for each touch."""

Vector = tuple[float, float]


def mpe2_action(direction: Vector) -> int:
    """The push along the axis that is the longer: left, right, down or up."""
    x, y = direction
    return (2 if x > 0 else 1) if abs(x) >= abs(y) else (4 if y > 0 else 3)


def mpe2_choice(agent: str, seen: Any, *, chases: bool, flees: bool, random: Random) -> int:
    """An agent's action: its observation has two velocities, its place, 2 landmarks, and then the others' places."""
    others = [(float(seen[at]), float(seen[at + 1])) for at in (8, 10, 12)]
    if agent.startswith("adversary"):
        return mpe2_action(others[-1]) if chases else random.randrange(5)
    x, y = min(others, key=lambda other: math.hypot(*other))
    return mpe2_action((-x, -y)) if flees else random.randrange(5)


def play_mpe2(episodes: int, *, chases: bool, flees: bool) -> float:
    """Touches in 100 steps."""
    from mpe2 import simple_tag_v3

    env, random = simple_tag_v3.parallel_env(), Random(1)
    touches = steps = 0.0
    for seed in range(episodes):
        observations, _ = env.reset(seed=seed)
        while env.agents:
            actions = {
                agent: mpe2_choice(agent, observations[agent], chases=chases, flees=flees, random=random)
                for agent in env.agents
            }
            observations, rewards, *_ = env.step(actions)
            touches += rewards["adversary_0"] / TOUCH  # all pursuers are paid alike
            steps += 1
    return 100 * touches / steps


def our_choice(view: View | PreyView, *, chases: bool, flees: bool, random: Random) -> Vector:
    """An agent's action."""
    if isinstance(view, View):
        if not chases:
            return random.random(), random.uniform(-1.0, 1.0)
        return drive(view.targets[0].forward, view.targets[0].left, view) if view.targets else (0.0, 0.0)
    if not flees:
        return random.random(), random.uniform(-1.0, 1.0)
    nearest = view.hunters[0] if view.hunters else None
    return (0.0, 0.0) if nearest is None else steer(math.remainder(nearest.bearing + math.pi, math.tau), view)


def play_ours(episodes: int, *, chases: bool, flees: bool) -> float:
    """Catches in 100 steps."""
    env, random = parallel_env("tag"), Random(1)
    limits = {agent: Limits.of(env.config) for agent in env.possible_agents}
    limits |= {agent: PreyLimits.of(env.config) for agent in env.config.prey_names}
    catches = steps = 0
    for seed in range(episodes):
        observations, _ = env.reset(seed=seed)
        while env.agents:
            views = {agent: limits[agent].view(observations[agent].tolist(), ()) for agent in env.agents}
            observations, *_ = env.step(
                {agent: our_choice(view, chases=chases, flees=flees, random=random) for agent, view in views.items()}
            )
        world = env.world()
        catches += sum(hunter.score for hunter in world.hunters)
        steps += world.step
    return 100 * catches / steps


def stepper_of_mpe2() -> Callable[[], int]:
    """Steps simple_tag once, and says how many steps that was."""
    from mpe2 import simple_tag_v3

    env = simple_tag_v3.parallel_env(max_cycles=600)
    env.reset(seed=1)
    actions = dict.fromkeys(env.agents, 1)

    def step() -> int:
        env.step(actions)
        if not env.agents:
            env.reset()
        return 1

    return step


def stepper_of_ours() -> Callable[[], int]:
    """The same of `tag`."""
    env = parallel_env("tag")
    env.reset(seed=1)
    actions = dict.fromkeys(env.agents, (1.0, 0.5))

    def step() -> int:
        env.step(actions)
        if not env.agents:
            env.reset()
        return 1

    return step


def stepper_of_batch() -> Callable[[], int]:
    """The same of a batch of them, on one thread."""
    arena = VectorArena("tag", BATCH, num_threads=1)
    arena.reset(seed=1)
    commands = np.full((BATCH, 4, 2), 0.5, dtype=np.float32)

    def step() -> int:
        arena.step(commands=commands)
        return BATCH

    return step


def steps_a_cpu_second(step: Callable[[], int], seconds: float) -> float:
    """How many, for so long: in this process's own time, whatever else the machine does."""
    begin, steps = time.process_time(), 0
    while (now := time.process_time()) < begin + seconds:
        steps += step()
    return steps / (now - begin)


def main() -> int:
    """The exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="how often each is timed, in turn")
    parser.add_argument("--seconds", type=float, default=1.0, help="of CPU time, for how long")
    parser.add_argument("--steps", type=int, default=12_000, help="that each pair of policies plays")
    args = parser.parse_args()
    try:
        steppers = [stepper_of_mpe2(), stepper_of_ours(), stepper_of_batch()]
    except ImportError as error:
        print(f"mpe2 must be installed: {install_hint('bench')}: {error}", file=sys.stderr)
        return 2
    for step in steppers:  # loads and compiles
        step()
    rounds = [[steps_a_cpu_second(step, args.seconds) for step in steppers] for _ in range(args.rounds)]
    mpe2, ours, batch = (statistics.median(times) for times in zip(*rounds, strict=True))
    print("| | mpe2 `simple_tag_v3` | `tag` |\n|---|---|---|")
    print(f"| steps a CPU second, one environment | {mpe2:,.0f} | {ours:,.0f} |")
    print(f"| steps a CPU second, a batch of {BATCH:,}, one thread | – | {batch:,.0f} |")
    for chases, flees in ((False, False), (False, True), (True, False), (True, True)):
        pair = f"pursuers {'chase' if chases else 'at random'}, prey {'flees' if flees else 'at random'}"
        theirs = play_mpe2(max(1, args.steps // 25), chases=chases, flees=flees)
        caught = play_ours(max(1, args.steps // 600), chases=chases, flees=flees)
        print(f"| {pair}: in 100 steps | {theirs:.2f} touches | {caught:.2f} catches |")
    words = " ".join(f"{name} {version(name)}" for name in ("mpe2", "pettingzoo", "numpy", "numba"))
    print(f"\n{platform.machine()}, Python {platform.python_version()}, {words}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
