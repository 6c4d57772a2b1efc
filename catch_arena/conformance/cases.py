"""Cases of the conformance suite. Their fields are the keys of the .toml files, and msgspec checks the types."""

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal

from msgspec import Meta, Struct, field, structs, to_builtins

from catch_arena.config import ArbitrationPolicy, TargetMotion
from catch_arena.verdicts import Verdict

LOT: Final = "LOT"
"""Placeholder for the result of a lot: as a verdict, that of a tied hunter; as a winner, the seat that is drawn."""
ANY: Final = "ANY"
"""Placeholder for the distance to a target whose place comes from the adjudicator's random numbers."""
NEVER: Final = "NEVER"
"""Placeholder for the None of `prey_returns_s`, which TOML cannot write."""
ANSWERS: Final = (LOT, *Verdict.__members__)

Whole = Annotated[int, Meta(ge=0)]
Number = Annotated[float, Meta(ge=-1e12, le=1e12)]
"""Finite number, of a magnitude up to 1e12."""
Place = tuple[Number, Number]
Reach = Number | tuple[Number, ...]
"""Reach of all hunters, or by seat (R2.7) [m]."""
Reading = Literal[
    "time_ms",
    "alive",
    "appeared_ms",
    "spawned",
    "skipped_full",
    "skipped_down",
    "refused",
    "scores",
    "team_scores",
    "prey",
    "times_caught",
    "ended",
    "seen",
    "rivals_seen",
]
"""Names of the values that a case may read from an arena; docs/reference/conformance_cases.md explains each."""


