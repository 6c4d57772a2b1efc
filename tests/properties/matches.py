"""Random matches for the property tests: settings, actions and incidents, all from one seeded source."""

import os
from random import Random
from typing import Any

import numpy as np
from numpy.typing import NDArray
from oracle.arithmetic import to_float32

from catch_arena.config import TURTLESIM_SIDE_M, ArenaConfig
from catch_arena.engine import Engine

EFFORT = 20 if os.environ.get("CATCH_ARENA_LONG") == "1" else 1
"""How many times as many matches are played when CATCH_ARENA_LONG=1."""

CONTROLS = ("target", "velocity", "full")


def some_config(source: Random) -> ArenaConfig:
    """Settings that can be, from all over their ranges; small arenas and long reaches so that much happens."""
    pick, chance = source.choice, source.random
    hunters = pick([1, 2, 2, 3, 3, 4, 4, 5, 6, 16])
    max_targets = pick([1, 2, 3, 5, 8, 13, 20])
    initial = source.randint(0, max_targets)
    side = pick([TURTLESIM_SIDE_M, TURTLESIM_SIDE_M, 2.0, 3.7, 16.0, 5000.0])
    settings: dict[str, Any] = {
        "hunters": hunters,
        "control": pick([*CONTROLS, tuple(pick(CONTROLS) for _ in range(hunters))]),
        "side_m": side,
        "max_speed_mps": pick([0.3, 2.0, 2.0, 7.3, 31.0, 1000.0]),
        "max_turn_rate_radps": pick([0.3, 4.0, 4.0, 18.8, 200.0, 1000.0]),
        "reverse": chance() < 0.4,
        "reach_m": pick([0.3, 0.3, 1.0, 0.2 * side, 2.0 * side, 1e-7]),
        "policy": pick(["nearest", "nearest", "nearest", "first_come", "capstone"]),
        "spawn_frequency_hz": pick([1.0, 0.5, 2.7, 9.0, 60.0, 777.0, 0.0]),
        "initial_targets": initial,
        "max_targets": max_targets,
        "target_budget": pick([None, None, None, max(1, initial), initial + 4]),
        "observed_targets": pick([None, source.randint(1, max_targets)]),
        "observed_hunters": pick([None, source.randint(0, hunters - 1)]),
        "control_period_ms": pick([16, 17, 100, 100, 100, 250, 999, 1000, 1001, source.randint(16, 1500)]),
        "time_limit_s": pick([60.0, 60.0, 1.0, 2.34567, 0.7]),
        "max_cycles": pick([None, None, None, 12]),
        "start_radius_m": pick([None, None, 0.0, 0.1 * side, side / 2]),
        "gains": pick(
            [
                {},
                {"ki_v": 0.0},
                {"kp_v": 1.3, "ki_v": 0.9, "kp_w": 3.1, "ki_w": 2.3},
                {"kp_v": 0.0, "ki_v": 30.0, "kp_w": 0.0, "ki_w": 40.0},
                {"kp_v": 0.0, "ki_v": 0.0, "kp_w": 0.0, "ki_w": 0.0},
            ]
        ),
        "rewards": pick(
            [
                {},
                {
                    name: source.uniform(-3, 3)
                    for name in ("catch", "rival_catch", "lost_contest", "rejected_request", "progress", "time")
                },
            ]
        ),
        "faults": pick(
            [
                {},
                {},
                {name: pick([0.0, 0.1, 0.5]) for name in ("kill_down", "kill_refused", "spawn_down", "spawn_refused")},
                {"spawn_refused": 1.0},
                {"kill_refused": 1.0},
            ]
        ),
    }
    if chance() < 0.3:
        settings["hunter_poses"] = tuple(some_pose(source, side) for _ in range(hunters))
    if chance() < 0.3:  # R2.7
        for name in ("max_speed_mps", "max_turn_rate_radps", "reach_m"):
            settings[name] = tuple(settings[name] * pick([0.2, 0.6, 1.0]) for _ in range(hunters))
    if chance() < 0.5:
        settings |= {
            "target_motion": pick(["wander", "flee", "flee"]),
            "target_speed_mps": pick([0.2, 1.0, 1.0, 5.0, 1000.0]),
            "target_turn_rate_radps": pick([0.1, 3.0, 3.0, 30.0, 1000.0]),
            "wander_period_ms": pick([1, 16, 100, 333, 1000, 10**9]),
            "alarm_m": pick([0.0, 2.0, 0.3 * side, 2.0 * side]),
        }
    if settings["policy"] != "capstone" and chance() < 0.4:
        settings |= {
            "view_radius_m": pick([None, 1e-7, 0.3 * side, 0.5 * side, 1.5 * side]),
            "view_angle_deg": pick([360.0, 360.0, 1e-3, 90.0, 180.0, 270.0, source.uniform(1, 359)]),
        }
    if chance() < 0.2:
        settings["view_noise_m"] = pick([1e-9, 0.1, 3.0])
    if chance() < 0.2:
        settings["dropout_rate"] = pick([0.01, 0.2, 1.0])
    return ArenaConfig().replace(**settings)


def some_pose(source: Random, side: float) -> tuple[float, float, float]:
    """Anywhere, or on a coarse grid with walls and corners, where distances tie."""
    if source.random() < 0.5:
        return (source.uniform(0, side), source.uniform(0, side), source.uniform(-7, 7))
    x, y = (side * source.randint(0, 4) / 4 for _ in range(2))
    return (x, y, source.choice([0.0, 0.0, 1.5707963267948966, 3.141592653589793, 100.0]))


def some_seed(source: Random) -> int:
    """Mostly any, sometimes the first or the last."""
    return source.choice([0, 2**64 - 1, source.getrandbits(64), source.getrandbits(64), source.getrandbits(64)])


def some_actions(source: Random, config: ArenaConfig, masks: list[list[int] | None]) -> list[Any]:
    """An action for each seat; most ranks have a target, some have none."""
    actions: list[Any] = []
    for control, mask in zip(config.controls, masks, strict=True):
        rank = 0
        if mask is not None:
            present = sum(mask) - 1
            rank = source.choice([0, 1, 1, source.randint(0, present), source.randint(0, config.targets_seen)])
            rank = min(rank, config.targets_seen)
        command = tuple(
            to_float32(source.choice([source.uniform(-1, 1), source.uniform(-1, 1), 1.0, -1.0, 0.0, -0.0]))
            for _ in range(2)
        )
        actions.append(rank if control == "target" else command if control == "velocity" else (command, rank))
    return actions


def some_batch_actions(
    source: Random, config: ArenaConfig, arenas: int
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Random choices and commands for every row."""
    generator = np.random.default_rng(source.getrandbits(64))
    shape = (arenas, config.hunters)
    choices = generator.integers(0, min(3, config.targets_seen) + 1, shape)
    return choices, generator.uniform(-1, 1, (*shape, 2)).astype(np.float32)


def seen(engine: Engine, row: int) -> list[object]:
    """Everything that one row hands out."""
    return [
        engine.state(row).tobytes(),
        engine.digest(row),
        engine.observations[row].tobytes(),
        engine.masks[row].tobytes(),
        engine.rewards[row].tobytes(),
        engine.parts[row].tobytes(),
        bool(engine.terminated[row]),
        bool(engine.truncated[row]),
        engine.rulings(row),
        engine.world(row),
    ]


def settings_of(config: ArenaConfig) -> str:
    """What differs from the standard, for a failing test's message."""
    standard, these = ArenaConfig().to_dict(), config.to_dict()
    return ", ".join(f"{name}={value!r}" for name, value in these.items() if value != standard[name])
