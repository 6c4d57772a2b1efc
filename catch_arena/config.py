"""Settings of an arena in common units: frozen, validated when they are made, and readable as JSON."""

import dataclasses
import hashlib
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, Final, Literal, get_args, get_origin

from catch_arena.errors import ConfigError, suggest
from catch_arena.plain import as_python, plain_setting, real_number, whole_number
from catch_arena.text import shortened, with_type

Control = Literal["target", "velocity", "full"]
"""R4.1, R4.4: kinds of control of a hunter."""
ArbitrationPolicy = Literal["nearest", "first_come", "capstone"]
"""R5.9: rules that decide the winner of a contest."""
TargetMotion = Literal["still", "wander", "flee"]
"""R3.7: kinds of motion of a target between its spawn and its catch."""

TURTLESIM_SIDE_M: Final = 11.088889122009277
"""R2.1: float32(499) / float32(45), the side of turtlesim's arena [m]."""
RULESET: Final = "catch_arena_v1"
"""R10.3: name of the ruleset; it changes only when equal inputs could play differently."""

MAX_HUNTERS: Final = 64
MAX_TARGETS: Final = 64
MAX_PREY: Final = 32
MAX_HEADING_RAD: Final = 1000.0
"""Largest absolute heading that a setting or a call may give [rad]; A.3's sine is tested up to it."""