class _Table(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    pass


class ExpectedRuling(_Table, frozen=True, kw_only=True):
    """One request, and the ruling that the rulebook gives it."""

    hunter: Whole
    target: Any
    """The requested target: any object; for an arena, a spawn number, or 0 for a rank without a target."""
    answer: str = field(name="verdict")
    """One of ANSWERS."""
    distance_um: Whole | Literal["ANY"] | None = None
    winner: Whole | Literal["LOT"] | None = None

    @property
    def verdict(self) -> Verdict | Literal["LOT"]:
        """The expected verdict, or LOT."""
        return "LOT" if self.answer == LOT else Verdict[self.answer]


class RulingByName(ExpectedRuling, frozen=True, kw_only=True):
    """A ruling that is expected of an arbiter."""

    target: Any = field(name="name")


class RulingByNumber(ExpectedRuling, frozen=True, kw_only=True):
    """A ruling that is expected of an arena."""

    target: Whole = field(name="number")


class Lot(_Table, frozen=True, kw_only=True):
    """R5.5, R5.9: one target that a lot gives to one of several seats."""

    target: Any
    """The target, as the requests name it."""
    seats: tuple[Whole, ...]
    drawn: Whole | None
    """The seat that the appendix's hash draws; None in a variant of a case, for which it is not known."""


class Case(_Table, frozen=True, kw_only=True):
    """Base of all cases: id, clauses, situation and reason."""

    id: str
    clauses: Annotated[tuple[Annotated[str, Meta(pattern=r"^R\d+\.\d+$")], ...], Meta(min_length=1)]
    situation: str
    why: str
    options: tuple[str, ...] = ()
    """Rules that were possible here, the rulebook's own choice first; empty if there was no choice."""

    @property
    def group(self) -> str:
        """Stem of the name of the case's file."""
        return self.id.partition(".")[0]


class ArbiterCase(Case, frozen=True, kw_only=True):
    """One step's requests, given to an arbiter by name."""

    hunters: tuple[Place, ...]
    targets: dict[str, Place]
    expected: tuple[RulingByName, ...] = field(name="requests")
    """The requests in their order, each with its ruling."""
    reach_m: Reach = 0.3
    policy: ArbitrationPolicy = "nearest"
    seed: Whole = 0
    step: Whole = 0
    caught: tuple[str, ...] = ()
    inactive: tuple[Whole, ...] = ()
    kill_service_up: bool = True
    kill_refused: tuple[str, ...] = ()
    match_over: bool = False
    teams: tuple[tuple[Whole, ...], ...] | None = None
    """Seats by team."""
    hunters_per_catch: Whole = 1
    lots: tuple[Lot, ...] = ()
    fair_over_steps: Whole = 0
    """Number of steps in which the lots are drawn; each of their seats must win in some of them. 0: no such test."""
    under_nearest: tuple[RulingByName, ...] = ()
    """Rulings of the policy `nearest` on the same requests, for a case under another policy; else empty."""

    @property
    def circumstances(self) -> dict[str, Any]:
        """The other arguments of `arbitrate`: every key of DEFAULTS."""
        return {key: getattr(self, key) for key in DEFAULTS}

    def arguments(self) -> dict[str, Any]:
        """Return the keyword arguments of `arbitrate`, in new containers.

        Those of R5.10 are given only to cases about it, so that an arbiter without them can play all others.
        """
        given = {
            key: list(value) if isinstance(value, tuple) else value
            for key, value in self.circumstances.items()
            if key not in _NEWER or value != DEFAULTS[key]
        }
        return {
            "hunters": list(self.hunters),
            "targets": dict(self.targets),
            "requests": [(ruling.hunter, ruling.target) for ruling in self.expected],
            **given,
        }


DEFAULTS: Final[Mapping[str, Any]] = {
    argument.name: argument.default
    for argument in structs.fields(ArbiterCase)
    if argument.name
    in {
        *("reach_m", "policy", "seed", "step", "caught", "inactive"),
        *("kill_service_up", "kill_refused", "match_over", "teams", "hunters_per_catch"),
    }
}
"""Defaults of a case, equal to those of `arbitrate`."""
_NEWER: Final = ("teams", "hunters_per_catch")
"""Arguments that only cases about R5.10 have."""


class Settings(_Table, frozen=True, kw_only=True, omit_defaults=True):
    """Settings of an arena: fields of ArenaConfig, and the services that fail. None: not given."""

    reach_m: Reach | None = None
    policy: ArbitrationPolicy | None = None
    side_m: Number | None = None
    spawn_frequency_hz: Number | None = None
    initial_targets: Whole | None = None
    max_targets: Whole | None = None
    target_budget: Whole | None = None
    target_motion: TargetMotion | None = None
    target_speed_mps: Number | None = None
    target_turn_rate_radps: Number | None = None
    wander_period_ms: Whole | None = None
    alarm_m: Number | None = None
    view_radius_m: Number | None = None
    view_angle_deg: Number | None = None
    control_period_ms: Whole | None = None
    time_limit_s: Number | None = None
    drop_outs: tuple[tuple[Whole, Whole], ...] | None = None
    """Pairs (step, seat)."""
    kill_down: tuple[Whole, ...] | None = None
    """Steps in which the kill service is down."""
    kill_refused: tuple[tuple[Whole, Whole], ...] | None = None
    """Pairs (step, number) of refused kills."""
    spawn_down: tuple[Whole, ...] | None = None
    """Firings, from 1, at which the spawn service is down."""
    spawn_refused: tuple[Whole, ...] | None = None
    """Numbers of the targets whose spawning is refused."""
    spawning: bool | None = None
    teams: tuple[tuple[Whole, ...], ...] | None = None
    """Seats by team."""
    hunters_per_catch: Whole | None = None
    prey: Whole | None = None
    prey_returns_s: Number | Literal["NEVER"] | None = None
    hunters: Whole = 1


class CaseStep(_Table, frozen=True, kw_only=True):
    """One part of an arena's case: events in the arena, in the order of these fields."""

    reset: bool = False
    hunters: tuple[tuple[Number, Number, Number], ...] | None = None
    """Poses to place, (x, y, theta) by seat, together with `targets`; None places nothing."""
    targets: tuple[Place, ...] = ()
    withdraw: Whole | None = None
    withdraw_prey: Whole | None = None
    """Index of the prey to withdraw."""
    steps: Whole = 0
    """Number of steps without commands and requests."""
    driven: tuple[tuple[Whole, Number, Number], ...] = field(name="drive", default=())
    """Commands (seat, v [m/s], w [rad/s]) in the step of the requests; hunters without one stand still."""
    driven_prey: tuple[tuple[Whole, Number, Number], ...] = field(name="drive_prey", default=())
    """Commands (index, v [m/s], w [rad/s]) of prey in the step of the requests; prey without one stands still."""
    expected: tuple[RulingByNumber, ...] | None = field(name="requests", default=None)
    """The requests of one more step, with their rulings: empty for a step without requests, None for no step."""
    read: dict[Reading, Any] = {}
    """The expected state of the arena after the step."""

    @property
    def drive(self) -> dict[int, tuple[float, float]]:
        """Velocities (v [m/s], w [rad/s]) by seat."""
        return {seat: (v, w) for seat, v, w in self.driven}

    @property
    def drive_prey(self) -> dict[int, tuple[float, float]]:
        """Velocities (v [m/s], w [rad/s]) by the prey's index."""
        return {index: (v, w) for index, v, w in self.driven_prey}


class ArenaCase(Case, frozen=True, kw_only=True):
    """One part of a match, for adjudicators that have an arena: spawning, time and identity."""

    arena: Settings = field(name="settings")
    play: tuple[CaseStep, ...]

    @property
    def settings(self) -> dict[str, Any]:
        """The given settings of the arena, with the number of hunters."""
        given: dict[str, Any] = {"hunters": self.arena.hunters} | to_builtins(self.arena)
        return {key: None if value == NEVER else value for key, value in given.items()}
