"""Settings are read back from JSON unchanged, hold plain numbers, and compare in whole micrometres."""

import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from odd_actions import Index

from catch_arena import VectorArena, arbitrate, parallel_env
from catch_arena.config import ArenaConfig
from catch_arena.training import LearnerBatch

SETTINGS: list[dict[str, Any]] = [
    {},
    {"max_speed_mps": [2.0, 1.5, 1.0, 0.5], "max_turn_rate_radps": (4, 3, 2, 1), "reach_m": [0.3, 0.3, 0.3, 0.6]},
    {"target_motion": "wander", "target_speed_mps": 1.7, "target_turn_rate_radps": 0.4, "wander_period_ms": 1},
    {"target_motion": "flee", "alarm_m": 0.0},
    {"view_radius_m": 2.5, "view_angle_deg": 120, "view_noise_m": 0.05},
    {"dropout_rate": 0.01, "dropouts": "fixed"},
]


@pytest.mark.parametrize("settings", SETTINGS, ids=str)
def test_settings_are_read_back_from_json(settings: dict[str, Any]) -> None:
    """Equal, with one hash and one digest; lists have become tuples."""
    config = ArenaConfig().replace(**settings)
    again = ArenaConfig.from_dict(json.loads(json.dumps(config.to_dict())))
    assert again == config
    assert hash(again) == hash(config)
    assert again.digest == config.digest


def test_settings_of_before_the_targets_moved_are_read_as_they_were() -> None:
    """A header that names none of the newer settings is that of an arena without any of it."""
    new = {
        *("target_speed_mps", "target_turn_rate_radps", "wander_period_ms", "alarm_m"),
        *("view_radius_m", "view_angle_deg", "view_noise_m", "dropout_rate", "dropouts"),
    }
    written = ArenaConfig(hunters=3).to_dict()
    assert new <= set(written)
    config = ArenaConfig.from_dict({name: value for name, value in written.items() if name not in new})
    assert config == ArenaConfig(hunters=3)
    assert not config.targets_move
    assert not config.partial_view


def test_distances_that_are_compared_are_whole_micrometres() -> None:
    """R5.3's rounding; a reach is never nothing, while an alarm may be."""
    config = ArenaConfig(hunters=3, reach_m=(0.3, 1e-9, 0.0000015), alarm_m=0.0, view_radius_m=2.0000004)
    assert config.reaches_um == (300_000, 1, 2)
    assert config.alarm_um == 0
    assert config.view_radius_um == 2_000_000
    assert ArenaConfig().view_radius_um is None
    assert ArenaConfig().alarm_um == 2_000_000


@pytest.mark.parametrize(
    ("settings", "partial"),
    [({}, False), ({"view_radius_m": 9999.0}, True), ({"view_angle_deg": 359.9}, True), ({"view_noise_m": 1.0}, False)],
    ids=str,
)
def test_a_view_is_partial_where_something_may_lie_outside_of_it(settings: dict[str, Any], partial: bool) -> None:
    """R7.5: noise alone hides nothing, so the capstone's policy takes it."""
    assert ArenaConfig(**settings).partial_view == partial
    if not partial:
        assert ArenaConfig(policy="capstone", **settings).policy == "capstone"


OTHERS_NUMBERS = [
    ({"time_limit_s": np.int64(5)}, {"time_limit_s": 5}),
    ({"time_limit_s": np.float64(2.5)}, {"time_limit_s": 2.5}),
    ({"side_m": np.float32(4.5)}, {"side_m": 4.5}),
    ({"side_m": Fraction(9, 2)}, {"side_m": 4.5}),
    ({"hunters": np.uint8(3)}, {"hunters": 3}),
    ({"hunters": Index(3)}, {"hunters": 3}),
    ({"hunters": np.array(3)}, {"hunters": 3}),
    ({"reverse": np.True_, "spawning": np.bool_(False)}, {"reverse": True, "spawning": False}),
    ({"reach_m": np.array([0.1, 0.25, 0.3, 0.4])}, {"reach_m": (0.1, 0.25, 0.3, 0.4)}),
    ({"max_speed_mps": [np.float32(1.5), 2, np.int8(1), 0.5]}, {"max_speed_mps": (1.5, 2, 1, 0.5)}),
    ({"teams": np.array([[0, 1], [2, 3]])}, {"teams": ((0, 1), (2, 3))}),
    ({"teams": [[np.int64(0), 3], (1, 2)]}, {"teams": ((0, 3), (1, 2))}),
    (
        {"control": np.array(["target", "velocity", "full", "target"])},
        {"control": ("target", "velocity", "full", "target")},
    ),
    (
        {"hunter_poses": np.arange(12).reshape(4, 3) / 4},
        {"hunter_poses": tuple((i / 4, i / 4 + 0.25, i / 4 + 0.5) for i in (0, 3, 6, 9))},
    ),
    ({"rewards": {"catch": np.float32(0.5)}}, {"rewards": {"catch": 0.5}}),
]


@pytest.mark.parametrize(("given", "plain"), OTHERS_NUMBERS, ids=lambda value: str(value)[:40])
def test_numbers_of_numpy_are_settings_as_pythons_own_are(given, plain):
    """The config holds plain numbers: its digest and its JSON are those of the same numbers written by hand."""
    config, expected = ArenaConfig().replace(**given), ArenaConfig().replace(**plain)

    assert config == expected
    assert config.digest == expected.digest
    assert repr(config) == repr(expected)


def test_numbers_of_numpy_are_taken_by_all_that_takes_numbers():
    """Batches, learners, arbitration, names and the size of a picture."""
    arena = VectorArena("duel", np.int32(2), np.int8(1), auto_reset=np.True_, copy=np.False_)
    arena.reset(seed=np.uint64(7))

    assert arena.digest(np.int64(1)) == arena.digest(1)
    assert arena.action_space(np.int64(1)) == arena.action_space(1)
    assert LearnerBatch("duel", 1, opponents="idle", learners=np.int64(1), distinct=np.True_).learners == 1
    arguments = {"hunters": [(0.0, 0.0)], "targets": {"t": (0.0, 0.2)}, "requests": [(np.int8(0), "t")]}
    (ruling,) = arbitrate(**arguments, reach_m=np.array([0.3]), step=np.int64(4), seed=np.int64(1))
    assert ruling == arbitrate(**arguments, reach_m=0.3, step=4, seed=1)[0]
    assert type(ruling.step) is int
    env = parallel_env("duel")
    env.record(np.array(["ann", "bob"]))
    env.reset(seed=1)
    assert env.replay().names == ("ann", "bob")
