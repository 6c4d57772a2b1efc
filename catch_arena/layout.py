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


class TeamRivalFeatures(NamedTuple):
    """The same where there are teams (R7.4)."""

    forward: float
    left: float
    present: float
    heading_cos: float
    heading_sin: float
    linear_velocity: float
    score_difference: float
    mate: float


class PreySelfFeatures(NamedTuple):
    """What prey knows of itself (R12.4)."""

    x: float
    y: float
    heading_cos: float
    heading_sin: float
    linear_velocity: float
    angular_velocity: float
    time_left: float
    times_caught: float
    alive: float


class BodyFeatures(NamedTuple):
    """What prey sees of each hunter and of each other prey, nearest first (R12.4)."""

    forward: float
    left: float
    present: float
    heading_cos: float
    heading_sin: float
    linear_velocity: float


SELF_COLUMNS: Final = SelfFeatures._fields
TARGET_COLUMNS: Final = TargetFeatures._fields
MOVING_TARGET_COLUMNS: Final = MovingTargetFeatures._fields
RIVAL_COLUMNS: Final = RivalFeatures._fields
TEAM_RIVAL_COLUMNS: Final = TeamRivalFeatures._fields
PREY_SELF_COLUMNS: Final = PreySelfFeatures._fields
BODY_COLUMNS: Final = BodyFeatures._fields
OF_A_RANK: Final = (TargetFeatures, MovingTargetFeatures, RivalFeatures, TeamRivalFeatures, BodyFeatures)
"""The tables of what is seen by rank."""
MOST_SEEN_BY_PREY: Final = 8
"""R12.4: of hunters, and of other prey."""


def target_columns(config: ArenaConfig) -> tuple[str, ...]:
    """The columns of each target (R7.1, R7.4)."""
    return MOVING_TARGET_COLUMNS if config.targets_move else TARGET_COLUMNS


def rival_columns(config: ArenaConfig) -> tuple[str, ...]:
    """The columns of each rival (R7.1, R7.4)."""
    return RIVAL_COLUMNS if config.teams is None else TEAM_RIVAL_COLUMNS


def observation_size(config: ArenaConfig) -> int:
    """D, the length of a hunter's observation."""
    targets = len(target_columns(config)) * config.targets_seen
    return len(SELF_COLUMNS) + targets + len(rival_columns(config)) * config.hunters_seen


def hunters_seen_by_prey(config: ArenaConfig) -> int:
    """R12.4: how many hunters prey sees."""
    return min(config.hunters, MOST_SEEN_BY_PREY)


def prey_seen_by_prey(config: ArenaConfig) -> int:
    """R12.4: and how many other prey."""
    return max(0, min(config.prey - 1, MOST_SEEN_BY_PREY))


def prey_observation_size(config: ArenaConfig) -> int:
    """The length of prey's observation."""
    return len(PREY_SELF_COLUMNS) + len(BODY_COLUMNS) * (hunters_seen_by_prey(config) + prey_seen_by_prey(config))


@lru_cache(maxsize=16)  # a tournament makes an env for each match
def columns(config: ArenaConfig) -> tuple[Column, ...]:
    """The columns of a hunter's observation in order; bounds hold after rounding to float32."""
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
            Column("linear_velocity", "m/s", *_target_speeds(config), "its forward velocity"),
        )
    rival: tuple[Column, ...] = (
        Column("forward", "m", -farthest, farthest, "how far ahead it is"),
        Column("left", "m", -farthest, farthest, "how far to the left it is"),
        Column("present", "flag", 0.0, 1.0, "1 where this rank has a rival"),
        Column("heading_cos", "1", -1.0, 1.0, "cosine of its heading relative to one's own"),
        Column("heading_sin", "1", -1.0, 1.0, "sine of its heading relative to one's own"),
        Column("linear_velocity", "m/s", slowest, fastest, "its forward velocity"),
        Column("score_difference", "catches", -catches, catches, "its score less one's own"),
    )
    if config.teams is not None:
        rival += (Column("mate", "flag", 0.0, 1.0, "1 where it is a team-mate"),)
    return (
        own
        + tuple(
            c._replace(name=f"target_{rank}.{c.name}") for rank in range(1, config.targets_seen + 1) for c in target
        )
        + tuple(c._replace(name=f"rival_{rank}.{c.name}") for rank in range(1, config.hunters_seen + 1) for c in rival)
    )


