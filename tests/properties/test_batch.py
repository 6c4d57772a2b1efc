"""Code for all options and for each number of lanes plays the same; the seeds of a batch follow from one.

test_engine_equals_oracle.py and test_rows_apart.py have rows of a batch, tests/vector its threads.
"""

from random import Random

import pytest
from oracle.arithmetic import ROW_SEED, draw, key
from properties.matches import seen, some_batch_actions

from catch_arena.config import ArenaConfig, FaultRates, RewardWeights
from catch_arena.core.state import ALL_OPTIONS
from catch_arena.core.vectors import HALF, WIDE, Width
from catch_arena.engine import Engine
from catch_arena.engine.episode_seeds import batch_seeds

STEPS = 20


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
            found = seen(changed, row)
            for what, expected in seen(usual, row).items():
                assert found[what] == expected, f"{what} differ: row {row}, step {step}"


def test_a_batchs_seeds_follow_from_one() -> None:
    """Appendix A.5, purpose 10: as the oracle draws them."""
    for seed in (0, 1, 2**64 - 1):
        expected = [draw(key(seed, ROW_SEED), row) for row in range(40)]
        assert [int(row_seed) for row_seed in batch_seeds(seed, 40)] == expected
