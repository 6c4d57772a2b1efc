"""Recorded matches, as fixtures for the tests of replays and of explanations."""

from collections.abc import Callable
from random import Random

import pytest

import catch_arena
from catch_arena import ArenaService, Ruling
from catch_arena.messages import CatchTurtleRequest, Twist
from catch_arena.replay import Replay

ODD_NAMES = ("x", "", "target_turtle_999", "target_turtle_01", "target_turtle_1\n", "y" * 300, "\ud800", 7)
"""Names that hunters ask for besides those of targets."""


@pytest.fixture(scope="session")
def play() -> Callable[..., Replay]:
    """Plays a match of random actions, or with `chase` one in which every hunter chases the nearest target; whoever is
    in `withdraw`, a mapping of steps to agents, leaves.
    """

    def played(scenario="standard", *, seed=1, names=None, title="", chase=False, withdraw=None, **overrides) -> Replay:
        env = catch_arena.parallel_env(scenario, **overrides)
        env.record(names, title)
        env.reset(seed=seed)
        for index, agent in enumerate(env.possible_agents):
            env.action_space(agent).seed(index)
        while env.agents:
            for agent in (withdraw or {}).get(env.world().step, ()):
                env.withdraw(agent)
            env.step(
                {
                    agent: 1 if chase and agent.startswith("hunter") else env.action_space(agent).sample()
                    for agent in env.agents
                }
            )
        return env.replay()

    return played


@pytest.fixture(scope="session")
def mixed(play) -> Replay:
    """Every kind of control, every fault, and a withdrawal."""
    return play(
        "faulty",
        seed=6,
        control=("target", "velocity", "full", "target"),
        max_cycles=80,
        names=("a", "b", "c", "d"),
        title="a test",
        withdraw={39: ["hunter_2"]},
    )


@pytest.fixture(scope="session")
def fleeing(play) -> Replay:
    """Targets that flee, hunters that see a part, are not equal and drop out, and two kinds of control."""
    return play(
        seed=4,
        target_motion="flee",
        control=("target", "full", "target", "velocity"),
        view_radius_m=3.0,
        view_angle_deg=120.0,
        max_speed_mps=(2.0, 3.0, 1.5, 2.5),
        reach_m=(0.3, 0.5, 0.4, 0.9),
        dropout_rate=0.005,
        max_cycles=120,
        names=("a", "b", "c", "d"),
    )


@pytest.fixture(scope="session")
def hunted(play) -> Replay:
    """Two teams, prey that returns beside targets that wander, and a withdrawal on each side."""
    return play(
        seed=6,
        teams=((0, 2), (1, 3)),
        prey=3,
        initial_targets=4,
        spawn_frequency_hz=0.5,
        prey_returns_s=0.7,
        target_motion="wander",
        reach_m=0.8,
        chase=True,
        max_cycles=150,
        names=("a", "b", "a", "c", "p", "q", "p"),
        title="hunted",
        withdraw={60: ["hunter_3"], 90: ["prey_1"]},
    )


@pytest.fixture(scope="session")
def hunted_once(play) -> Replay:
    """Prey that may drive backwards and does not return, hunters of every control, and no other targets."""
    return play(
        seed=8,
        prey=4,
        initial_targets=4,
        spawning=False,
        prey_returns_s=None,
        reverse=True,
        control=("velocity", "full", "target", "velocity"),
        reach_m=1.2,
        max_cycles=200,
    )


def play_by_name(seed: int) -> tuple[Replay, list[list[Ruling]]]:
    """A match in which hunters ask for all that can be asked for by name, several times in a step, with faults,
    dropouts, a withdrawal and a partial view; and what was answered in each step, where nobody but they asked.
    """
    source = Random(seed)
    service = ArenaService(
        "faulty",
        hunters=3,
        control=("full", "velocity", "full"),
        control_period_ms=16,
        time_limit_s=4,
        reach_m=(3.0, 1e-6, 2.0),
        dropout_rate=0.001,
        initial_targets=5,
        view_angle_deg=source.choice([360.0, 90.0]),
        policy=source.choice(["nearest", "first_come"]),
    )
    service.record(("a", "b", "c"))
    service.reset(seed)
    met: dict[str, None] = {}
    rulings = []
    while not service.over:
        met |= dict.fromkeys(target.name for target in service.world.targets)
        names = [*met, *ODD_NAMES]
        requests = [
            (source.choice(["hunter_0", "hunter_2"]), CatchTurtleRequest(source.choice(names)))
            for _ in range(source.choice([0, 0, 1, 2, 5]))
        ]
        if service.world.step == 200:
            service.withdraw("hunter_2")
        twists = {f"hunter_{seat}": Twist(source.uniform(0, 2), source.uniform(-4, 4)) for seat in range(3)}
        rulings.append(service.step(twists, requests))
    return service.replay, rulings


@pytest.fixture(scope="session")
def named() -> Replay:
    """A match of hunters that ask by name."""
    replay, _ = play_by_name(1)
    return replay
