"""Every setting is read, and every column is written: one that is declared and left alone fails here."""

import dataclasses
import re
from collections.abc import Callable
from random import Random
from typing import Any, get_args

import numpy as np
import pytest
from properties.matches import some_config

import catch_arena
from catch_arena.config import ArenaConfig, FaultRates, Gains, PreyRewardWeights, RewardWeights, TargetMotion
from catch_arena.layout import (
    columns,
    prey_columns,
    state_columns,
)

RICH = ArenaConfig(
    hunters=3,
    control=("target", "full", "velocity"),
    side_m=5.0,
    max_speed_mps=(2.0, 1.8, 1.6),
    reach_m=(1.2, 1.1, 1.0),
    teams=((0, 2), (1,)),
    team_share=0.4,
    spawn_frequency_hz=4.0,
    initial_targets=4,
    max_targets=6,
    target_motion="flee",
    wander_period_ms=300,
    alarm_m=1.5,
    prey=2,
    prey_returns_s=0.5,
    view_radius_m=3.0,
    view_angle_deg=300.0,
    view_noise_m=0.05,
    time_limit_s=6.0,
    dropout_rate=0.004,
    gains=Gains(ki_v=0.5, ki_w=0.5),
    rewards=RewardWeights(
        rival_catch=-0.5, lost_contest=-0.1, rejected_request=-0.2, progress=0.3, time=-0.01, mate_catch=0.2
    ),
    prey_rewards=PreyRewardWeights(survived=0.1, gained=0.2),
    faults=FaultRates(kill_down=0.1, kill_refused=0.1, spawn_down=0.2, spawn_refused=0.2),
)
"""An arena in which every setting matters."""
OTHERWISE: dict[str, Any] = {
    "hunters": 2,
    "control": ("target", "full", "full"),
    "side_m": 5.5,
    "hunter_poses": ((1.0, 1.0, 0.0), (2.0, 2.0, 1.0), (3.0, 3.0, 2.0)),
    "start_radius_m": 1.0,
    "max_speed_mps": (2.0, 1.8, 1.7),
    "max_turn_rate_radps": 3.5,
    "reverse": True,
    "reach_m": (1.2, 1.1, 0.6),
    "policy": "first_come",
    "hunters_per_catch": 2,
    "teams": ((0, 1), (2,)),
    "team_share": 0.6,
    "spawning": False,
    "spawn_frequency_hz": 3.0,
    "initial_targets": 3,
    "max_targets": 4,
    "target_budget": 5,
    "target_motion": "wander",
    "target_speed_mps": 0.9,
    "target_turn_rate_radps": 2.0,
    "wander_period_ms": 400,
    "alarm_m": 1.0,
    "prey": 1,
    "prey_returns_s": None,
    "name_prefix": "turtle_",
    "observed_targets": 2,
    "observed_hunters": 1,
    "view_radius_m": 2.0,
    "view_angle_deg": 200.0,
    "view_noise_m": 0.1,
    "mask_in_observation": True,
    "control_period_ms": 90,
    "time_limit_s": 3.0,
    "max_cycles": 20,
    "dropout_rate": 0.05,
    "dropouts": "fixed",
    "gains": {field.name: 0.7 for field in dataclasses.fields(Gains)},
    "rewards": {field.name: -0.7 for field in dataclasses.fields(RewardWeights)},
    "prey_rewards": {field.name: -0.7 for field in dataclasses.fields(PreyRewardWeights)},
    "faults": {field.name: 0.6 for field in dataclasses.fields(FaultRates)},
}
"""Another value for each setting; of those that have parts, for each part."""
CHANGES = [
    pytest.param({name: {part: other}} if part else {name: other}, id=f"{name}.{part}" if part else name)
    for name, value in OTHERWISE.items()
    if name not in ("hunters", "target_budget")
    for part, other in (value.items() if isinstance(value, dict) else [("", value)])
]
OF_ENVS = {"name_prefix", "mask_in_observation", "dropouts"}
"""Settings that the arena itself does not read: names, and settings of PettingZoo's envs."""


