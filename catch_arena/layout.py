"""Rulebook R7.1, R7.3: tables of the columns of observations and of the global state, and the values of the latter.

The space, the writer (core/observations.py), the named view for scripted agents (policy.py) and
docs/reference/observation.md are all made from them. The core makes tuples of their fields.

Each field of a table is a column, annotated with its unit, its bounds and its meaning. The bounds are the least and the
greatest value, or a function that returns them; they hold after rounding to float32.
"""

import math
from collections.abc import Sequence
from functools import cache
from typing import Annotated, Any, Final, NamedTuple

from catch_arena.config import ArenaConfig
from catch_arena.errors import require_type
from catch_arena.world import HunterState, TargetState, World

_FARTHEST_BLUR: Final = 3.4642
"""R7.6: greatest error of a seen position, in standard deviations."""
_ANY_PART: Final = (-1.0, 1.0)
_FLAG: Final = (0.0, 1.0)


class Column(NamedTuple):
    """One number of an observation."""

    name: str
    unit: str
    low: float
    high: float
    meaning: str


def _either_side(most: float) -> tuple[float, float]:
    return -most, most


def _catches(config: ArenaConfig) -> tuple[float, float]:
    return 0.0, float(config.max_steps)


def _diagonal(config: ArenaConfig) -> float:
    """Return the greatest distance between two bodies [m], with a margin, since sums and rotations round."""
    return 1.001 * math.sqrt(2.0) * config.side_m


def _duration(config: ArenaConfig) -> float:
    """Return the duration of the longest match, in whole steps [s]."""
    return config.max_steps * config.control_period_ms / 1000.0


def _seen_distance(config: ArenaConfig) -> tuple[float, float]:
    """R7.6: return the bounds of a part of the distance to a body that a hunter sees, with its error [m]."""
    return _either_side(_diagonal(config) + _FARTHEST_BLUR * config.view_noise_m)


def _speeds(config: ArenaConfig) -> tuple[float, float]:
    """Return the bounds of a hunter's linear velocity [m/s]."""
    return min(config.min_speeds), max(config.max_speeds)


def _target_speeds(config: ArenaConfig) -> tuple[float, float]:
    """R3.8, R12.2: return the bounds of the linear velocity of a target or prey [m/s]; only prey drives backwards."""
    return -config.target_speed_mps if config.prey and config.reverse else 0.0, config.target_speed_mps


_Place = Annotated[float, "m", lambda c: (0.0, c.side_m), "position in the world frame"]
_Cosine = Annotated[float, "1", _ANY_PART, "cosine of the heading"]
_Sine = Annotated[float, "1", _ANY_PART, "sine of the heading"]
_TimeLeft = Annotated[float, "s", lambda c: (0.0, c.time_limit_ms / 1000.0), "time until the time limit"]
_SeenAhead = Annotated[float, "m", _seen_distance, "distance ahead; negative is behind"]
_SeenAside = Annotated[float, "m", _seen_distance, "distance to the left; negative is to the right"]
_RelativeCosine = Annotated[float, "1", _ANY_PART, "cosine of its heading relative to the agent's own"]
_RelativeSine = Annotated[float, "1", _ANY_PART, "sine of its heading relative to the agent's own"]


class SelfFeatures(NamedTuple):
    """Columns of a hunter's observation that describe the hunter itself."""

    x: _Place
    y: _Place
    heading_cos: _Cosine
    heading_sin: _Sine
    linear_velocity: Annotated[float, "m/s", _speeds, "forward velocity"]
    angular_velocity: Annotated[float, "rad/s", lambda c: _either_side(max(c.max_turn_rates)), "turn rate, to the left"]
    time_left: _TimeLeft
    score: Annotated[float, "catches", _catches, "granted catches so far"]
    distance_integral: Annotated[float, "m s", lambda c: (0.0, _diagonal(c) * _duration(c)), "linear integral of R4.3"]
    bearing_integral: Annotated[float, "rad s", lambda c: _either_side(3.15 * _duration(c)), "angular integral of R4.3"]


class TargetFeatures(NamedTuple):
    """Columns of a hunter's observation for each target, nearest first."""

    forward: _SeenAhead
    left: _SeenAside
    present: Annotated[float, "flag", _FLAG, "1 if this rank has a target"]
    age: Annotated[float, "s", lambda c: (0.0, _duration(c)), "time since it appeared"]
    active: Annotated[float, "flag", _FLAG, "1 if it is the hunter's active target"]


class MotionFeatures(NamedTuple):
    """R7.4: further columns for each target if targets move."""

    heading_cos: _RelativeCosine
    heading_sin: _RelativeSine
    linear_velocity: Annotated[float, "m/s", _target_speeds, "its forward velocity"]


