"""Named scenarios: the arenas for play, teaching and publications; docs/reference/scenarios.md measures each."""

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from catch_arena.config import TURTLESIM_SIDE_M, ArenaConfig, FaultRates, Gains
from catch_arena.errors import ConfigError, suggest
from catch_arena.text import shortened

_STANDARD: Final = ArenaConfig()
_PAIRS: Final = _STANDARD.replace(teams=((0, 1), (2, 3)), team_share=1.0)
_TAG: Final = _STANDARD.replace(
    hunters=3,
    control="velocity",
    prey=1,
    initial_targets=1,
    max_targets=1,
    spawning=False,
    reach_m=0.5,
    target_speed_mps=2.2,
    target_turn_rate_radps=4.0,
)

SCENARIOS: Final[Mapping[str, ArenaConfig]] = MappingProxyType(
    {
        "standard": _STANDARD,
        "duel": _STANDARD.replace(hunters=2, initial_targets=2, max_targets=8, spawn_frequency_hz=0.5),
        "crowd": _STANDARD.replace(hunters=16, side_m=16.0, initial_targets=16, max_targets=32, spawn_frequency_hz=4.0),
        "scarce": _STANDARD.replace(initial_targets=0, spawn_frequency_hz=0.5),
        "faulty": _STANDARD.replace(
            faults=FaultRates(kill_down=0.1, kill_refused=0.1, spawn_down=0.1, spawn_refused=0.1)
        ),
        "wander": _STANDARD.replace(target_motion="wander"),
        "evasive": _STANDARD.replace(target_motion="flee", target_speed_mps=1.5),
        # velocity control: under target control a hunter that sees nothing can only hold, and not look around
        "fog": _STANDARD.replace(view_radius_m=2.5, control="velocity"),
        "haze": _STANDARD.replace(
            view_radius_m=1.5, control="velocity", side_m=20.0, initial_targets=16, max_targets=32
        ),
        "blinkers": _STANDARD.replace(view_angle_deg=100.0, control="velocity"),
        "unequal": _STANDARD.replace(max_speed_mps=(2.6, 2.2, 1.8, 1.4), reach_m=(0.2, 0.3, 0.4, 0.5)),
        "dropout": _STANDARD.replace(dropout_rate=0.002),
        "pairs": _PAIRS,
        "partners": _PAIRS.replace(hunters_per_catch=2),
        "squads": _STANDARD.replace(
            hunters=8,
            teams=((0, 1, 2, 3), (4, 5, 6, 7)),
            team_share=1.0,
            side_m=16.0,
            initial_targets=16,
            max_targets=32,
            spawn_frequency_hz=2.0,
        ),
        "tag": _TAG,
        # as fast as the hunters: prey that is faster learns to be caught by no pack
        "pack": _TAG.replace(teams=((0, 1, 2),), team_share=1.0, hunters_per_catch=2, target_speed_mps=2.0),
        "herd": _STANDARD.replace(prey=4, initial_targets=12, max_targets=20, target_motion="wander"),
        # the ROS 2 exercise with an arbiter: its reach, and a target each second
        "exercise": _STANDARD.replace(reach_m=0.5, initial_targets=0, spawn_frequency_hz=1.0),
        "capstone": _STANDARD.replace(  # R9.1
            hunters=1,
            policy="capstone",
            spawn_frequency_hz=0.5,
            initial_targets=0,
            max_targets=64,
            observed_targets=64,
            gains=Gains(kp_v=2.0, ki_v=0.0, kp_w=6.0, ki_w=0.0),
            max_speed_mps=2.0 * TURTLESIM_SIDE_M * math.sqrt(2.0),
            max_turn_rate_radps=6.0 * math.pi,
        ),
    }
)


def scenario(name: str | ArenaConfig, **overrides: object) -> ArenaConfig:
    """Return the settings of a named scenario, or a given config, with overrides.

    Args:
        name: one of `SCENARIOS`, or a config.
        overrides: fields of `ArenaConfig` (`gains`, `rewards` and `faults` also as partial dicts).
            `continuous_actions` may stand for `control`: True is "velocity", False is "target".

    Raises:
        ConfigError: for an unknown name, with the nearest known one, or for an invalid setting.
    """
    if "continuous_actions" in overrides:
        continuous = overrides.pop("continuous_actions")
        if not isinstance(continuous, bool):
            raise ConfigError(f"continuous_actions must be True or False, got {shortened(continuous)}")
        if "control" in overrides:
            raise ConfigError("control and continuous_actions must not both be given: they are one setting")
        overrides["control"] = "velocity" if continuous else "target"
    if isinstance(name, ArenaConfig):
        return name.replace(**overrides)
    if not isinstance(name, str) or name not in SCENARIOS:
        raise ConfigError(f"unknown scenario {name!r}: {suggest(name, SCENARIOS)}")
    return SCENARIOS[name].replace(**overrides)