def _target_speeds(config: ArenaConfig) -> tuple[float, float]:
    """R3.8, R12.2: a target's least and greatest velocity [m/s]; only prey drives backwards."""
    fastest = config.target_speed_mps
    return (-fastest if config.prey and config.reverse else 0.0, fastest)


@lru_cache(maxsize=16)
def prey_columns(config: ArenaConfig) -> tuple[Column, ...]:
    """R12.4: the columns of prey's observation in order; () where there is no prey."""
    if not config.prey:
        return ()
    hunters = {column.name: column for column in columns(config.replace(view_noise_m=0.0, observed_hunters=None))}
    slowest, fastest = _target_speeds(config)
    turn_rate = config.target_turn_rate_radps
    own = (
        *(hunters[name] for name in ("x", "y", "heading_cos", "heading_sin")),
        hunters["linear_velocity"]._replace(low=slowest, high=fastest),
        hunters["angular_velocity"]._replace(low=-turn_rate, high=turn_rate),
        hunters["time_left"],
        Column("times_caught", "catches", 0.0, float(config.max_steps), "how often it was caught so far"),
        Column("alive", "flag", 0.0, 1.0, "0 while it is out"),
    )
    hunter = (
        hunters["target_1.forward"],
        hunters["target_1.left"],
        hunters["target_1.present"]._replace(meaning="1 where this rank has a hunter"),
        hunters["target_1.heading_cos"],
        hunters["target_1.heading_sin"],
        hunters["linear_velocity"]._replace(meaning="its forward velocity"),
    )
    other = (
        *hunter[:2],
        hunter[2]._replace(meaning="1 where this rank has another prey"),
        *hunter[3:5],
        hunter[5]._replace(low=slowest, high=fastest),
    )
    return own + tuple(
        column._replace(name=f"{kind}_{rank}.{column.name.rpartition('.')[2]}")
        for kind, ranks, table in (
            ("hunter", hunters_seen_by_prey(config), hunter),
            ("prey", prey_seen_by_prey(config), other),
        )
        for rank in range(1, ranks + 1)
        for column in table
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
STATE_PREY_COLUMNS: Final = (
    "alive",
    "x",
    "y",
    "heading_cos",
    "heading_sin",
    "linear_velocity",
    "angular_velocity",
    "times_caught",
    "withdrawn",
)
"""And of each prey, by index."""


@lru_cache(maxsize=16)
def state_columns(config: ArenaConfig) -> tuple[Column, ...]:
    """R7.3: the columns of the global view, in the world frame."""
    own = {column.name: column for column in columns(config)}
    slowest, fastest = _target_speeds(config)
    duration = config.max_steps * config.control_period_ms / 1000.0
    of_target = {
        "present": Column("present", "flag", 0.0, 1.0, "1 where this place has a target"),
        "x": own["x"],
        "y": own["y"],
        "age": Column("age", "s", 0.0, duration, "since it appeared"),
        "heading_cos": own["heading_cos"],
        "heading_sin": own["heading_sin"],
        "linear_velocity": own["linear_velocity"]._replace(low=slowest, high=fastest),
    }
    withdrawn = Column("withdrawn", "flag", 0.0, 1.0, "1 where the hunter takes no further part")
    table = {**own, "withdrawn": withdrawn}
    of_prey = {column.name: column for column in prey_columns(config)}
    of_prey["withdrawn"] = withdrawn._replace(meaning="1 where the prey takes no further part")
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
        *(
            of_prey[name]._replace(name=f"prey_{index}.{name}")
            for index in range(config.prey)
            for name in STATE_PREY_COLUMNS
        ),
    )
