"""What is told of a match: contests, refusals, what became of each hunter, and what each did in a step."""

from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Final

from catch_arena.explanation.seen_targets import Unseen
from catch_arena.verdicts import Verdict

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

_JSON_KEYS: Final = {"hunters": "asked", "prey_by_target": "played"}
"""Fields that have other names in JSON."""


@dataclass(frozen=True, slots=True)
class Claim:
    """One hunter's part in a contest."""

    seat: int
    verdict: Verdict
    distance_um: int | None
    """At the step's beginning (R5.3); None under the policy `capstone`, which does not measure."""
    lot: int | None = None
    """Where a lot decided (R5.5, R5.9): its word, of which the lowest wins."""
    mate: bool = False
    """It lost to its own team-mate (R11.3)."""


@dataclass(frozen=True, slots=True)
class Contest:
    """Several hunters could have caught one target in one step."""

    step: int
    """Counted from 1."""
    judged_ms: int
    """When it was judged: the step's beginning (R1.4)."""
    target: str
    clause: str
    """What decided: R5.4 the distance, R5.5 a lot among equally near ones, R5.9 the queue of `first_come`, R9.1 that
    the capstone's service refuses nobody.
    """
    claims: tuple[Claim, ...]
    """The winner first, then the nearer ones first."""

    @property
    def margin_um(self) -> int | None:
        """How much nearer the winner was than the nearest loser; negative where a lot preferred a farther one."""
        first, second = (claim.distance_um for claim in self.claims[:2])
        return None if first is None or second is None else second - first


@dataclass(slots=True)
class Refusals:
    """One hunter's requests for one target that were refused for the same reason, with no catch and no contest of its
    own between, and no other target asked for by rank.
    """

    seat: int
    verdict: Verdict
    first_step: int
    last_step: int
    first_ms: int
    """When the first of them was judged: the step's beginning (R1.4)."""
    last_ms: int
    target: str | None
    """None where the rank that was asked for had none, or no text was given."""
    by_name: bool = False
    """Whether no rank stood for it (R8.4)."""
    other_names: bool = False
    """Whether these are requests for several names: those beyond the first few that the hunter asked for."""
    times: int = 0
    nearest_um: int | None = None
    farthest_um: int | None = None


@dataclass(slots=True)
class HunterSummary:
    """What became of one hunter."""

    seat: int
    name: str
    catches: int = 0
    contests_won: int = 0
    contests_lost: int = 0
    won_by_um: float | None = None
    """How much nearer than the nearest rival it was in the contests that it won, on average."""
    contests_lost_to_mates: int = 0
    """Of those that it lost (R11.3)."""
    lost_by_um: float | None = None
    """How much nearer the winner was in those that it lost, on average."""
    refused: dict[str, int] = field(default_factory=dict)
    """Requests refused for other reasons, by verdict."""
    forestalled: int = 0
    """Targets that it was heading for, and that another hunter caught without a contest between them."""
    never_seen: int | None = None
    """Targets that another hunter caught, and that it never had in sight (R7.5); None where hunters see everything."""
    withdrawn_ms: int | None = None
    dropped_out: bool = False
    """It left by chance (R1.7), and was not withdrawn (R1.6)."""


@dataclass(frozen=True, slots=True)
class TeamSummary:
    """What a team has (R11.1)."""

    name: str
    seats: tuple[int, ...]
    score: int
    rank: int


@dataclass(slots=True)
class Capture:
    """One prey was caught (R12.3)."""

    prey: int
    """Its index."""
    step: int
    """Counted from 1."""
    judged_ms: int
    """When the catch was judged: the step's beginning (R1.4)."""
    seat: int
    """Who caught it."""
    target: str
    """Which it was to the arbiter."""
    distance_um: int | None
    """At the step's beginning (R5.3); None under the policy `capstone`, which does not measure."""
    in_play_ms: int
    """For how long it had been in play."""
    returned_ms: int | None = None
    """When it returned; None where it did not before the end."""
    returned_as: str | None = None


@dataclass(slots=True)
class PreySummary:
    """What became of one prey."""

    index: int
    name: str
    times_caught: int = 0
    returns: int = 0
    in_play_ms: int = 0
    """For how long in all (R12.5)."""
    out: bool = False
    """At the end."""
    withdrawn_ms: int | None = None


@dataclass(frozen=True, slots=True)
class Answer:
    """What a hunter asked for by name, beside the rank of its action, and the verdict (R8.4)."""

    target: str | None
    verdict: Verdict
    reason: str
    distance_um: int | None


@dataclass(frozen=True, slots=True)
class HunterAction:
    """What one hunter did in a step, and the answer."""

    seat: int
    control: str
    action: str
    """In words."""
    chosen: str | None
    """The target of the rank that it named; None without one."""
    target: str | None
    """What it requested; None where it requested nothing, or a rank without a target."""
    verdict: Verdict | None
    """None where it requested nothing."""
    reason: str | None
    distance_um: int | None
    """The arbiter's evidence: None unless reach was tested."""
    winner: int | None
    mate: bool
    """It lost to its own team-mate (R11.3)."""
    out: str | None
    """Why it took no part: "withdrawn" (R1.6) or "dropped out" (R1.7); None for one that did."""
    seen: int
    """How many targets it saw (R7.5)."""
    unseen: tuple[Unseen, ...]
    """Those that it did not, the nearest first."""
    by_name: tuple[Answer, ...]
    """What else it requested, in its order."""


@dataclass(frozen=True, slots=True)
class PreyAction:
    """What one prey did in a step, and what became of it."""

    index: int
    name: str
    action: str
    """In words."""
    target: str | None
    """Which it was when the step began; None while it was out."""
    caught_by: int | None
    """The seat of who caught it in this step."""
    returned_as: str | None
    """The target that it returned as at the step's end (R12.3)."""
    withdrawn: bool


def facts_as_json(facts: "DataclassInstance") -> dict[str, Any]:
    """JSON-ready: verdicts by name, lots in hexadecimal digits, distances in micrometres."""
    return {_JSON_KEYS.get(name, name): json_ready(value) for name, value in asdict(facts).items()}


def json_ready(value: Any) -> Any:
    """Verdicts by name, lots as hexadecimal digits: a program that reads JSON may not know 64-bit integers."""
    if isinstance(value, Verdict):
        return value.name
    if isinstance(value, dict):
        return {
            key: f"{part:016x}" if key == "lot" and part is not None else json_ready(part)
            for key, part in value.items()
        }
    return [json_ready(part) for part in value] if isinstance(value, list | tuple) else value
