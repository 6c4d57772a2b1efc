"""Rulebook R7.1: the observation's columns, in one table.

The space, the writer (core/observations.py), the named view for scripted agents (policy.py) and docs/observation.md
are all made from it.
"""

import math
from functools import lru_cache
from typing import Final, NamedTuple

from catch_arena.config import ArenaConfig

_FARTHEST_BLUR: Final = 3.4642
"""R7.6: the greatest error of a place, in standard deviations."""


class Column(NamedTuple):
    """One number of an observation."""

    name: str
    unit: str
    low: float
    high: float
    meaning: str


class SelfFeatures(NamedTuple):
    """What a hunter knows of itself."""

    x: float
    y: float
    heading_cos: float
    heading_sin: float
    linear_velocity: float
    angular_velocity: float
    time_left: float
    score: float
    distance_integral: float
    bearing_integral: float


class TargetFeatures(NamedTuple):
    """What it sees of each target, nearest first."""

    forward: float
    left: float
    present: float
    age: float
    active: float


class MovingTargetFeatures(NamedTuple):
    """The same where targets move (R7.4)."""

    forward: float
    left: float
    present: float
    age: float
    active: float
    heading_cos: float
    heading_sin: float
    linear_velocity: float


class RivalFeatures(NamedTuple):
    """What it sees of each rival, nearest first."""

    forward: float
    left: float
    present: float
    heading_cos: float
    heading_sin: float
    linear_velocity: float
    score_difference: float


SELF_COLUMNS: Final = SelfFeatures._fields
TARGET_COLUMNS: Final = TargetFeatures._fields
MOVING_TARGET_COLUMNS: Final = MovingTargetFeatures._fields
RIVAL_COLUMNS: Final = RivalFeatures._fields


def target_columns(config: ArenaConfig) -> tuple[str, ...]:
    """The columns of each target (R7.1, R7.4)."""
    return MOVING_TARGET_COLUMNS if config.targets_move else TARGET_COLUMNS


def width(config: ArenaConfig) -> int:
    """D, the length of an observation."""
    return (
        len(SELF_COLUMNS) + len(target_columns(config)) * config.targets_seen + len(RIVAL_COLUMNS) * config.hunters_seen
    )


@lru_cache(maxsize=16)  # a tournament makes an env for each match
def columns(config: ArenaConfig) -> tuple[Column, ...]:
    """The observation's columns in order; bounds hold after rounding to float32."""
    side = config.side_m
    # one part in a thousand of slack: sums and rotations round
    diagonal = 1.001 * math.sqrt(2.0) * side
    duration = config.max_steps * config.control_period_ms / 1000.0
    catches = float(config.max_steps)
    fastest, quickest_turn = max(config.max_speeds), max(config.max_turn_rates)
    slowest = -fastest if config.reverse else 0.0
    farthest = diagonal + _FARTHEST_BLUR * config.view_noise_m
    own = (
        Column("x", "m", 0.0, side, "position in the world frame"),
        Column("y", "m", 0.0, side, "position in the world frame"),
        Column("heading_cos", "1", -1.0, 1.0, "cosine of the heading"),
        Column("heading_sin", "1", -1.0, 1.0, "sine of the heading"),
        Column("linear_velocity", "m/s", slowest, fastest, "forward velocity"),
        Column(
            "angular_velocity",
            "rad/s",
            -quickest_turn,
            quickest_turn,
            "turn rate, to the left",
        ),
        Column("time_left", "s", 0.0, config.time_limit_ms / 1000.0, "until the time limit"),
        Column("score", "catches", 0.0, catches, "granted catches so far"),
        Column("distance_integral", "m s", 0.0, diagonal * duration, "R4.3's linear integral"),
        Column("bearing_integral", "rad s", -3.15 * duration, 3.15 * duration, "R4.3's angular integral"),
    )
    target: tuple[Column, ...] = (
        Column("forward", "m", -farthest, farthest, "how far ahead it is"),
        Column("left", "m", -farthest, farthest, "how far to the left it is"),
        Column("present", "flag", 0.0, 1.0, "1 where this rank has a target"),
        Column("age", "s", 0.0, duration, "since it appeared"),
        Column("active", "flag", 0.0, 1.0, "1 where it is the hunter's active target"),
    )
    if config.targets_move:
        target += (
            Column("heading_cos", "1", -1.0, 1.0, "cosine of its heading relative to one's own"),
            Column("heading_sin", "1", -1.0, 1.0, "sine of its heading relative to one's own"),
            Column("linear_velocity", "m/s", 0.0, config.target_speed_mps, "its forward velocity"),
        )
    rival = (
        Column("forward", "m", -farthest, farthest, "how far ahead it is"),
        Column("left", "m", -farthest, farthest, "how far to the left it is"),
        Column("present", "flag", 0.0, 1.0, "1 where this rank has a rival"),
        Column("heading_cos", "1", -1.0, 1.0, "cosine of its heading relative to one's own"),
        Column("heading_sin", "1", -1.0, 1.0, "sine of its heading relative to one's own"),
        Column("linear_velocity", "m/s", slowest, fastest, "its forward velocity"),
        Column("score_difference", "catches", -catches, catches, "its score less one's own"),
    )
    return (
        own
        + tuple(
            c._replace(name=f"target_{rank}.{c.name}") for rank in range(1, config.targets_seen + 1) for c in target
        )
        + tuple(c._replace(name=f"rival_{rank}.{c.name}") for rank in range(1, config.hunters_seen + 1) for c in rival)
    )


STATE_HUNTER_COLUMNS: Final = (
    "x",
    "y",
    "heading_cos",
    "heading_sin",
    "linear_velocity",
    "angular_velocity",
    "score",
    "withdrawn",
)
"""What R7.3's global view says of each hunter, by seat."""
STATE_TARGET_COLUMNS: Final = ("present", "x", "y", "age")
"""What it says of each target, in spawning order, up to max_targets."""
STATE_MOVING_TARGET_COLUMNS: Final = (*STATE_TARGET_COLUMNS, "heading_cos", "heading_sin", "linear_velocity")
"""And of each where targets move."""


@lru_cache(maxsize=16)
def state_columns(config: ArenaConfig) -> tuple[Column, ...]:
    """R7.3: the columns of the global view, in the world frame."""
    own = {column.name: column for column in columns(config)}
    duration = config.max_steps * config.control_period_ms / 1000.0
    of_target = {
        "present": Column("present", "flag", 0.0, 1.0, "1 where this place has a target"),
        "x": own["x"],
        "y": own["y"],
        "age": Column("age", "s", 0.0, duration, "since it appeared"),
        "heading_cos": own["heading_cos"],
        "heading_sin": own["heading_sin"],
        "linear_velocity": own["linear_velocity"]._replace(low=0.0, high=config.target_speed_mps),
    }
    withdrawn = Column("withdrawn", "flag", 0.0, 1.0, "1 where the hunter takes no further part")
    table = {**own, "withdrawn": withdrawn}
    return (
        table["time_left"],
        *(
            table[name]._replace(name=f"hunter_{seat}.{name}")
            for seat in range(config.hunters)
            for name in STATE_HUNTER_COLUMNS
        ),
        *(
            of_target[name]._replace(name=f"target_{place}.{name}")
            for place in range(1, config.max_targets + 1)
            for name in (STATE_MOVING_TARGET_COLUMNS if config.targets_move else STATE_TARGET_COLUMNS)
        ),
    )
