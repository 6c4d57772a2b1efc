"""What an agent is: the Policy protocols, and the named views of an observation that scripted agents read."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Final, Literal, NamedTuple, Protocol, TypeVar, runtime_checkable

from catch_arena.config import ArenaConfig, Control
from catch_arena.errors import AgentError, ConfigError, require_type
from catch_arena.layout import (
    BodyFeatures,
    MovingTargetFeatures,
    PreySelfFeatures,
    RivalFeatures,
    SelfFeatures,
    TargetFeatures,
    TeamRivalFeatures,
    hunters_seen_by_prey,
    prey_seen_by_prey,
)
from catch_arena.text import in_short

Side = Literal["hunter", "prey"]
"""R12.7: what an agent plays."""

_OWN: Final = len(SelfFeatures._fields)
_PREY: Final = len(PreySelfFeatures._fields)


@dataclass(frozen=True, slots=True)
class Limits:
    """What a hunter may know of its arena before the match."""

    side: ClassVar[Side] = "hunter"

    side_m: float
    """The arena's side [m]: x and y lie between 0 and it (R2.1)."""
    reach_m: float
    """A target nearer than this can be caught [m] (R5.3)."""
    max_speed_mps: float
    """The greatest speed ahead [m/s] (R2.5)."""
    min_speed_mps: float
    """The greatest speed backwards, -max_speed_mps [m/s]; 0 where hunters may not drive backwards."""
    max_turn_rate_radps: float
    """The greatest turn rate, to either side [rad/s] (R2.5)."""
    control_period_ms: int
    """From one action to the next [ms] (R1.3)."""
    time_limit_s: float
    """The match's length at most [s] (R1.5)."""
    hunters: int
    """How many play, this one among them."""
    targets_seen: int
    """How many targets are in view at most; it is the highest rank (R7.1)."""
    hunters_seen: int
    """How many rivals are in view at most (R7.1)."""
    control: Control
    """How this hunter is driven: "target", "velocity" or "full" (R4.1, R4.4)."""
    targets_move: bool = False
    """Whether targets wander or flee (R3.7)."""
    target_speed_mps: float = 0.0
    """The greatest speed of a target [m/s]; 0 where they stand still (R3.8)."""
    target_turn_rate_radps: float = 0.0
    """The greatest turn rate of a target [rad/s]; 0 where they stand still (R3.8)."""
    alarm_m: float = 0.0
    """A target flees from a hunter nearer than this [m]; 0 where none flees (R3.10)."""
    view_radius_m: float | None = None
    """How far this hunter sees [m]; None is everywhere (R7.5)."""
    view_angle_deg: float = 360.0
    """How wide the cone is that it sees, about its heading [degrees] (R7.5)."""
    view_noise_m: float = 0.0
    """The standard deviation of the error in each place that it sees [m] (R7.6)."""
    teams: bool = False
    """Whether hunters play in teams, so that `rival.mate` tells team-mates (R11.1)."""
    prey: int = 0
    """How many of the targets are played by agents (R12.1)."""

    @classmethod
    def of(cls, config: ArenaConfig, seat: int | None = None) -> "Limits":
        """The limits of one seat of an arena; it need not be given where all hunters are alike.

        Raises:
            ConfigError: without a seat, where hunters differ (R2.7, R4.1).
        """
        require_type("config", config, ArenaConfig, "scenario(name)")
        if seat is None:
            if len({*zip(config.reaches, config.max_speeds, config.max_turn_rates, config.controls, strict=True)}) > 1:
                raise ConfigError("seat must be given where hunters differ, Limits.of(config, seat), got none")
            seat = 0
        if seat not in range(config.hunters):
            raise ConfigError(f"seat must be from 0 to {config.hunters - 1}, got {seat!r}")
        return cls(
            side_m=config.side_m,
            reach_m=config.reaches[seat],
            max_speed_mps=config.max_speeds[seat],
            min_speed_mps=-config.max_speeds[seat] if config.reverse else 0.0,
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
            view_radius_m=config.view_radius_m,
            view_angle_deg=config.view_angle_deg,
            view_noise_m=config.view_noise_m,
            teams=config.teams is not None,
            prey=config.prey,
        )

    def view(self, observation: Sequence[float], mask: Sequence[int]) -> "View":
        """An observation under names."""
        return View(observation, mask, self)