def transcript(config: ArenaConfig) -> list[object]:
    """All that the env hands out in a match, of two seeds."""
    env = catch_arena.parallel_env(config)
    results: list[object] = []
    for seed in range(2):
        observations, infos = env.reset(seed=seed)
        source = Random(seed)
        while env.agents:
            actions = {agent: some_action(source, config, agent, infos[agent]) for agent in env.agents}
            observations, rewards, terminations, truncations, infos = env.step(actions)
            results.append((repr(observations), rewards, terminations, truncations, env.world(), env.digest()))
    return results


def some_action(source: Random, config: ArenaConfig, agent: str, info: Any) -> Any:
    """The nearest target, for whoever can name it; any velocity."""
    control = config.controls[int(agent.removeprefix("hunter_"))] if agent.startswith("hunter") else "velocity"
    command = np.array([source.uniform(-0.5, 1.0), source.uniform(-1.0, 1.0)], dtype=np.float32)
    if control == "velocity":
        return command
    mask = info["action_mask"]
    return int(mask[1]) if control == "target" else {"cmd_vel": command, "catch": int(mask[1])}


@pytest.fixture(scope="module")
def rich() -> list[object]:
    return transcript(RICH)


def test_the_number_of_hunters_is_read(rich):
    """By itself: what stands by seat has to go with it."""
    fewer = {name: getattr(RICH, name)[:2] for name in ("control", "max_speed_mps", "reach_m")} | {"teams": None}
    assert transcript(RICH.replace(hunters=OTHERWISE["hunters"], **fewer)) != rich


def test_the_target_budget_is_read():
    """Without prey, which needs it to be None."""
    without = RICH.replace(prey=0)
    assert transcript(without.replace(target_budget=OTHERWISE["target_budget"])) != transcript(without)


def test_every_setting_has_another_value_here():
    assert set(OTHERWISE) == {field.name for field in dataclasses.fields(ArenaConfig)}


@pytest.mark.parametrize("change", CHANGES)
def test_a_setting_is_read(rich, change):
    """With another value another match is played, or the env shows it another way."""
    assert transcript(RICH.replace(**change)) != rich


def test_the_random_matches_draw_every_setting_of_the_arena():
    """Else nobody would see that oracle and engine read one of them differently."""
    configs = [some_config(Random(seed)) for seed in range(150)]
    constant = {
        field.name
        for field in dataclasses.fields(ArenaConfig)
        if len({repr(getattr(config, field.name)) for config in configs}) == 1
    }
    assert constant == OF_ENVS


@pytest.mark.parametrize("motion", get_args(TargetMotion))
def test_every_column_is_written(motion):
    """A column takes more than one value in a match: one that is declared and left alone would stay zero."""
    config = RICH.replace(target_motion=motion, dropout_rate=0.01)
    env = catch_arena.parallel_env(config)
    seen: dict[str, set[float]] = {}
    seen_by_prey: dict[str, set[float]] = {}
    state: dict[str, set[float]] = {}
    for seed in range(4):
        observations, infos = env.reset(seed=seed)
        source = Random(seed)
        while env.agents:
            actions = {agent: some_action(source, config, agent, infos[agent]) for agent in env.agents}
            observations, *_, infos = env.step(actions)
            for agent, observation in observations.items():
                of_prey = agent.startswith("prey")
                note(seen_by_prey if of_prey else seen, (prey_columns if of_prey else columns)(config), observation)
            note(state, state_columns(config), env.state())
            if env.world().step == 30 and "prey_0" in env.agents:
                env.withdraw("prey_0")
    assert [name for kind in (seen, seen_by_prey, state) for name, values in kind.items() if len(values) < 2] == []


def note(values: dict[str, set[float]], table: Any, numbers: Any) -> None:
    """By the column's name without its rank, seat or place."""
    plain: Callable[[str], str] = lambda name: re.sub(r"_\d+\.", ".", name)  # noqa: E731
    for column, number in zip(table, numbers.tolist(), strict=True):
        values.setdefault(plain(column.name), set()).add(number)
