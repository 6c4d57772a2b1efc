"""What a case of the conformance suite is."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

from catch_arena.verdicts import Verdict

LOT: Final = "LOT"
"""Stands for what a lot decides: as a verdict, who of the tied wins; as a winner, whoever that is."""
ANY: Final = "ANY"
"""Stands for the distance to a target that was spawned wherever the adjudicator's random numbers put it."""

NEVER: Final = "NEVER"
"""Stands for the None of `prey_returns_s`, which TOML cannot write."""

DEFAULTS: Final[Mapping[str, Any]] = {
    "reach_m": 0.3,
    "policy": "nearest",
    "seed": 0,
    "step": 0,
    "caught": (),
    "inactive": (),
    "kill_service_up": True,
    "kill_refused": (),
    "match_over": False,
}
"""What a case means where it does not say otherwise: the defaults of `arbitrate`."""

READINGS: Final = (
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
)
"""What a case may read of an arena; docs/conformance.md explains each."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ExpectedRuling:
    """One request, and the ruling that the rulebook gives it."""

    hunter: int
    target: object
    """What was asked for: any object at all; of an arena, a spawn number, or 0 for a rank without a target."""
    verdict: Verdict | Literal["LOT"]
    distance_um: int | Literal["ANY"] | None
    winner: int | Literal["LOT"] | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Lot:
    """R5.5, R5.9: one target that a lot gives to one of several seats."""

    target: object
    """As in the requests for it."""
    seats: tuple[int, ...]
    drawn: int | None
    """The seat that the appendix's hash draws; None in a variant of a case, whose lot nobody has worked out."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """What every case says about itself."""

    id: str
    clauses: tuple[str, ...]
    situation: str
    why: str
    options: tuple[str, ...] = ()
    """Where the rulebook could have chosen otherwise: what it could have said, its own choice first."""

    @property
    def group(self) -> str:
        """The file that the case stands in."""
        return self.id.partition(".")[0]


@dataclass(frozen=True, slots=True, kw_only=True)
class ArbiterCase(Case):
    """One step's requests, given to an arbiter by name."""

    hunters: tuple[tuple[float, float], ...]
    targets: Mapping[str, tuple[float, float]]
    expected: tuple[ExpectedRuling, ...]
    """The requests in their order, each with its ruling."""
    circumstances: Mapping[str, Any]
    """The other arguments of `arbitrate`: every key of DEFAULTS."""
    lots: tuple[Lot, ...] = ()
    fair_over_steps: int = 0
    """How many steps the lots are drawn in: every one of their seats must win in some of them; 0 leaves that out."""
    under_nearest: tuple[ExpectedRuling, ...] = ()
    """Of a case under another policy: what `nearest` answers to the same requests."""

    def arguments(self) -> dict[str, Any]:
        """The keyword arguments of `arbitrate`, in fresh containers."""
        given = {key: list(value) if isinstance(value, tuple) else value for key, value in self.circumstances.items()}
        return {
            "hunters": list(self.hunters),
            "targets": dict(self.targets),
            "requests": [(one.hunter, one.target) for one in self.expected],
            **given,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseStep:
    """One part of an arena's case: what happens to the arena next, in the order of these fields."""

    reset: bool = False
    hunters: tuple[tuple[float, float, float], ...] | None = None
    """With `targets`, a position to place: (x, y, theta) by seat."""
    targets: tuple[tuple[float, float], ...] = ()
    withdraw: int | None = None
    withdraw_prey: int | None = None
    """By index."""
    steps: int = 0
    """Steps in which nobody moves or asks."""
    drive: Mapping[int, tuple[float, float]]
    """(v [m/s], w [rad/s]) by seat, in the step of the requests."""
    drive_prey: Mapping[int, tuple[float, float]]
    """The same of prey, by index."""
    expected: tuple[ExpectedRuling, ...] | None = None
    """The requests of one more step, with their rulings: none at all where it is empty; no step where it is None."""
    read: Mapping[str, Any]
    """What stands in the arena then, by the words of READINGS."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ArenaCase(Case):
    """A piece of a match, for adjudicators that have an arena: spawning, time and identity."""

    settings: Mapping[str, Any]
    play: tuple[CaseStep, ...]