@dataclass(frozen=True, slots=True)
class PreyLimits:
    """What prey may know of its arena before the match."""

    side: ClassVar[Side] = "prey"

    side_m: float
    """The arena's side [m]: x and y lie between 0 and it (R2.1)."""
    reach_m: float
    """A hunter nearer than this can catch it [m]; the longest reach, where hunters differ (R5.3, R2.7)."""
    max_speed_mps: float
    """Its greatest speed ahead [m/s] (R12.2)."""
    min_speed_mps: float
    """Its greatest speed backwards, -max_speed_mps [m/s]; 0 where driving backwards is not allowed."""
    max_turn_rate_radps: float
    """Its greatest turn rate, to either side [rad/s] (R12.2)."""
    hunter_speed_mps: float
    """The speed of the fastest hunter [m/s] (R2.5)."""
    control_period_ms: int
    """From one action to the next [ms] (R1.3)."""
    time_limit_s: float
    """The match's length at most [s] (R1.5)."""
    hunters: int
    """How many hunt."""
    prey: int
    """How many prey there are, this one among them."""
    hunters_seen: int
    """How many hunters are in view at most (R12.4)."""
    prey_seen: int
    """How many other prey are in view at most (R12.4)."""
    returns_s: float | None
    """How long it is out after a catch [s]; None where it does not return (R12.3)."""

    @classmethod
    def of(cls, config: ArenaConfig) -> "PreyLimits":
        """The limits of all prey of an arena."""
        require_type("config", config, ArenaConfig, "scenario(name)")
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
            hunters_seen=hunters_seen_by_prey(config),
            prey_seen=prey_seen_by_prey(config),
            returns_s=config.prey_returns_s,
        )

    def view(self, observation: Sequence[float], mask: Sequence[int]) -> "PreyView":
        """An observation under names; prey has no mask (R7.2)."""
        del mask
        return PreyView(observation, self)


class SeenTarget(NamedTuple):
    """One target in the hunter's own frame."""

    rank: int
    """1 = nearest; the action that chooses it under target control, and `catch` under full control."""
    forward: float
    """How far ahead it is [m]."""
    left: float
    """How far to the left it is [m]."""
    age: float
    """Since it appeared [s]."""
    active: bool
    """Whether it is the hunter's active target."""
    heading_cos: float = 1.0
    """Of its heading relative to one's own; 1 and 0 where targets stand still."""
    heading_sin: float = 0.0
    linear_velocity: float = 0.0
    """Along its own heading [m/s]; 0 where targets stand still."""

    @property
    def distance(self) -> float:
        """Between the centres [m]."""
        return math.hypot(self.forward, self.left)

    @property
    def bearing(self) -> float:
        """The turn that would face it, to the left [rad] in [-pi, pi]."""
        return math.atan2(self.left, self.forward)

    @property
    def heading(self) -> float:
        """Its heading relative to one's own [rad] in [-pi, pi]."""
        return math.atan2(self.heading_sin, self.heading_cos)


class SeenHunter(NamedTuple):
    """One rival in the hunter's own frame."""

    rank: int
    """1 = nearest."""
    forward: float
    """How far ahead it is [m]."""
    left: float
    """How far to the left it is [m]."""
    heading_cos: float
    heading_sin: float
    linear_velocity: float
    """Along its own heading [m/s]."""
    score_difference: int
    """Its score less one's own."""
    mate: bool = False
    """Whether it is a team-mate (R7.4)."""

    @property
    def distance(self) -> float:
        """Between the centres [m]."""
        return math.hypot(self.forward, self.left)

    @property
    def heading(self) -> float:
        """Its heading relative to one's own [rad] in [-pi, pi]."""
        return math.atan2(self.heading_sin, self.heading_cos)

    def distance_to(self, target: SeenTarget) -> float:
        """Between this rival and a target [m]."""
        return math.hypot(target.forward - self.forward, target.left - self.left)


