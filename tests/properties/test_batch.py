"""A row of a batch is the arena that it would be alone.

That one thread plays what many play stands in tests/vector.
"""

from collections.abc import Mapping
from random import Random
from typing import Any

import numpy as np
import pytest
from oracle.arithmetic import ROW_SEED, draw, key
from properties.matches import EFFORT, seen, settings_of, some_batch_actions, some_config, some_pose, some_seed

from catch_arena.config import ArenaConfig, FaultRates, RewardWeights
from catch_arena.core.state import ALL_OPTIONS
from catch_arena.core.vectors import HALF, WIDE, Width
from catch_arena.engine import Engine
from catch_arena.engine.episode_seeds import batch_seeds

FIRST_SEED = 70
STEPS = 20

NAMES = (
    "state",
    "digest",
    "observations",
    "masks",
    "rewards",
    "parts",
    "ends",
    "prey_parts",
    "rulings",
    "world",
)


def assert_rows_same(batch: Engine, row: int, other: Engine, other_row: int, where: str) -> None:
    for name, one, two in zip(NAMES, seen(batch, row), seen(other, other_row), strict=True):
        assert one == two, f"{name} differ: {where}"


@pytest.mark.parametrize("arenas", [1, 7, 33, 70])
def test_a_row_of_a_batch_equals_an_arena_alone(arenas: int) -> None:
    """Every row of batches below, at and above the chunks' sizes; rows end, are withdrawn from and are placed apart."""
    for match in range(2 * EFFORT):
        source = Random(FIRST_SEED * arenas + match)
        config = some_config(source)
        seeds = [some_seed(source) for _ in range(arenas)]
        batch = Engine(config, arenas)
        batch.reset(seeds)
        alone = [Engine(config) for _ in seeds]
        for engine, seed in zip(alone, seeds, strict=True):
            engine.reset([seed])
        for step in range(STEPS):
            where = f"step {step}, match {match} of {arenas} arenas, {settings_of(config)}"
            if step % 6 == 3:
                row, seat = source.randrange(arenas), source.randrange(config.hunters)
                batch.withdraw(row, seat)
                alone[row].withdraw(0, seat)
                if config.prey:
                    index = source.randrange(config.prey)
                    batch.withdraw(row, config.hunters + index)
                    alone[row].withdraw(0, config.hunters + index)
            if step % 7 == 4:
                row = source.randrange(arenas)
                hunters = [some_pose(source, config.side_m) for _ in range(config.hunters)]
                targets = [(1.0, 1.0)] if config.prey < config.max_targets else []
                batch.place(row, hunters, targets)
                alone[row].place(0, hunters, targets)
            actions = some_batch_actions(source, config, arenas)
            batch.step(*actions)
            for row, engine in enumerate(alone):
                engine.step(*(given[row : row + 1] for given in actions))
                assert_rows_same(batch, row, engine, 0, f"row {row}, {where}")


@pytest.mark.parametrize("arenas", [1, 33])
def test_code_for_all_options_plays_the_same_without_them(monkeypatch: pytest.MonkeyPatch, arenas: int) -> None:
    """Most scenarios are played by code that has none of the options."""
    assert_played_the_same(monkeypatch, "catch_arena.core.state.options_of", lambda _settings: ALL_OPTIONS, arenas)


@pytest.mark.parametrize("width", [HALF, WIDE], ids=["four", "eight"])
def test_so_many_lanes_at_a_time_play_the_same(monkeypatch: pytest.MonkeyPatch, width: Width) -> None:
    """The usual width is the best on this machine: here and on others the bits are the same."""
    assert_played_the_same(monkeypatch, "catch_arena.engine.engine.PLAYED", width, 33)


def assert_played_the_same(monkeypatch: pytest.MonkeyPatch, name: str, value: object, arenas: int) -> None:
    """Engines that are made with and without something in another's place."""
    source = Random(arenas)
    config = ArenaConfig(
        hunters=5,
        control=("target", "velocity", "full", "target", "target"),
        spawn_frequency_hz=9.0,
        reach_m=1.0,
        faults=FaultRates(kill_refused=0.1, spawn_refused=0.1),
        rewards=RewardWeights(progress=1.0, lost_contest=-0.3),
    )
    usual = Engine(config, arenas)
    with monkeypatch.context() as other:
        other.setattr(name, value)
        changed = Engine(config, arenas)
    for engine in (usual, changed):
        engine.reset(range(arenas))
    for step in range(STEPS):
        actions = some_batch_actions(source, config, arenas)
        usual.step(*actions)
        changed.step(*actions)
        for row in range(arenas):
            assert_rows_same(usual, row, changed, row, f"row {row}, step {step}")


