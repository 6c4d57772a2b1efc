"""What the settings say of themselves: by seat, in whole micrometres, and as JSON."""

import json
from typing import Any

import pytest

from catch_arena.config import ArenaConfig

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


def test_one_number_holds_for_every_seat() -> None:
    """R2.7: and a tuple for each seat by itself."""
    same = ArenaConfig(hunters=3)
    assert (same.max_speeds, same.max_turn_rates, same.reaches) == ((2.0,) * 3, (4.0,) * 3, (0.3,) * 3)
    unequal = ArenaConfig(hunters=2, max_speed_mps=(2.0, 1.0), max_turn_rate_radps=(4.0, 6.5), reach_m=(0.3, 0.45))
    assert (unequal.max_speeds, unequal.max_turn_rates, unequal.reaches) == ((2.0, 1.0), (4.0, 6.5), (0.3, 0.45))


def test_distances_that_are_compared_are_whole_micrometres() -> None:
    """R5.3's rounding; a reach is never nothing, while an alarm may be."""
    config = ArenaConfig(hunters=3, reach_m=(0.3, 1e-9, 0.0000015), alarm_m=0.0, view_radius_m=2.0000004)
    assert config.reaches_um == (300_000, 1, 2)
    assert config.reach_um == 300_000
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