class SeenBody(NamedTuple):
    """One hunter, or one other prey, in prey's own frame."""

    rank: int
    """1 = nearest."""
    forward: float
    """How far ahead it is [m]."""
    left: float
    """How far to the left it is [m]."""
    heading_cos: float
    """Of its heading relative to one's own."""
    heading_sin: float
    linear_velocity: float
    """Along its own heading [m/s]."""

    @property
    def distance(self) -> float:
        """Between the centres [m]."""
        return math.hypot(self.forward, self.left)

    @property
    def bearing(self) -> float:
        """The turn that would face it, to the left [rad] in [-pi, pi]."""
        return math.atan2(self.left, self.forward)

    @property
    def heading(self) -> float:
        """Its heading relative to one's own [rad] in [-pi, pi]."""
        return math.atan2(self.heading_sin, self.heading_cos)


def target_features(limits: Limits) -> Any:
    """R7.1, R7.4: what a hunter sees of a target, as a table of `layout`."""
    return MovingTargetFeatures if limits.targets_move else TargetFeatures


def rival_features(limits: Limits) -> Any:
    """R7.1, R7.4: what a hunter sees of a rival, as a table of `layout`."""
    return TeamRivalFeatures if limits.teams else RivalFeatures


def first_rival_column(limits: Limits) -> int:
    """Where the columns of rivals begin: behind one's own and those of targets."""
    return _OWN + limits.targets_seen * len(target_features(limits)._fields)


def numbers_seen(limits: Limits) -> int:
    """R7.1: the length of a hunter's observation."""
    return first_rival_column(limits) + limits.hunters_seen * len(rival_features(limits)._fields)


Seen = TypeVar("Seen", SeenTarget, SeenHunter, SeenBody)

_TYPED: Final = {
    kind: [(place - 1, of) for place, of in enumerate(kind.__annotations__.values()) if place > 0 and of is not float]
    for kind in (SeenTarget, SeenHunter, SeenBody)
}
"""Of what is seen, which columns become something else than a float."""


def _in_view(kind: type[Seen], features: Any, observation: Sequence[float], at: int, most: int) -> tuple[Seen, ...]:
    """What is seen of one kind, nearest first: behind the rank, `kind` has the columns of `features` in their order,
    all but `present`.

    Args:
        kind: what each becomes.
        features: the table of its columns.
        observation: where they stand.
        at: where those of rank 1 begin.
        most: how many ranks there are.
    """
    columns, present = len(features._fields), features._fields.index("present")
    typed = [(place, of) for place, of in _TYPED[kind] if place < columns - 1]
    seen = []
    for rank in range(1, most + 1):
        its: list[Any] = list(observation[at : at + columns])
        if not its.pop(present):
            break
        for place, of in typed:
            its[place] = of(its[place])
        seen.append(kind(rank, *its))
        at += columns
    return tuple(seen)


def _first_columns(observation: Sequence[float], count: int, size: int) -> Sequence[float]:
    """What an agent knows of itself.

    Raises:
        ConfigError: unless `size` columns are there.
    """
    try:
        if len(observation) == size:
            return observation[:count]
    except (TypeError, LookupError):  # a number, or a dict
        pass
    raise ConfigError(
        f"observation must be a vector of {size} numbers, as env.step returns it for each agent, "
        f"got {in_short(observation)}"
    )


class _Body:
    """Who looks, and what both sides know of themselves."""

    def __init__(self, own: SelfFeatures | PreySelfFeatures) -> None:
        self.x = own.x
        """In the world frame [m], as `y`."""
        self.y = own.y
        self.heading_cos = own.heading_cos
        """Of its heading in the world frame."""
        self.heading_sin = own.heading_sin
        self.linear_velocity = own.linear_velocity
        """Ahead [m/s]."""
        self.angular_velocity = own.angular_velocity
        """To the left [rad/s]."""
        self.time_left = own.time_left
        """Until the time limit [s]."""

    @property
    def heading(self) -> float:
        """In the world frame [rad] in [-pi, pi]."""
        return math.atan2(self.heading_sin, self.heading_cos)

    def to_own_frame(self, x: float, y: float) -> tuple[float, float]:
        """A point of the world frame [m] as (forward, left) of this agent [m]."""
        dx, dy = x - self.x, y - self.y
        cosine, sine = self.heading_cos, self.heading_sin
        return cosine * dx + sine * dy, cosine * dy - sine * dx


