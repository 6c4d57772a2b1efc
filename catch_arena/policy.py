"""Interface of agents: the Policy protocols, and the named views of an observation that scripted agents read."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cache, cached_property
from typing import Any, ClassVar, Literal, NamedTuple, Protocol, get_args, runtime_checkable

from catch_arena.config import ArenaConfig, Control, SharedSettings
from catch_arena.errors import AgentError, ConfigError, require_type
from catch_arena.geometry import own_frame
from catch_arena.layout import Group, groups, prey_groups
from catch_arena.text import shortened

Side = Literal["hunter", "prey"]
"""R12.7: kind of player that an agent plays."""


@dataclass(frozen=True, kw_only=True)
class _PlayerLimits:
    """Settings of an arena that any player may use, as they apply to it; fixed for the match."""

    __slots__ = ()  # Python allows one base with slots, so that these fields are slots of the classes below

    side_m: float
    """Side of the arena [m]; x and y lie in [0, side_m] (R2.1)."""
    reach_m: float
    """Distance below which the hunter can catch a target [m]; for prey, the longest such distance (R5.3, R2.7)."""
    max_speed_mps: float
    """Greatest speed ahead [m/s] (R2.5, R12.2)."""
    min_speed_mps: float
    """Lowest linear velocity [m/s]: -max_speed_mps, or 0 if this player may not drive backwards."""
    max_turn_rate_radps: float
    """Greatest turn rate, to either side [rad/s] (R2.5, R12.2)."""
    control_period_ms: int
    """Time from one action to the next [ms] (R1.3)."""
    time_limit_s: float
    """Greatest length of the match [s] (R1.5)."""
    hunters: int
    """Number of all hunters in the arena."""
    hunters_seen: int
    """Largest number of hunters in view, the viewer not counted (R7.1, R12.4)."""
    prey: int = 0
    """Number of all prey in the arena: targets that agents play (R12.1)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits(SharedSettings, _PlayerLimits):
    """Settings of an arena that a hunter may use, as they apply to it; fixed for the match."""

    side: ClassVar[Side] = "hunter"

    targets_seen: int
    """Largest number of targets in view, which is the highest rank (R7.1)."""
    control: Control
    """Kind of control of this hunter: "target", "velocity" or "full" (R4.1, R4.4)."""
    targets_move: bool = False
    """True if targets can move: they wander or flee, or prey plays them (R3.7)."""
    target_speed_mps: float = 0.0
    """Greatest speed of a target [m/s]; 0 if targets stand still (R3.8)."""
    target_turn_rate_radps: float = 0.0
    """Greatest turn rate of a target [rad/s]; 0 if targets stand still (R3.8)."""
    alarm_m: float = 0.0
    """Distance below which a target flees from a hunter [m]; 0 if no target flees (R3.10)."""
    teams: bool = False
    """True if hunters play in teams; `rival.mate` then marks team-mates (R11.1)."""

    @classmethod
    def of(cls, config: ArenaConfig, seat: int | None = None) -> "Limits":
        """Return the limits of one seat of an arena; `seat` may be omitted if all hunters have the same limits.

        Raises:
            ConfigError: if no seat is given although hunters differ (R2.7, R4.1), and for an unknown seat.
        """
        require_type("config", config, ArenaConfig, "scenario(name)")
        if seat is None:
            if len({*zip(config.reaches, config.max_speeds, config.max_turn_rates, config.controls, strict=True)}) > 1:
                raise ConfigError("the limits of these hunters differ: give a seat, Limits.of(config, seat)")
            seat = 0
        if seat not in range(config.hunters):
            raise ConfigError(f"seat must be from 0 to {config.hunters - 1}, got {seat!r}")
        return cls(
            side_m=config.side_m,
            reach_m=config.reaches[seat],
            max_speed_mps=config.max_speeds[seat],
            min_speed_mps=config.min_speeds[seat],
            max_turn_rate_radps=config.max_turn_rates[seat],
            control_period_ms=config.control_period_ms,
            time_limit_s=config.time_limit_ms / 1000.0,
            hunters=config.hunters,
            targets_seen=config.targets_seen,
            hunters_seen=config.hunters_seen,
            control=config.controls[seat],
            targets_move=config.targets_move,
            target_speed_mps=config.target_speed_mps if config.targets_move else 0.0,
            target_turn_rate_radps=config.target_turn_rate_radps if config.targets_move else 0.0,
            alarm_m=config.alarm_m if config.target_motion == "flee" else 0.0,
            teams=config.teams is not None,
            prey=config.prey,
            **{setting.name: getattr(config, setting.name) for setting in fields(SharedSettings)},
        )

    def view(self, observation: Sequence[float], mask: Sequence[int]) -> "View":
        """Return an observation under names."""
        return View(observation, mask, self)