def test_every_row_has_its_own_outages() -> None:
    """R3.6, R8.3: the timer of each skips and is refused by the row's own seed, firing and number, and counts it."""
    faults = FaultRates(spawn_down=0.4, spawn_refused=0.4)
    config = ArenaConfig(hunters=2, max_targets=9, initial_targets=1, spawn_frequency_hz=7.0, faults=faults)
    batch = Engine(config, 7)
    batch.reset(range(7))
    alone = [Engine(config) for _ in range(7)]
    for seed, engine in enumerate(alone):
        engine.reset([seed])
    hold, rest = np.zeros((7, 2), dtype=np.int64), np.zeros((7, 2, 2), dtype=np.float32)
    for step in range(STEPS):
        batch.step(hold, rest)
        for row, engine in enumerate(alone):
            engine.step(hold[:1], rest[:1])
            assert_rows_same(batch, row, engine, 0, f"row {row}, step {step}")


UNCERTAIN: Mapping[str, Mapping[str, Any]] = {
    "wander": {"target_motion": "wander", "wander_period_ms": 333, "target_speed_mps": 5.0},
    "flee": {"target_motion": "flee", "wander_period_ms": 170, "target_speed_mps": 5.0, "alarm_m": 3.0},
    "views": {"view_radius_m": 3.0, "view_angle_deg": 120.0, "view_noise_m": 0.1, "reach_m": (0.5, 1.0, 1.5)},
    "dropouts": {"dropout_rate": 0.03, "dropouts": "fixed", "target_motion": "flee"},
    "teams": {"teams": ((0, 2), (1,)), "team_share": 0.5, "rewards": {"mate_catch": 0.5, "progress": 0.1}},
    "prey": {"prey": 3, "prey_returns_s": 0.3, "prey_rewards": {"survived": 1.0, "gained": 1.0}, "reach_m": 3.0},
}
"""Targets that move, partial views, reaches by seat, dropouts, teams, and prey."""


@pytest.mark.parametrize(
    ("period", "settings"),
    [
        *((period, {}) for period in (100, 1000, 1001, 1500)),
        *(pytest.param(100, settings, id=name) for name, settings in UNCERTAIN.items()),
    ],
)
@pytest.mark.parametrize("arenas", [1, 5, 33])
def test_some_rows_can_begin_anew_while_the_others_go_on(arenas: int, period: int, settings: Mapping[str, Any]) -> None:
    """A reset of one row equals a fresh arena with that seed, and disturbs no other row, though their steps then have
    different numbers of ticks; of 1001 ms every sixteenth step has a tick that R2.4's watchdog stops, in some rows now
    and in others later.
    """
    source = Random(arenas)
    config = ArenaConfig(
        hunters=3,
        control=("target", "velocity", "full"),
        control_period_ms=period,
        spawn_frequency_hz=5.0,
        reach_m=1.0,
    ).replace(**settings)
    batch, undisturbed = Engine(config, arenas), Engine(config, arenas)
    for engine in (batch, undisturbed):
        engine.reset(range(arenas))
    for _ in range(9):
        actions = some_batch_actions(source, config, arenas)
        batch.step(*actions)
        undisturbed.step(*actions)
    row = arenas // 2
    batch.reset([2**63], [row])
    fresh = Engine(config)
    fresh.reset([2**63])
    for step in range(10):
        assert_rows_same(batch, row, fresh, 0, f"step {step}")
        actions = some_batch_actions(source, config, arenas)
        batch.step(*actions)
        undisturbed.step(*actions)
        fresh.step(*(given[row : row + 1] for given in actions))
        for other in range(arenas):
            if other != row:
                assert_rows_same(batch, other, undisturbed, other, f"row {other}, step {step}")


def test_a_batchs_seeds_follow_from_one() -> None:
    """Appendix A.5, purpose 10: as the oracle draws them."""
    for seed in (0, 1, 2**64 - 1):
        expected = [draw(key(seed, ROW_SEED), row) for row in range(40)]
        assert [int(row_seed) for row_seed in batch_seeds(seed, 40)] == expected
