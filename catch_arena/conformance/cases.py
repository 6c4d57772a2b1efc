"""Cases of the conformance suite. Their fields are the keys of the .toml files, and msgspec checks the types."""

from collections.abc import Mapping
from copy import deepcopy
from functools import cache
from importlib.resources import files
from typing import Annotated, Any, Final, Literal

from msgspec import Meta, Struct, convert, field, structs

from catch_arena.config import ArbitrationPolicy
from catch_arena.errors import ConfigError
from catch_arena.files import tomllib
from catch_arena.verdicts import Verdict

LOT: Final = "LOT"
"""Placeholder for the result of a lot: as a verdict, that of a tied hunter; as a winner, the seat that is drawn."""
ANY: Final = "ANY"
"""Placeholder for the distance to a target whose place comes from the adjudicator's random numbers."""
NEVER: Final = "NEVER"
"""Placeholder for the None of `prey_returns_s`, which TOML cannot write."""

Whole = Annotated[int, Meta(ge=0)]
Place = tuple[float, float]


class _Table(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    pass


class ExpectedRuling(_Table, frozen=True, kw_only=True):
    """One request, and the ruling that the rulebook gives it."""

    hunter: Whole
    target: Any
    """The requested target: any object; for an arena, a spawn number, or 0 for a rank without a target."""
    answer: Annotated[str, Meta(pattern=f"^({'|'.join((LOT, *Verdict.__members__))})$")] = field(name="verdict")
    """Name of a verdict, or LOT."""
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
    reach_m: float | tuple[float, ...] = 0.3
    """Reach of all hunters, or by seat (R2.7) [m]."""
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

    @property
    def unusual(self) -> list[str]:
        """Names of the circumstances that differ from the defaults."""
        return [key for key, value in self.circumstances.items() if value != DEFAULTS[key]]

    @property
    def size(self) -> int:
        """Number of hunters, targets, requests, and unusual circumstances."""
        return len(self.hunters) + len(self.targets) + len(self.expected) + len(self.unusual)

    def arguments(self) -> dict[str, Any]:
        """Return the keyword arguments of `arbitrate`, in new containers, since the code under test may change them.

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


class CaseStep(_Table, frozen=True, kw_only=True):
    """One part of an arena's case: events in the arena, in the order of these fields."""

    reset: bool = False
    hunters: tuple[tuple[float, float, float], ...] | None = None
    """Poses to place, (x, y, theta) by seat, together with `targets`; None places nothing."""
    targets: tuple[Place, ...] = ()
    withdraw: Whole | None = None
    withdraw_prey: Whole | None = None
    """Index of the prey to withdraw."""
    steps: Whole = 0
    """Number of steps without commands and requests."""
    drive: tuple[tuple[Whole, float, float], ...] = ()
    """Commands (seat, v [m/s], w [rad/s]) in the step of the requests; hunters without one stand still."""
    drive_prey: tuple[tuple[Whole, float, float], ...] = ()
    """Commands (index, v [m/s], w [rad/s]) of prey in the step of the requests; prey without one stands still."""
    expected: tuple[RulingByNumber, ...] | None = field(name="requests", default=None)
    """The requests of one more step, with their rulings: empty for a step without requests, None for no step."""
    read: dict[str, Any] = {}
    """The expected state of the arena after the step, by the keys of `ArenaUnderTest.read`."""


class ArenaCase(Case, frozen=True, kw_only=True):
    """One part of a match, for adjudicators that have an arena: spawning, time and identity."""

    given: dict[str, Any] = field(name="settings")
    """Settings of the arena: fields of ArenaConfig, and the failures of `ArenaUnderTest.reset`."""
    play: tuple[CaseStep, ...]

    @property
    def settings(self) -> dict[str, Any]:
        """The given settings of the arena, with the number of hunters, in new containers."""
        given = {"hunters": 1} | deepcopy(self.given)
        return {key: None if value == NEVER else value for key, value in given.items()}

    @property
    def size(self) -> int:
        """Number of settings, and of parts of the play."""
        return len(self.given) + len(self.play)


class _File(_Table, frozen=True, kw_only=True):
    """Content of one .toml file."""

    case: tuple[ArbiterCase, ...] = ()
    arena_case: tuple[ArenaCase, ...] = ()


@cache
def load_cases() -> tuple[ArbiterCase | ArenaCase, ...]:
    """Return all cases of the suite, file by file, in the order of each file."""
    found: list[ArbiterCase | ArenaCase] = []
    for path in sorted((files("catch_arena.conformance") / "cases").iterdir(), key=lambda path: path.name):
        if path.name.endswith(".toml"):
            try:
                content = convert(tomllib.loads(path.read_text(encoding="utf-8")), _File)
            except ValueError as error:  # as are the errors of tomllib and of msgspec
                raise ConfigError(f"{path.name}: {error}") from None
            found += (*content.case, *content.arena_case)
    return tuple(found)