@dataclass(frozen=True, slots=True, kw_only=True)
class PreyLimits(_PlayerLimits):
    """Settings of an arena that prey may use; fixed for the match."""

    side: ClassVar[Side] = "prey"

    hunter_speed_mps: float
    """Greatest speed of the fastest hunter [m/s] (R2.5)."""
    prey_seen: int
    """Largest number of other prey in view (R12.4)."""
    returns_s: float | None
    """Time that prey is out after a catch [s]; None if it does not return (R12.3)."""

    @classmethod
    def of(cls, config: ArenaConfig) -> "PreyLimits":
        """Return the limits that all prey of an arena share."""
        require_type("config", config, ArenaConfig, "scenario(name)")
        _, hunters, others = prey_groups(config)
        return cls(
            side_m=config.side_m,
            reach_m=max(config.reaches),
            max_speed_mps=config.target_speed_mps,
            min_speed_mps=-config.target_speed_mps if config.reverse else 0.0,
            max_turn_rate_radps=config.target_turn_rate_radps,
            hunter_speed_mps=max(config.max_speeds),
            control_period_ms=config.control_period_ms,
            time_limit_s=config.time_limit_ms / 1000.0,
            hunters=config.hunters,
            prey=config.prey,
            hunters_seen=hunters.ranks,
            prey_seen=others.ranks,
            returns_s=config.prey_returns_s,
        )

    def view(self, observation: Sequence[float], mask: Sequence[int]) -> "PreyView":
        """Return an observation under names; prey has no mask (R7.2)."""
        del mask
        return PreyView(observation, self)


class SeenTarget(NamedTuple):
    """One target that a hunter sees, in the hunter's own frame."""

    rank: int
    """Rank, 1 for the nearest. It chooses the target: the action under target control, `catch` under full control."""
    forward: float
    """Distance ahead of this agent [m]; negative if it is to the rear."""
    left: float
    """Distance to the left of this agent [m]; negative if it is to the right."""
    age: float
    """Time since the target appeared [s]."""
    active: bool
    """True if it is the hunter's active target."""
    heading_cos: float = 1.0
    """Cosine of the target's heading relative to the hunter's; 1 if targets stand still, with `heading_sin` 0."""
    heading_sin: float = 0.0
    linear_velocity: float = 0.0
    """Velocity along the target's own heading [m/s]; 0 if targets stand still."""

    @property
    def distance(self) -> float:
        """Distance between the centres [m]."""
        return math.hypot(self.forward, self.left)

    @property
    def bearing(self) -> float:
        """Angle to turn to face it, positive to the left [rad] in [-pi, pi]."""
        return math.atan2(self.left, self.forward)

    @property
    def heading(self) -> float:
        """Heading relative to this agent's own [rad] in [-pi, pi]."""
        return math.atan2(self.heading_sin, self.heading_cos)


class SeenHunter(NamedTuple):
    """One rival that a hunter sees, in the hunter's own frame."""

    rank: int
    """Rank by distance; 1 is the nearest."""
    forward: float
    """Distance ahead of this agent [m]; negative if it is to the rear."""
    left: float
    """Distance to the left of this agent [m]; negative if it is to the right."""
    heading_cos: float
    heading_sin: float
    linear_velocity: float
    """Velocity along its own heading [m/s]."""
    score_difference: int
    """Score of the rival minus the hunter's own."""
    mate: bool = False
    """True if it is a team-mate (R7.4)."""

    @property
    def distance(self) -> float:
        """Distance between the centres [m]."""
        return math.hypot(self.forward, self.left)

    @property
    def heading(self) -> float:
        """Heading relative to this agent's own [rad] in [-pi, pi]."""
        return math.atan2(self.heading_sin, self.heading_cos)

    def distance_to(self, target: SeenTarget) -> float:
        """Return the distance between this rival and a target [m]."""
        return math.hypot(target.forward - self.forward, target.left - self.left)