class RivalFeatures(NamedTuple):
    """Columns of a hunter's observation for each rival, nearest first."""

    forward: _SeenAhead
    left: _SeenAside
    present: Annotated[float, "flag", _FLAG, "1 if this rank has a rival"]
    heading_cos: _RelativeCosine
    heading_sin: _RelativeSine
    linear_velocity: Annotated[float, "m/s", _speeds, "its forward velocity"]
    score_difference: Annotated[
        float, "catches", lambda c: _either_side(float(c.max_steps)), "its score minus the agent's own"
    ]


class TeamFeatures(NamedTuple):
    """R7.4: further column for each rival if there are teams."""

    mate: Annotated[float, "flag", _FLAG, "1 if it is a team-mate"]


class PreySelfFeatures(NamedTuple):
    """R12.4: columns of prey's observation that describe the prey itself."""

    x: _Place
    y: _Place
    heading_cos: _Cosine
    heading_sin: _Sine
    linear_velocity: Annotated[float, "m/s", _target_speeds, "forward velocity"]
    angular_velocity: Annotated[
        float, "rad/s", lambda c: _either_side(c.target_turn_rate_radps), "turn rate, to the left"
    ]
    time_left: _TimeLeft
    times_caught: Annotated[float, "catches", _catches, "number of times it was caught so far"]
    alive: Annotated[float, "flag", _FLAG, "0 between a catch and its return"]


class BodyFeatures(NamedTuple):
    """R12.4: columns of prey's observation for each hunter, nearest first."""

    forward: Annotated[float, "m", lambda c: _either_side(_diagonal(c)), "distance ahead; negative is behind"]
    left: Annotated[float, "m", lambda c: _either_side(_diagonal(c)), "distance to the left; negative is to the right"]
    present: Annotated[float, "flag", _FLAG, "1 if this rank has a hunter"]
    heading_cos: _RelativeCosine
    heading_sin: _RelativeSine
    linear_velocity: Annotated[float, "m/s", _speeds, "its forward velocity"]


class PreyFeatures(NamedTuple):
    """R12.4: columns of prey's observation for each other prey that differ from a hunter's."""

    present: Annotated[float, "flag", _FLAG, "1 if this rank has another prey"]
    linear_velocity: Annotated[float, "m/s", _target_speeds, "its forward velocity"]


def _both(name: str, first: Any, more: Any) -> Any:
    """Return a table with the columns of two tables, in this order; `more` can replace columns of `first`."""
    make: Any = NamedTuple  # type checkers require literal fields of NamedTuple
    return make(name, [*(first.__annotations__ | more.__annotations__).items()])


MovingTargetFeatures: Final[Any] = _both("MovingTargetFeatures", TargetFeatures, MotionFeatures)
TeamRivalFeatures: Final[Any] = _both("TeamRivalFeatures", RivalFeatures, TeamFeatures)
OtherPreyFeatures: Final[Any] = _both("OtherPreyFeatures", BodyFeatures, PreyFeatures)

MOST_SEEN_BY_PREY: Final = 8
"""R12.4: largest number of hunters that prey sees, and of other prey."""


class Group(NamedTuple):
    """Neighbouring columns of an observation: the columns of a table, once for each rank."""

    kind: str
    """First word of the columns' names, as in "target_1.forward"; empty for an agent's columns about itself."""
    table: Any
    ranks: int
    first: int
    """Index of the first column."""

    @property
    def end(self) -> int:
        """Index after the last column."""
        return self.first + self.ranks * len(self.table._fields)


@cache  # a view of one step is made of them
def _grouped(
    own_table: Any, first_seen: tuple[str, Any, int], then_seen: tuple[str, Any, int]
) -> tuple[Group, Group, Group]:
    """Return the columns of an agent itself, and then of the two kinds that it sees: word, table and ranks of each."""
    own = Group("", own_table, 1, 0)
    first = Group(*first_seen, own.end)
    return own, first, Group(*then_seen, first.end)


def groups(arena: Any) -> tuple[Group, Group, Group]:
    """R7.1, R7.4: return the columns of a hunter's observation: the hunter itself, targets, rivals.

    Args:
        arena: an `ArenaConfig`, or a hunter's `Limits`; so in the functions below.
    """
    target = MovingTargetFeatures if arena.targets_move else TargetFeatures
    rival = TeamRivalFeatures if arena.teams else RivalFeatures
    return _grouped(SelfFeatures, ("target", target, arena.targets_seen), ("rival", rival, arena.hunters_seen))


def observation_size(arena: Any) -> int:
    """R7.1: return D, the length of a hunter's observation."""
    return groups(arena)[-1].end