class View(_Body):
    """One observation under names: what the hunter senses, its mask and its limits, and nothing else of the world.

    Args:
        observation: D numbers (R7.1's layout).
        mask: the legal choices (empty under velocity control).
        limits: what the hunter can do, and what the arena is.

    Raises:
        ConfigError: for an observation of another length, and limits that are none.
    """

    def __init__(self, observation: Sequence[float], mask: Sequence[int], limits: Limits) -> None:
        self.observation = observation
        """R7.1's vector as it was given, for policies that learn."""
        self.mask = mask
        """R7.2: 1 where a choice is legal; `mask[0]`, hold, always is."""
        self.limits = limits
        require_type("limits", limits, Limits, "Limits.of(config)")
        own = SelfFeatures(*_first_columns(observation, _OWN, numbers_seen(limits)))
        super().__init__(own)
        self.score = own.score
        """Granted catches so far."""
        self.distance_integral = own.distance_integral
        """R4.3's linear integral [m s]."""
        self.bearing_integral = own.bearing_integral
        """R4.3's angular integral [rad s]."""

    @cached_property
    def targets(self) -> tuple[SeenTarget, ...]:
        """The targets in view, nearest first."""
        features = target_features(self.limits)
        return _in_view(SeenTarget, features, self.observation, _OWN, self.limits.targets_seen)

    @cached_property
    def rivals(self) -> tuple[SeenHunter, ...]:
        """The rivals in view, nearest first."""
        at, features = first_rival_column(self.limits), rival_features(self.limits)
        return _in_view(SeenHunter, features, self.observation, at, self.limits.hunters_seen)


class PreyView(_Body):
    """One observation of prey under names (R12.4). While it is out all but `time_left` and `times_caught` is zero.

    Args:
        observation: the numbers of R12.4.
        limits: what prey can do, and what the arena is.

    Raises:
        ConfigError: for an observation of another length, and limits that are none.
    """

    def __init__(self, observation: Sequence[float], limits: PreyLimits) -> None:
        self.observation = observation
        """R12.4's vector as it was given, for policies that learn."""
        self.limits = limits
        require_type("limits", limits, PreyLimits, "PreyLimits.of(config)")
        size = _PREY + len(BodyFeatures._fields) * (limits.hunters_seen + limits.prey_seen)
        own = PreySelfFeatures(*_first_columns(observation, _PREY, size))
        super().__init__(own)
        self.times_caught = own.times_caught
        """So far."""
        self.alive = own.alive > 0
        """Whether it is in play; while it is out, its action is ignored."""

    @cached_property
    def hunters(self) -> tuple[SeenBody, ...]:
        """The hunters in view, nearest first."""
        return _in_view(SeenBody, BodyFeatures, self.observation, _PREY, self.limits.hunters_seen)

    @cached_property
    def others(self) -> tuple[SeenBody, ...]:
        """The other prey in view, nearest first."""
        at = _PREY + len(BodyFeatures._fields) * self.limits.hunters_seen
        return _in_view(SeenBody, BodyFeatures, self.observation, at, self.limits.prey_seen)


AnyLimits = Limits | PreyLimits
"""Of a seat, whatever plays there."""


def player_limits(config: ArenaConfig, seat: int) -> AnyLimits:
    """Those of a seat of a match: of a hunter, or of prey, whose seats follow the hunters'."""
    return Limits.of(config, seat) if seat < config.hunters else PreyLimits.of(config)


@runtime_checkable
class Policy(Protocol):
    """An agent that hunts. It may also name its `control`, the kind of action that it gives ("target" where it does
    not).

    target: an int, 0 = hold or a target's rank. velocity: two numbers in [-1, 1], linear and angular. full:
    {"cmd_vel": two such numbers, "catch": an int}.
    """

    def reset(self, seed: int) -> None:
        """Begin a match; `seed`, in [0, 2^63), is the agent's own and tells nothing of the match's."""

    def act(self, view: View) -> Any:
        """The action for this step."""


@runtime_checkable
class PreyPolicy(Protocol):
    """An agent that plays prey, under velocity control (R12.2)."""

    def reset(self, seed: int) -> None:
        """Begin a match; `seed`, in [0, 2^63), is the agent's own and tells nothing of the match's."""

    def act(self, view: PreyView) -> Any:
        """Two numbers in [-1, 1]: speed and turn rate, as parts of the limits."""


def control_of(policy: object) -> Control:
    """The control that a policy, or its class, asks for."""
    word: Control = getattr(policy, "control", "target")
    if word not in ("target", "velocity", "full"):
        raise AgentError(f"control of {policy!r} must be target, velocity or full, got {word!r}")
    return word