class SeenBody(NamedTuple):
    """One hunter or one other prey that prey sees, in its own frame."""

    rank: int
    """Rank by distance; 1 is the nearest."""
    forward: float
    """Distance ahead of this agent [m]; negative if it is to the rear."""
    left: float
    """Distance to the left of this agent [m]; negative if it is to the right."""
    heading_cos: float
    """Cosine of its heading relative to this prey's."""
    heading_sin: float
    linear_velocity: float
    """Velocity along its own heading [m/s]."""

    @property
    def distance(self) -> float:
        """Distance between the centres [m]."""
        return math.hypot(self.forward, self.left)

    @property
    def bearing(self) -> float:
        """Angle to turn to face it, positive to the left [rad] in [-pi, pi]."""
        return math.atan2(self.left, self.forward)

    @property
    def heading(self) -> float:
        """Heading relative to this agent's own [rad] in [-pi, pi]."""
        return math.atan2(self.heading_sin, self.heading_cos)


@cache
def _typed(kind: Any, columns: int) -> list[tuple[int, type]]:
    """Return the fields of the first columns that are not floats: index among the fields after `rank`, and type."""
    types = [*kind.__annotations__.values()][1:columns]
    return [(place, field_type) for place, field_type in enumerate(types) if field_type is not float]


def _in_view(kind: Any, observation: Sequence[float], group: Group) -> tuple[Any, ...]:
    """Return the targets, hunters or prey of a group of columns that are in view, nearest first.

    The fields of `kind` are the rank and then the group's columns in their order, without `present`.
    """
    columns, present, column = len(group.table._fields), group.table._fields.index("present"), group.first
    typed, seen = _typed(kind, columns), []
    for rank in range(1, group.ranks + 1):
        values: list[Any] = list(observation[column : column + columns])
        if not values.pop(present):
            break
        for place, field_type in typed:
            values[place] = field_type(values[place])
        seen.append(kind(rank, *values))
        column += columns
    return tuple(seen)


class _Body:
    """Base of both views: an observation, and the part of it that describes the agent itself."""

    def __init__(self, observation: Sequence[float], groups: tuple[Group, Group, Group]) -> None:
        self._groups = groups
        own, _, last = groups
        try:
            if len(observation) != last.end:
                raise LookupError
            self._own: Any = own.table(*observation[: own.end])
        except (TypeError, LookupError):  # another length, a number, or a dict
            raise ConfigError(
                f"observation must be a vector of {last.end} numbers, as env.step returns it for each agent, "
                f"got {shortened(observation)}"
            ) from None
        self.x: float = self._own.x
        """Position in the world frame [m], as `y`."""
        self.y: float = self._own.y
        self.heading_cos: float = self._own.heading_cos
        """Cosine of the agent's heading in the world frame."""
        self.heading_sin: float = self._own.heading_sin
        self.linear_velocity: float = self._own.linear_velocity
        """Velocity ahead [m/s]."""
        self.angular_velocity: float = self._own.angular_velocity
        """Turn rate, positive to the left [rad/s]."""
        self.time_left: float = self._own.time_left
        """Time until the time limit [s]."""

    @property
    def heading(self) -> float:
        """Heading in the world frame [rad] in [-pi, pi]."""
        return math.atan2(self.heading_sin, self.heading_cos)

    def to_own_frame(self, x: float, y: float) -> tuple[float, float]:
        """Return a point of the world frame [m] as (forward, left) of this agent [m]."""
        return own_frame(self.heading_cos, self.heading_sin, x - self.x, y - self.y)


