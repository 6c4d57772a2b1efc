"""The memory has room for all that the config allows, and the layout has a column for each number that is seen."""

import pytest
from oracle.arena import OracleArena
from oracle.arithmetic import to_float32

from catch_arena.config import MAX_HUNTERS, MAX_PREY, MAX_TARGETS
from catch_arena.core import state
from catch_arena.core.features import BodyTile, TargetTile
from catch_arena.core.transfers import TILE
from catch_arena.layout import (
    columns,
    observation_size,
    prey_columns,
)
from catch_arena.scenarios import SCENARIOS


def test_the_core_has_room_for_as_many_as_the_config_allows():
    """Keys and scratch memory have: an index behind it would be written elsewhere."""
    assert max(MAX_HUNTERS, MAX_TARGETS, MAX_PREY) <= state.MOST
    assert state.MOST & (state.MOST - 1) == 0  # `ranking.key_of` keeps it in whole bits
    assert max(len(BodyTile._fields), len(TargetTile._fields)) <= TILE


@pytest.mark.parametrize("period_ms", [100, 101, 134, 250])  # whose multiples in seconds float32 rounds up and down
@pytest.mark.parametrize("config", SCENARIOS.values(), ids=SCENARIOS)
def test_the_layout_has_a_column_for_each_number_that_the_oracle_sees(config, period_ms):
    """R7.1; and each number lies within its column's bounds, also when time has passed and something is caught."""
    config = config.replace(control_period_ms=period_ms, time_limit_s=30 * period_ms / 1000)
    oracle = OracleArena(config.to_dict())
    oracle.reset(1)
    table, of_prey = columns(config), prey_columns(config)
    actions = {"target": 1, "velocity": (1.0, 0.5), "full": ((1.0, 0.5), 1)}
    for _ in range(30):
        oracle.step([actions[control] for control in config.controls], [(1.0, -0.5)] * config.prey)
        sides = [(table, seen) for seen in oracle.observations()]
        sides += [(of_prey, seen) for seen in oracle.prey_observations()]
        for side, seen in sides:
            assert len(seen) == len(side)
            outside = [
                column.name
                for column, number in zip(side, seen, strict=True)
                if not to_float32(column.low) <= number <= to_float32(column.high)  # as a Box has them
            ]
            assert outside == []
    assert len(table) == observation_size(config)
    for side in (table, of_prey):
        assert len({column.name for column in side}) == len(side)