def prey_groups(arena: Any) -> tuple[Group, Group, Group]:
    """R12.4: return the columns of prey's observation: the prey itself, hunters, other prey.

    Args:
        arena: an `ArenaConfig`, or prey's `PreyLimits`.
    """
    hunters, others = (min(number, MOST_SEEN_BY_PREY) for number in (arena.hunters, max(0, arena.prey - 1)))
    return _grouped(PreySelfFeatures, ("hunter", BodyFeatures, hunters), ("prey", OtherPreyFeatures, others))


def prey_observation_size(arena: Any) -> int:
    """R12.4: return E, the length of prey's observation."""
    return prey_groups(arena)[-1].end


def column_names(groups: Sequence[Group]) -> tuple[str, ...]:
    """Return the names of the columns in some groups, such as "x" and "target_1.forward"."""
    return tuple(
        f"{group.kind}_{rank}.{name}" if group.kind else name
        for group in groups
        for rank in range(1, group.ranks + 1)
        for name in group.table._fields
    )


def _columns_in(groups: Sequence[Group], config: ArenaConfig) -> tuple[Column, ...]:
    """Return the columns of some groups, with their bounds in an arena."""
    kinds = [kind for group in groups for kind in [*group.table.__annotations__.values()] * group.ranks]
    made = []
    for name, kind in zip(column_names(groups), kinds, strict=True):
        unit, bounds, meaning = kind.__metadata__
        low, high = bounds(config) if callable(bounds) else bounds
        made.append(Column(name, unit, low, high, meaning))
    return tuple(made)


def columns(config: ArenaConfig) -> tuple[Column, ...]:
    """Return the columns of a hunter's observation in order; bounds hold after rounding to float32."""
    require_type("config", config, ArenaConfig, "scenario(name)")
    return _columns_in(groups(config), config)


def prey_columns(config: ArenaConfig) -> tuple[Column, ...]:
    """R12.4: return the columns of prey's observation in order; () if there is no prey."""
    require_type("config", config, ArenaConfig, "scenario(name)")
    return _columns_in(prey_groups(config), config) if config.prey else ()


def state_columns(config: ArenaConfig) -> tuple[Column, ...]:
    """R7.3: return the columns of the global state, in the world frame."""
    require_type("config", config, ArenaConfig, "scenario(name)")
    body = ("x", "y", "heading_cos", "heading_sin", "linear_velocity", "angular_velocity")
    motion = ("heading_cos", "heading_sin", "linear_velocity") if config.targets_move else ()
    hunter, target, prey = (
        {column.name: column for column in _columns_in([Group("", table, 1, 0) for table in tables], config)}
        for tables in ((SelfFeatures,), (TargetFeatures, PreySelfFeatures), (PreySelfFeatures,))
    )
    withdrawn = Column("withdrawn", "flag", 0.0, 1.0, "1 if the hunter takes no further part")
    hunter["withdrawn"] = withdrawn
    target["present"] = target["present"]._replace(meaning="1 if this place has a target")
    prey["withdrawn"] = withdrawn._replace(meaning="1 if the prey takes no further part")
    parts = (
        ("hunter", range(config.hunters), hunter, (*body, "score", "withdrawn")),
        ("target", range(1, config.max_targets + 1), target, ("present", "x", "y", "age", *motion)),
        ("prey", range(config.prey), prey, ("alive", *body, "times_caught", "withdrawn")),
    )
    return (
        hunter["time_left"],
        *(
            table[name]._replace(name=f"{kind}_{number}.{name}")
            for kind, numbers, table, names in parts
            for number in numbers
            for name in names
        ),
    )


def state_values(world: World, config: ArenaConfig) -> list[float]:
    """R7.3: return a world as the numbers of `state_columns`, in their order."""
    values: list[float] = [max(0.0, (config.time_limit_ms - world.time_ms) / 1000.0)]
    for hunter in world.hunters:
        values += [*_body(hunter), hunter.score, hunter.withdrawn]
    for target in world.targets:
        values += [1.0, target.x, target.y, (world.time_ms - target.spawned_ms) / 1000.0]
        if config.targets_move:
            values += [math.cos(target.theta), math.sin(target.theta), target.linear_velocity]
    of_target = 7 if config.targets_move else 4
    values += [0.0] * of_target * (config.max_targets - len(world.targets))
    played = {target.prey: target for target in world.targets}
    for prey in world.prey:
        values += [1.0, *_body(played[prey.name])] if prey.name in played else [0.0] * 7  # it is out
        values += [prey.times_caught, prey.withdrawn]
    return values


def _body(of: HunterState | TargetState) -> tuple[float, ...]:
    return of.x, of.y, math.cos(of.theta), math.sin(of.theta), of.linear_velocity, of.angular_velocity