class View(_Body):
    """One observation under names, with the hunter's mask and limits, and nothing else of the world.

    Args:
        observation: D numbers (R7.1's layout).
        mask: the legal choices (empty under velocity control).
        limits: the hunter's abilities, and the arena's settings.

    Raises:
        ConfigError: for an observation of another length, and for limits of another type.
    """

    def __init__(self, observation: Sequence[float], mask: Sequence[int], limits: Limits) -> None:
        self.observation = observation
        """R7.1: observation as a vector, for policies that learn."""
        self.mask = mask
        """R7.2: 1 for each legal choice; `mask[0]`, hold, is always legal."""
        self.limits = limits
        require_type("limits", limits, Limits, "Limits.of(config)")
        super().__init__(observation, groups(limits))
        self.score: float = self._own.score
        """Number of catches granted so far."""
        self.distance_integral: float = self._own.distance_integral
        """R4.3's linear integral [m s]."""
        self.bearing_integral: float = self._own.bearing_integral
        """R4.3's angular integral [rad s]."""

    @cached_property
    def targets(self) -> tuple[SeenTarget, ...]:
        """Targets in view, nearest first."""
        return _in_view(SeenTarget, self.observation, self._groups[1])

    @cached_property
    def rivals(self) -> tuple[SeenHunter, ...]:
        """Rivals in view, nearest first."""
        return _in_view(SeenHunter, self.observation, self._groups[2])


class PreyView(_Body):
    """One observation of prey under names (R12.4). While prey is out, all but `time_left` and `times_caught` is 0.

    Args:
        observation: the numbers of R12.4.
        limits: the abilities of prey, and the arena's settings.

    Raises:
        ConfigError: for an observation of another length, and for limits of another type.
    """

    def __init__(self, observation: Sequence[float], limits: PreyLimits) -> None:
        self.observation = observation
        """R12.4: observation as a vector, for policies that learn."""
        self.limits = limits
        require_type("limits", limits, PreyLimits, "PreyLimits.of(config)")
        super().__init__(observation, prey_groups(limits))
        self.times_caught: float = self._own.times_caught
        """Number of times that this prey was caught so far."""
        self.alive: bool = self._own.alive > 0
        """True if this prey is in play; its action is ignored while it is out."""

    @cached_property
    def hunters(self) -> tuple[SeenBody, ...]:
        """Hunters in view, nearest first."""
        return _in_view(SeenBody, self.observation, self._groups[1])

    @cached_property
    def others(self) -> tuple[SeenBody, ...]:
        """Other prey in view, nearest first."""
        return _in_view(SeenBody, self.observation, self._groups[2])


AnyLimits = Limits | PreyLimits


def player_limits(config: ArenaConfig, seat: int) -> AnyLimits:
    """Return the limits of a seat of a match; the seats of prey follow those of the hunters."""
    return Limits.of(config, seat) if seat < config.hunters else PreyLimits.of(config)


@runtime_checkable
class Policy(Protocol):
    """An agent that plays a hunter. Its optional attribute `control` names its kind of action; the default is
    "target".

    Actions under "target": an int, 0 to hold or a target's rank. "velocity": two numbers in [-1, 1], linear and
    angular. "full": {"cmd_vel": two such numbers, "catch": an int}.
    """

    def reset(self, seed: int) -> None:
        """Begin a match. `seed`, in [0, 2^63), is for the agent alone; the match's seed cannot be derived from it."""

    def act(self, view: View) -> Any:
        """Return the action for this step."""


@runtime_checkable
class PreyPolicy(Protocol):
    """An agent that plays prey, under velocity control (R12.2)."""

    def reset(self, seed: int) -> None:
        """Begin a match. `seed`, in [0, 2^63), is for the agent alone; the match's seed cannot be derived from it."""

    def act(self, view: PreyView) -> Any:
        """Return speed and turn rate as fractions of the limits: two numbers in [-1, 1]."""


def control_of(policy: object) -> Control:
    """Return the control that a policy, or its class, names; "target" if it names none."""
    control: Control = getattr(policy, "control", "target")
    if not isinstance(control, str) or control not in get_args(Control):  # comparing an array would give no bool
        raise AgentError(f"control of {policy!r} must be target, velocity or full, got {shortened(control)}")
    return control