# a type with the least and the greatest value of its numbers; the least is None for numbers above 0
_Gain = Annotated[float, 0.0, 1e6]
_Weight = Annotated[float, -1e6, 1e6]
_Probability = Annotated[float, 0.0, 1.0]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Part:
    """Base of a group of settings, all of them numbers."""

    def __post_init__(self) -> None:
        _make_plain(self)
        _check_values(self, next(f"{name}." for name, kind in _PARTS.items() if isinstance(self, kind)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Gains(_Part):
    """R4.3: gains of the hosted controllers. The defaults are the standard gains; the capstone has no integral part."""

    kp_v: _Gain = 2.0
    """Linear speed per metre of distance [1/s]."""
    ki_v: _Gain = 1.0
    """Linear speed per metre-second of accumulated distance [1/s^2]."""
    kp_w: _Gain = 6.0
    """Turn rate per radian of bearing error [1/s]."""
    ki_w: _Gain = 0.0
    """Turn rate per radian-second of accumulated bearing error [1/s^2]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RewardWeights(_Part):
    """R6.2: the weight of each named part of the reward."""

    catch: _Weight = 1.0
    """Reward per catch by the hunter itself."""
    rival_catch: _Weight = 0.0
    """Reward per catch by a hunter of another team; without teams, -1 / (hunters - 1) makes the game zero-sum."""
    lost_contest: _Weight = 0.0
    """Reward per request that another hunter won."""
    rejected_request: _Weight = 0.0
    """Reward per request refused for any other reason."""
    progress: _Weight = 0.0
    """Reward per metre gained towards the target that was nearest after the commit."""
    time: _Weight = 0.0
    """Reward per second of the match."""
    mate_catch: _Weight = 0.0
    """Reward per catch by a team-mate (R11.2)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PreyRewardWeights(_Part):
    """R12.5: the weight of each named part of prey's reward."""

    caught: _Weight = -1.0
    """Reward per catch of this prey."""
    survived: _Weight = 0.0
    """Reward per second that this prey is in play."""
    gained: _Weight = 0.0
    """Reward per metre that this prey gains on the nearest hunter."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FaultRates(_Part):
    """R8.3: failure probabilities of the services, in [0, 1]."""

    kill_down: _Probability = 0.0
    """Probability that the kill service is down for a whole step."""
    kill_refused: _Probability = 0.0
    """Probability that the simulator refuses to kill a given target in a given step."""
    spawn_down: _Probability = 0.0
    """Probability that the spawn service is down when the timer fires."""
    spawn_refused: _Probability = 0.0
    """Probability that the simulator refuses a given spawn number."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SharedSettings:
    """Settings that a hunter's `Limits` have too, with the same names and values: one that is added here needs no line
    in policy.py.
    """

    hunters_per_catch: int = 1
    """R5.10: number of hunters of one team that a catch needs; more than 1 requires teams."""
    view_radius_m: Annotated[float | None, None, 10_000.0] = None
    """R7.5: distance below which a hunter sees others; None means the whole arena."""
    view_angle_deg: Annotated[float, None, 360.0] = 360.0
    """R7.5: full angle of a hunter's cone of view, centred on its heading, above 0 and up to 360."""
    view_noise_m: Annotated[float, 0.0, 1000.0] = 0.0
    """R7.6: standard deviation of the error in each position that a hunter sees."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ArenaConfig(SharedSettings):
    """All settings of an arena; equal configs play equal matches (R10.1).

    The type of a number has its bounds: its least value, or None for above 0, and its greatest value.
    """

    hunters: Annotated[int, 1, MAX_HUNTERS] = 4
    """R2.6: number of hunters, 1 to 64."""
    control: Control | tuple[Control, ...] = "target"
    """R4.1, R4.4: kind of control, for all hunters or for each seat."""
    side_m: Annotated[float, 2.0, 5000.0] = TURTLESIM_SIDE_M
    """R2.1: side of the arena, 2 to 5000; both coordinates lie in [0, side_m]."""
    hunter_poses: tuple[tuple[float, float, float], ...] | None = None
    """R2.6: start pose (x, y, theta) of each seat; None draws poses on a fair circle."""
    start_radius_m: float | None = None
    """R2.6: radius of the fair circle of start poses; None means 0.3 of the side."""
    max_speed_mps: Annotated[float | tuple[float, ...], None, 1000.0] = 2.0
    """R2.5, R2.7: greatest speed v_max, for all hunters or for each seat."""
    max_turn_rate_radps: Annotated[float | tuple[float, ...], None, 1000.0] = 4.0
    """R2.5, R2.7: greatest turn rate w_max, for all hunters or for each seat."""
    reverse: bool = False
    """R2.5: true if hunters may drive backwards, down to -v_max; prey too."""
    reach_m: Annotated[float | tuple[float, ...], None, 10_000.0] = 0.3
    """R5.3, R2.7: a target is within reach strictly below this distance, for all hunters or for each seat."""
    policy: ArbitrationPolicy = "nearest"
    """R5.9: rule that decides contests."""
    teams: tuple[tuple[int, ...], ...] | None = None
    """R11.1: seats of each team, each seat once; None makes each hunter a team of its own."""
    team_share: _Probability = 0.0
    """R11.2: share of a hunter's reward that is the mean of its team's rewards, 0 to 1; no effect without teams."""
    spawning: bool = True
    """R3.1: true if the spawn timer is on."""
    spawn_frequency_hz: Annotated[float, -1e6, 1e6] = 1.0
    """R3.1: spawns per second; 0 or a negative value means one every 5 s, as in the capstone."""
    initial_targets: int = 8
    """R3.1: number of targets placed at reset, prey included."""
    max_targets: Annotated[int, 1, MAX_TARGETS] = 16
    """R3.5: largest number of targets alive at a time, 1 to 64."""
    target_budget: int | None = None
    """R1.5: number of targets after whose spawn and catch the episode terminates; None means no such end."""
    target_motion: TargetMotion = "still"
    """R3.7: motion of targets without prey: they stand still, wander (R3.9) or flee (R3.10)."""
    target_speed_mps: Annotated[float, None, 1000.0] = 1.0
    """R3.8: speed of a target, greatest speed of prey; a fleeing target drives at half of it if no hunter is near."""
    target_turn_rate_radps: Annotated[float, None, 1000.0] = 3.0
    """R3.8: greatest turn rate of a target or prey."""
    wander_period_ms: Annotated[int, 1, 10**9] = 1000
    """R3.9: time for which a wandering target keeps the turn rate that was drawn."""
    alarm_m: Annotated[float, 0.0, 10_000.0] = 2.0
    """R3.10: distance below which a hunter is a threat to a target."""
    prey: Annotated[int, 0, MAX_PREY] = 0
    """R12.1: number of initial targets that agents play, 0 to 32; prey requires target_budget None."""
    prey_returns_s: Annotated[float | None, 0.0, 1e9] = 2.0
    """R12.3: time from the catch of prey to its return; None means that it does not return."""
    name_prefix: str = "target_turtle_"
    """R3.4: first part of each target's name; the target's number follows."""
    observed_targets: int | None = None
    """R7.1: K, number of nearest targets in a hunter's observation; None means min(8, max_targets)."""
    observed_hunters: int | None = None
    """R7.1: number of nearest rivals in a hunter's observation; None means min(hunters - 1, 7)."""
    mask_in_observation: bool = False
    """R7.2: true if observations under target control are Dict(observation, action_mask), not the bare vector."""
    control_period_ms: Annotated[int, 16, 10**9] = 100
    """R1.3: duration of one step, at least 16."""
    time_limit_s: Annotated[float, None, 1e9] = 60.0
    """R1.5: time limit; the episode is truncated at the first step boundary at or past it."""
    max_cycles: Annotated[int | None, 1, 10**9] = None
    """R1.5: length of the episode in steps, PettingZoo's word for it; it replaces time_limit_s unless it is None."""
    dropout_rate: _Probability = 0.0
    """R1.7: probability that a hunter drops out in a step."""
    dropouts: Literal["leave", "fixed"] = "leave"
    """R1.7: a hunter that drops out leaves PettingZoo's agents, or stays among them and does nothing."""
    gains: Gains = field(default_factory=Gains)
    rewards: RewardWeights = field(default_factory=RewardWeights)
    prey_rewards: PreyRewardWeights = field(default_factory=PreyRewardWeights)
    faults: FaultRates = field(default_factory=FaultRates)

    def __deepcopy__(self, memo: object) -> "ArenaConfig":
        """Return this config itself, since nothing in it changes."""
        return self

    def __post_init__(self) -> None:
        _make_plain(self)
        _check_values(self)
        for name, value in by_seat("control", self.control, self.hunters):
            require_choice(name, value, get_args(Control))
        require_integer("initial_targets", self.initial_targets, 0, self.max_targets, "max_targets")
        require_integer("prey", self.prey, 0, self.initial_targets, "initial_targets, which include prey")
        if self.start_radius_m is not None:
            require_number("start_radius_m", self.start_radius_m, 0.0, self.side_m / 2)
        if self.target_budget is not None:
            require_integer("target_budget", self.target_budget, max(1, self.initial_targets), 2**40)
        if self.observed_targets is not None:
            require_integer("observed_targets", self.observed_targets, 1, self.max_targets, "max_targets")
        if self.observed_hunters is not None:
            require_integer("observed_hunters", self.observed_hunters, 0, self.hunters - 1, "hunters - 1")
        prefix = self.name_prefix
        if not isinstance(prefix, str) or len(prefix) > 200 or not prefix.isprintable():
            raise ConfigError(f"name_prefix must be at most 200 printable characters, got {prefix!r}")
        for name, kind in _PARTS.items():
            if not isinstance(getattr(self, name), kind):
                raise ConfigError(f"{name} must be {kind.__name__}(...) or a mapping, got {getattr(self, name)!r}")
        if self.teams is not None:
            object.__setattr__(self, "teams", checked_teams(self.teams, self.hunters))
        require_hunters_per_catch(self.hunters_per_catch, self.teams, self.policy)
        if self.prey and self.target_budget is not None:
            raise ConfigError(f"target_budget must be None if the arena has prey, got {self.target_budget!r}")
        if self.policy == "capstone":
            # R9.1: capstone agents drive to the first of all alive targets, so they must see it
            for name, whole in (("view_radius_m", None), ("view_angle_deg", 360)):
                if getattr(self, name) != whole:
                    raise ConfigError(
                        f"{name} must be {whole} under the policy 'capstone', got {getattr(self, name)!r}"
                    )
        self._check_poses()

    def _check_poses(self) -> None:
        if self.hunter_poses is None:
            return
        if not isinstance(self.hunter_poses, tuple) or len(self.hunter_poses) != self.hunters:
            raise ConfigError(f"hunter_poses must be {self.hunters} poses (x, y, theta), got {self.hunter_poses!r}")
        for seat, pose in enumerate(self.hunter_poses):
            if not isinstance(pose, tuple) or len(pose) != 3:
                raise ConfigError(f"hunter_poses[{seat}] must be (x, y, theta), got {pose!r}")
            for axis, value in zip("xy", pose[:2], strict=True):
                require_number(f"hunter_poses[{seat}].{axis}", value, 0.0, self.side_m)
            require_number(f"hunter_poses[{seat}].theta", pose[2], -MAX_HEADING_RAD, MAX_HEADING_RAD)
        # adding 0.0 turns -0.0 into 0.0, so that equal poses have equal digests
        poses = tuple((x + 0.0, y + 0.0, theta + 0.0) for x, y, theta in self.hunter_poses)
        object.__setattr__(self, "hunter_poses", poses)

    @property
    def controls(self) -> tuple[Control, ...]:
        """Kind of control of each seat."""
        return (self.control,) * self.hunters if isinstance(self.control, str) else self.control

    @property
    def targets_seen(self) -> int:
        """R7.1: K, number of targets in a hunter's observation."""
        return min(8, self.max_targets) if self.observed_targets is None else self.observed_targets

    @property
    def hunters_seen(self) -> int:
        """R7.1: number of rivals in a hunter's observation."""
        return min(self.hunters - 1, 7) if self.observed_hunters is None else self.observed_hunters

    @property
    def max_speeds(self) -> tuple[float, ...]:
        """R2.7: each seat's v_max [m/s]."""
        return self._for_each(self.max_speed_mps)

    @property
    def min_speeds(self) -> tuple[float, ...]:
        """R2.5: each seat's lowest linear velocity [m/s]: -v_max, or 0 if hunters may not drive backwards."""
        return tuple(-speed if self.reverse else 0.0 for speed in self.max_speeds)

    @property
    def max_turn_rates(self) -> tuple[float, ...]:
        """R2.7: each seat's w_max [rad/s]."""
        return self._for_each(self.max_turn_rate_radps)

    @property
    def reaches(self) -> tuple[float, ...]:
        """R2.7: each seat's reach [m]."""
        return self._for_each(self.reach_m)

    @property
    def reaches_um(self) -> tuple[int, ...]:
        """R5.3: each seat's reach in whole micrometres."""
        return tuple(max(1, micrometres(reach)) for reach in self.reaches)

    def _for_each(self, value: float | tuple[float, ...]) -> tuple[float, ...]:
        return value if isinstance(value, tuple) else (value,) * self.hunters

    @property
    def targets_move(self) -> bool:
        """R3.7: true if targets have velocities, and observations R7.4's columns."""
        return self.target_motion != "still" or self.prey > 0

    @property
    def alarm_um(self) -> int:
        """R3.10: the distance of alarm in whole micrometres."""
        return micrometres(self.alarm_m)

    @property
    def partial_view(self) -> bool:
        """R7.5: true if a hunter's view has a radius or a cone."""
        return self.view_radius_m is not None or self.view_angle_deg < 360.0

    @property
    def limits_views(self) -> bool:
        """R7.5, R7.6: true if hunters see only a part of the arena, or see positions with an error."""
        return self.partial_view or self.view_noise_m > 0.0

    @property
    def view_radius_um(self) -> int | None:
        """R7.5: view radius in whole micrometres; None means the whole arena."""
        return None if self.view_radius_m is None else micrometres(self.view_radius_m)

    @property
    def spawn_period_ms(self) -> int:
        """R3.1: period of the spawn timer [ms]."""
        if self.spawn_frequency_hz <= 0:
            return 5000
        return max(1, math.floor(1000.0 / self.spawn_frequency_hz + 0.5))

    @property
    def time_limit_ms(self) -> int:
        """R1.5: time limit [ms]; with max_cycles, the duration of that number of steps."""
        if self.max_cycles is not None:
            return self.max_cycles * self.control_period_ms
        return max(1, math.floor(1000.0 * self.time_limit_s + 0.5))

    @property
    def max_steps(self) -> int:
        """Number of steps in an episode that runs to its time limit."""
        return -(-self.time_limit_ms // self.control_period_ms)

    @property
    def hunter_names(self) -> tuple[str, ...]:
        """Names of the hunters in PettingZoo's interface, by seat."""
        return tuple(f"hunter_{seat}" for seat in range(self.hunters))

    @property
    def prey_names(self) -> tuple[str, ...]:
        """R12.1, R12.7: names of the prey in PettingZoo's interface, by index."""
        return tuple(f"prey_{index}" for index in range(self.prey))

    @property
    def team_seats(self) -> tuple[tuple[int, ...], ...]:
        """R11.1: seats of each team; without teams, each seat is a team."""
        return tuple((seat,) for seat in range(self.hunters)) if self.teams is None else self.teams

    @property
    def team_by_seat(self) -> tuple[int, ...]:
        """R11.1: index of each hunter's team in `team_seats`, by seat."""
        team_of = {seat: team for team, seats in enumerate(self.team_seats) for seat in seats}
        return tuple(team_of[seat] for seat in range(self.hunters))

    @property
    def prey_returns_ms(self) -> int | None:
        """R12.3: time from the state on which prey is caught to its return [ms]; None if it does not return."""
        return None if self.prey_returns_s is None else math.floor(1000.0 * self.prey_returns_s + 0.5)

    def target_name(self, number: int) -> str:
        """R3.4: return the name of the target with this spawn number."""
        return f"{self.name_prefix}{number}"

    def replace(self, **overrides: object) -> "ArenaConfig":
        """Return the config with some settings changed; `gains`, `rewards`, `prey_rewards` and `faults` may be
        partial mappings.
        """
        changes: dict[str, Any] = {}
        known = [setting.name for setting in dataclasses.fields(self)]
        for name, value in overrides.items():
            if name not in known:
                raise ConfigError(f"unknown setting {name!r}: {suggest(name, known)}")
            old = getattr(self, name)
            if isinstance(value, Mapping) and name in _PARTS:
                parts = [part.name for part in dataclasses.fields(old)]
                for part in value:
                    if part not in parts:
                        raise ConfigError(f"unknown setting {name}.{part}: {suggest(part, parts)}")
                changes[name] = dataclasses.replace(old, **value)
            else:
                changes[name] = value
        return dataclasses.replace(self, **changes)

    def to_dict(self) -> dict[str, Any]:
        """Return the settings as JSON-ready values; `from_dict` reads them back."""
        return dataclasses.asdict(self)

    def to_flat_dict(self) -> dict[str, Any]:
        """Return the settings as one table, with groups as single entries: `gains` becomes `gains.kp_v` and so on."""
        flat: dict[str, Any] = {}
        for name, value in self.to_dict().items():
            flat |= {f"{name}.{part}": number for part, number in value.items()} if name in _PARTS else {name: value}
        return flat

    @classmethod
    def from_dict(cls, settings: Mapping[str, Any]) -> "ArenaConfig":
        """Return the config that `to_dict` wrote; raise ConfigError for unknown or impossible settings."""
        if not isinstance(settings, Mapping) or not all(isinstance(name, str) for name in settings):
            raise ConfigError(
                f"settings must map names to values, as to_dict() returns them, got {shortened(settings)}"
            )
        return cls().replace(**settings)

    @property
    def digest(self) -> str:
        """Digest of these settings, 16 hexadecimal digits."""
        text = json.dumps(self.to_dict(), sort_keys=True, separators=(",", ":"))
        return hashlib.blake2b(text.encode(), digest_size=8).hexdigest()


_PARTS: Final = {"gains": Gains, "rewards": RewardWeights, "prey_rewards": PreyRewardWeights, "faults": FaultRates}
"""Class of each group of settings."""


def _make_plain(settings: object) -> None:
    """Convert a dataclass of settings to Python's own numbers, and arrays and lists to tuples."""
    for setting in dataclasses.fields(settings):  # type: ignore[arg-type]
        value = plain_setting(getattr(settings, setting.name))
        if not isinstance(value, tuple) or "tuple" in str(setting.type):  # else the error shows the original value
            object.__setattr__(settings, setting.name, value)


def _check_values(settings: Any, group: str = "") -> None:
    """Check each flag, each word and each number whose type has bounds; `group` comes before its name in errors."""
    for setting in dataclasses.fields(settings):
        kind: Any = setting.type
        if kind is bool:
            require_flag(setting.name, getattr(settings, setting.name))
        elif get_origin(kind) is Literal:
            require_choice(setting.name, getattr(settings, setting.name), get_args(kind))
        if not hasattr(kind, "__metadata__"):
            continue
        kinds = get_args(kind.__origin__) or (kind.__origin__,)
        require = require_integer if int in kinds else require_number
        values: Iterable[tuple[str, Any]] = [(group + setting.name, getattr(settings, setting.name))]
        if tuple[float, ...] in kinds:
            values = by_seat(setting.name, getattr(settings, setting.name), settings.hunters)
        for name, value in values:
            if value is not None or type(None) not in kinds:
                require(name, value, *kind.__metadata__)


def by_seat(name: str, value: Any, hunters: int) -> Iterator[tuple[str, Any]]:
    """Yield the value of a setting for all hunters, or of each seat, with its name in errors."""
    if not isinstance(value, tuple):
        yield name, value
        return
    if len(value) != hunters:
        raise ConfigError(f"{name} must be one value, or one for each of {hunters} hunters, got {value!r}")
    yield from ((f"{name}[{seat}]", one) for seat, one in enumerate(value))


def micrometres(metres: float) -> int:
    """R5.3: return a distance in whole micrometres."""
    return math.floor(1e6 * metres + 0.5)


def require_integer(name: str, value: object, low: int, high: int, high_is: str = "") -> int:
    """Return a whole number as an int; raise ConfigError unless it is one from `low` to `high`."""
    number = whole_number(value)
    if number is None or not low <= number <= high:
        limit = f"{high} ({high_is})" if high_is else f"{high}"
        shown = with_type(value) if number is None else shortened(number)
        raise ConfigError(f"{name} must be a whole number from {low} to {limit}, got {shown}")
    return number


def require_number(name: str, value: object, at_least: float | None, at_most: float) -> None:
    """Raise ConfigError unless a number is at least `at_least`, or above 0 if that is None, and at most `at_most`."""
    number = real_number(value)
    if number is None or not (number > 0 if at_least is None else number >= at_least) or not number <= at_most:
        low = "above 0" if at_least is None else f"at least {at_least:g}"
        shown = with_type(value) if number is None else shortened(number)
        raise ConfigError(f"{name} must be {low} and at most {at_most:g}, got {shown}")


def require_flag(name: str, value: object) -> bool:
    """Return a boolean setting as a bool, also if it is NumPy's; raise ConfigError for other types."""
    flag = as_python(value)
    if not isinstance(flag, bool):
        raise ConfigError(f"{name} must be true or false, got {with_type(value)}")
    return flag


def checked_teams(teams: object, hunters: int) -> tuple[tuple[int, ...], ...]:
    """R11.1: return the teams with the seats of each sorted; raise ConfigError unless they name each seat once."""
    if not isinstance(teams, tuple) or not all(isinstance(team, tuple) for team in teams):
        raise ConfigError(f"teams must be a tuple of tuples of seats, such as ((0, 1), (2, 3)), got {teams!r}")
    seats = [seat for team in teams for seat in team]
    if not all(teams) or not all(type(seat) is int for seat in seats) or sorted(seats) != list(range(hunters)):
        raise ConfigError(
            f"teams must name each seat from 0 to {hunters - 1} once, and each team must have a seat, got {teams!r}"
        )
    return tuple(tuple(sorted(team)) for team in teams)


def require_hunters_per_catch(number: object, teams: tuple[tuple[int, ...], ...] | None, policy: str) -> None:
    """R5.10: raise ConfigError unless some team has as many hunters as a catch needs."""
    require_integer("hunters_per_catch", number, 1, MAX_HUNTERS)
    if number == 1:
        return
    if policy == "capstone":
        raise ConfigError(f"hunters_per_catch must be 1 under the policy 'capstone', got {number}")
    if teams is None:
        raise ConfigError(f"hunters_per_catch must be 1 unless teams are given, got {number}")
    require_integer("hunters_per_catch", number, 1, max(map(len, teams), default=0), "the size of the largest team")


def require_options(options: object) -> None:
    """Raise ConfigError unless the options of a reset are a dict or None."""
    if not isinstance(options, Mapping | None):
        raise ConfigError(f"options must be a dict or None, got {with_type(options)}")


def require_choice(name: str, value: object, choices: Sequence[str | None]) -> None:
    """Raise ConfigError unless the value is one of the choices."""
    if not isinstance(value, str | None) or value not in choices:  # comparing an array would give no bool
        raise ConfigError(f"{name} must be one of {', '.join(map(str, choices))}, got {value!r}")
