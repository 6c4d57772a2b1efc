"""The map of the arena memory: no two things share a row, and the digest reads what A.8 lists."""

import pytest
from oracle.arena import OracleArena
from oracle.arithmetic import to_float32

from catch_arena.config import MAX_HUNTERS, MAX_PREY, MAX_TARGETS, ArenaConfig
from catch_arena.core import state
from catch_arena.core.state import LANES
from catch_arena.envs.parallel import parallel_env
from catch_arena.layout import (
    MovingTargetFeatures,
    RivalFeatures,
    SelfFeatures,
    TargetFeatures,
    columns,
    observation_size,
    prey_columns,
    state_columns,
)
from catch_arena.scenarios import SCENARIOS
from catch_arena.verdicts import Verdict

ARENA = [
    "TIME",
    "STEP",
    "SPAWNED",
    "LAST_NUMBER",
    "FIRINGS",
    "SKIPPED_FULL",
    "SKIPPED_DOWN",
    "SPAWNS_REFUSED",
    "ALIVE",
    "ENDED",
    "SEED_HIGH",
    "SEED_LOW",
]
HUNTER = [
    "X",
    "Y",
    "THETA",
    "SPEED",
    "TURN_RATE",
    "AT_WALL",
    "SINE",
    "COSINE",
    "DISTANCE_INTEGRAL",
    "BEARING_INTEGRAL",
    "ACTIVE",
    "SCORE",
    "WITHDRAWN",
    "REQUESTED_NUMBER",
    "VERDICT",
    "DISTANCE",
    "WINNER",
    "REWARD_SUM",
    "CONTESTS_WON",
]
PREY = ["PREY_SLOT", "TIMES_CAUGHT", "CAUGHT_AT", "CAUGHT_BY", "PREY_WITHDRAWN", "PREY_REWARD_SUM"]


def test_every_row_has_one_owner():
    """Rows are numbered without gap or overlap, and the digest reads them in A.8's order."""
    assert [getattr(state, name) // LANES for name in ARENA] == list(range(state.ARENA_ROWS))
    assert [getattr(state, name) // LANES for name in HUNTER] == list(range(len(HUNTER)))
    tallies = [(state.TALLIES + verdict * LANES) // LANES for verdict in Verdict]
    assert tallies == list(range(len(HUNTER), state.HUNTER_ROWS))
    assert ARENA[state.ARENA_DIGEST_ROWS] == "ALIVE"
    digest = [HUNTER[row // LANES] for row in state.HUNTER_DIGEST]
    assert digest == [*HUNTER[:5], "DISTANCE_INTEGRAL", "BEARING_INTEGRAL", "ACTIVE", "SCORE", "AT_WALL", "WITHDRAWN"]
    assert [state.NUMBER // LANES, state.APPEARED // LANES, state.BODY // LANES] == [0, 1, 2]
    assert state.STILL_SLOT_ROWS == state.BODY // LANES + state.STILL_BODY_ROWS
    of_moving = [state.WANDER // LANES, state.WANDER_ENDS // LANES, state.MOVING_SLOT_ROWS]
    assert of_moving == [state.BODY // LANES + state.BODY_ROWS + more for more in range(3)]
    assert HUNTER.index("COSINE") + 1 == state.BODY_ROWS
    assert [getattr(state, name) // LANES for name in PREY] == list(range(state.PREY_ROWS))


def test_the_core_has_room_for_as_many_as_the_config_allows():
    """Keys and scratch memory have: an index behind it would be written elsewhere."""
    assert max(MAX_HUNTERS, MAX_TARGETS, MAX_PREY) <= state.MOST
    assert state.MOST & (state.MOST - 1) == 0  # `ranking.key_of` keeps it in whole bits


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


@pytest.mark.parametrize(("motion", "of_target"), [("still", TargetFeatures), ("wander", MovingTargetFeatures)])
def test_the_columns_have_the_names_and_the_order_in_which_the_core_writes_them(motion, of_target):
    """Its writer is made from the named tuples."""
    config = ArenaConfig(target_motion=motion)
    names = [column.name for column in columns(config)]
    own, target, rival = len(SelfFeatures._fields), len(of_target._fields), len(RivalFeatures._fields)
    first_rival = own + target * config.targets_seen
    assert names[:own] == list(SelfFeatures._fields)
    assert names[own : own + target] == [f"target_1.{name}" for name in of_target._fields]
    assert names[first_rival : first_rival + rival] == [f"rival_1.{name}" for name in RivalFeatures._fields]


@pytest.mark.parametrize("config", SCENARIOS.values(), ids=SCENARIOS)
def test_the_global_view_has_a_column_for_each_number_that_the_book_names(config):
    """R7.3: the time left, eight numbers of each hunter, and four of each target that there is room for; seven where
    targets move; and nine of each prey.
    """
    of_target = 7 if config.targets_move else 4
    table = state_columns(config)
    env = parallel_env(config)
    env.reset(seed=1)
    numbers = 1 + 8 * config.hunters + of_target * config.max_targets + 9 * config.prey
    assert len(table) == len(env.state()) == numbers
    assert len({column.name for column in table}) == len(table)
    assert all(column.low <= number <= column.high for column, number in zip(table, env.state(), strict=True))
