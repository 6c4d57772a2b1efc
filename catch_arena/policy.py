"""What an agent is: the Policy protocol, and the named view of an observation that scripted agents read."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Protocol, runtime_checkable

from catch_arena.config import ArenaConfig, Control
from catch_arena.errors import AgentError
from catch_arena.layout import MovingTargetFeatures, RivalFeatures, SelfFeatures, TargetFeatures

_OWN = len(SelfFeatures._fields)
_STILL_TARGET = len(TargetFeatures._fields)
_MOVING_TARGET = len(MovingTargetFeatures._fields)
_RIVAL = len(RivalFeatures._fields)


@dataclass(frozen=True, slots=True)
class Limits:
    """What a hunter may know of its arena before the match."""

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

    @classmethod
    def of(cls, config: ArenaConfig, seat: int = 0) -> "Limits":
        """The limits of one seat of an arena."""
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
        )


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


def _target_columns(limits: Limits) -> int:
    return _MOVING_TARGET if limits.targets_move else _STILL_TARGET


class View:
    """One observation under names: what the hunter senses, its mask and its limits, and nothing else of the world.

    Args:
        observation: D numbers (R7.1's layout).
        mask: the legal choices (empty under velocity control).
        limits: what the hunter can do, and what the arena is.
    """

    def __init__(self, observation: Sequence[float], mask: Sequence[int], limits: Limits) -> None:
        self.observation = observation
        """R7.1's vector as it was given, for policies that learn."""
        self.mask = mask
        """R7.2: 1 where a choice is legal; `mask[0]`, hold, always is."""
        self.limits = limits
        own = SelfFeatures(*observation[:_OWN])
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
        self.score = own.score
        """Granted catches so far."""
        self.distance_integral = own.distance_integral
        """R4.3's linear integral [m s]."""
        self.bearing_integral = own.bearing_integral
        """R4.3's angular integral [rad s]."""

    @property
    def heading(self) -> float:
        """In the world frame [rad] in [-pi, pi]."""
        return math.atan2(self.heading_sin, self.heading_cos)

    @cached_property
    def targets(self) -> tuple[SeenTarget, ...]:
        """The targets in view, nearest first."""
        seen = []
        values, at, columns = self.observation, _OWN, _target_columns(self.limits)
        features = MovingTargetFeatures if self.limits.targets_move else TargetFeatures
        for rank in range(1, self.limits.targets_seen + 1):
            its: TargetFeatures | MovingTargetFeatures = features(*values[at : at + columns])
            if not its.present:
                break
            motion = (
                (its.heading_cos, its.heading_sin, its.linear_velocity) if isinstance(its, MovingTargetFeatures) else ()
            )
            seen.append(SeenTarget(rank, its.forward, its.left, its.age, its.active > 0, *motion))
            at += columns
        return tuple(seen)

    @cached_property
    def rivals(self) -> tuple[SeenHunter, ...]:
        """The rivals in view, nearest first."""
        seen = []
        values, at = self.observation, _OWN + _target_columns(self.limits) * self.limits.targets_seen
        for rank in range(1, self.limits.hunters_seen + 1):
            its = RivalFeatures(*values[at : at + _RIVAL])
            if not its.present:
                break
            motion = its.heading_cos, its.heading_sin, its.linear_velocity
            seen.append(SeenHunter(rank, its.forward, its.left, *motion, int(its.score_difference)))
            at += _RIVAL
        return tuple(seen)

    def to_own_frame(self, x: float, y: float) -> tuple[float, float]:
        """A point of the world frame [m] as (forward, left) of this hunter [m]."""
        dx, dy = x - self.x, y - self.y
        cosine, sine = self.heading_cos, self.heading_sin
        return cosine * dx + sine * dy, cosine * dy - sine * dx


@runtime_checkable
class Policy(Protocol):
    """An agent. It may also name its `control` ("target" where it does not): the kind of action that it gives.

    target: an int, 0 = hold or a target's rank. velocity: two numbers in [-1, 1], linear and angular. full:
    {"cmd_vel": two such numbers, "catch": an int}.
    """

    def reset(self, seed: int) -> None:
        """Begin a match; `seed`, in [0, 2^63), is the agent's own and tells nothing of the match's."""

    def act(self, view: View) -> Any:
        """The action for this step."""


def control_of(policy: object) -> Control:
    """The control that a policy, or its class, asks for."""
    word: Control = getattr(policy, "control", "target")
    if word not in ("target", "velocity", "full"):
        raise AgentError(f"control of {policy!r} must be target, velocity or full, got {word!r}")
    return word
