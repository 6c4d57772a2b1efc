"""Random matches for the property tests: settings, actions and incidents, all from one seeded source."""

import os
from collections.abc import Sequence
from random import Random
from typing import Any

import numpy as np
from numpy.typing import NDArray
from oracle.arena import PART_NAMES, PREY_PART_NAMES, Command, OracleArena, Pose
from oracle.arithmetic import to_float32

from catch_arena.config import TURTLESIM_SIDE_M, ArenaConfig
from catch_arena.engine import Engine

EFFORT = 20 if os.environ.get("CATCH_ARENA_LONG") == "1" else 1
"""Factor on the number of matches when CATCH_ARENA_LONG=1."""

CONTROLS = ("target", "velocity", "full")


def some_config(source: Random) -> ArenaConfig:
    """Settings that can be, from all over their ranges; small arenas and long reaches so that much happens."""
    pick, chance = source.choice, source.random
    hunters = pick([1, 2, 2, 3, 3, 4, 4, 5, 6, 8, 9, 9, 16])
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
                {name: source.uniform(-3, 3) for name in PART_NAMES},
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
    if chance() < 0.2:
        settings["spawning"] = False
    if chance() < 0.3:  # no options: the core has code of its own for that
        return ArenaConfig().replace(**settings)
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
    if chance() < 0.4:
        settings |= {"teams": some_teams(source, hunters), "team_share": pick([0.0, 0.3, 1.0, chance()])}
        if settings["policy"] != "capstone" and chance() < 0.6:
            settings["hunters_per_catch"] = source.randint(1, min(3, max(map(len, settings["teams"]))))
    if initial and chance() < 0.5:
        settings |= {
            "prey": pick([1, source.randint(1, initial), source.randint(1, initial), initial]),
            "prey_returns_s": pick([None, None, 0.0, 0.05, 0.1, 0.34567, 2.0, 1e9]),
            "prey_rewards": pick([{}, {name: source.uniform(-3, 3) for name in PREY_PART_NAMES}]),
            "target_budget": None,
            "target_speed_mps": pick([0.2, 1.0, 5.0, 1000.0]),
            "target_turn_rate_radps": pick([0.1, 3.0, 1000.0]),
        }
        if settings["prey_returns_s"] is None and chance() < 0.5:  # the episode can end
            settings |= {"initial_targets": settings["prey"], "spawning": False}
    return ArenaConfig().replace(**settings)


def some_teams(source: Random, hunters: int) -> tuple[tuple[int, ...], ...]:
    """Each seat in one of them, in any order; now and then all in one, or each in one of its own."""
    seats = source.sample(range(hunters), hunters)
    count = source.choice([1, 2, 2, 2, 3, hunters])
    teams: list[list[int]] = [[] for _ in range(count)]
    for place, seat in enumerate(seats):
        teams[place if place < count else source.randrange(count)].append(seat)
    return tuple(tuple(team) for team in teams if team)


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
        command = some_command(source)
        actions.append(rank if control == "target" else command if control == "velocity" else (command, rank))
    return actions


def some_command(source: Random) -> Command:
    """A hunter's velocities, or prey's: any, at the limits, or none."""
    v, w = (
        to_float32(source.choice([source.uniform(-1, 1), source.uniform(-1, 1), 1.0, -1.0, 0.0, -0.0]))
        for _ in range(2)
    )
    return v, w


def some_prey_actions(source: Random, config: ArenaConfig) -> list[Command]:
    """An action for each prey."""
    return [some_command(source) for _ in range(config.prey)]


Position = tuple[list[Pose], list[tuple[float, float]], list[Pose]]


def some_position(source: Random, oracle: OracleArena) -> Position:
    """Arguments of `place`: poses of the hunters, places of as many targets as there is room for beside prey, and poses
    of prey; some of them just where a hunter is.
    """
    in_play = sum(prey.target is not None for prey in oracle.prey)
    room: int = oracle.settings["max_targets"] - in_play
    hunters = [some_pose(source, oracle.side) for _ in oracle.hunters]

    def some() -> Pose:
        return source.choice(hunters) if source.random() < 0.1 else some_pose(source, oracle.side)

    return hunters, [some()[:2] for _ in range(source.randint(0, room))], [some() for _ in oracle.prey]


def some_batch_actions(
    source: Random, config: ArenaConfig, arenas: int
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Random choices and commands for every row."""
    generator = np.random.default_rng(source.getrandbits(64))
    shape = (arenas, config.hunters)
    choices = generator.integers(0, min(3, config.targets_seen) + 1, shape)
    of_hunters, of_prey = (
        generator.uniform(-1, 1, (arenas, count, 2)).astype(np.float32) for count in (config.hunters, config.prey)
    )
    return choices, np.concatenate((of_hunters, of_prey), axis=1)


def begun(config: ArenaConfig, seeds: Sequence[int], **options: bool) -> tuple[Engine, list[OracleArena]]:
    """A batch after its reset, and an oracle for each row."""
    batch, oracles = Engine(config, len(seeds), **options), [OracleArena(config.to_dict()) for _ in seeds]
    batch.reset(seeds)
    for oracle, seed in zip(oracles, seeds, strict=True):
        oracle.reset(seed)
    return batch, oracles


def seen(engine: Engine, row: int) -> dict[str, object]:
    """Everything that one row hands out."""
    return {
        "state": engine.state(row).tobytes(),
        "digest": engine.digest(row),
        "observations": engine.observations[row].tobytes(),
        "masks": engine.masks[row].tobytes(),
        "rewards": engine.rewards[row].tobytes(),
        "parts": engine.parts[row].tobytes(),
        "ends": int(engine.ends[row]),
        "prey_parts": engine.prey_parts[row].tobytes(),
        "rulings": engine.world(row).rulings,
        "world": engine.world(row),
    }


def settings_of(config: ArenaConfig) -> str:
    """Settings that differ from the standard, for a failing test's message."""
    standard, these = ArenaConfig().to_dict(), config.to_dict()
    return ", ".join(f"{name}={value!r}" for name, value in these.items() if value != standard[name])
