"""Data of explanations: contests, refusals and captures, summaries of hunters and prey, and actions in a step."""

from dataclasses import dataclass, field
from typing import Any

from catch_arena.verdicts import Ruling, Verdict


@dataclass(frozen=True, slots=True)
class Claim:
    """One hunter's part in a contest."""

    seat: int
    verdict: Verdict
    distance_um: int | None
    """Distance at the beginning of the step (R5.3); None under the policy `capstone`, which does not measure."""
    lot: int | None = None
    """Lot of the claim, of which the lowest wins (R5.5, R5.9); None if no lot decided."""
    mate: bool = False
    """True if the hunter lost to its own team-mate (R11.3)."""


@dataclass(frozen=True, slots=True)
class Contest:
    """Contest: several hunters could have caught one target in one step."""

    step: int
    """Number of the step, from 1."""
    judged_ms: int
    """Time at which the contest was judged [ms since reset]: the beginning of the step (R1.4)."""
    target: str
    clause: str
    """Clause that decided the contest: R5.4 the distance, R5.5 a lot among equally near hunters, R5.9 the queue of
    `first_come`, R9.1 the capstone's service, which refuses no claim.
    """
    claims: tuple[Claim, ...]
    """Claims of all hunters in the contest: the winner's, those of other teams by distance, those of its team-mates. A
    team-mate that was as near as the winner, so that a lot decided, comes among the others.
    """

    @property
    def between_teams(self) -> bool:
        """True if the winner caught the target, and a hunter of another team lost it (R11.3)."""
        winner, second = self.claims[:2]
        return winner.verdict is Verdict.GRANTED and second.verdict is Verdict.LOST_CONTEST and not second.mate

    @property
    def margin_um(self) -> int | None:
        """Distance of the second claim minus that of the winner; negative if a lot preferred a farther hunter."""
        first, second = (claim.distance_um for claim in self.claims[:2])
        return None if first is None or second is None else second - first

    def behind_um(self, claim: Claim) -> int | None:
        """Return how much farther away than the winner the hunter of a claim was; None if a lot preferred the winner,
        or if nothing was measured.
        """
        behind = (claim.distance_um or 0) - (self.claims[0].distance_um or 0)
        return behind if behind > 0 and self.clause in ("R5.4", "R5.5") else None


@dataclass(slots=True)
class Refusals:
    """Run of one hunter's requests for one target that were refused for the same reason. A catch or contest of the
    hunter ends it.
    """

    seat: int
    verdict: Verdict
    first_step: int
    last_step: int
    first_ms: int
    """Time at which the first request was judged [ms since reset]: the beginning of its step (R1.4)."""
    last_ms: int
    target: str | None
    """Name of the target; None for a rank without a target, or a requested name that was no string."""
    by_name: bool = False
    """True if the requests were by name, without a rank (R8.4)."""
    times: int = 0
    nearest_um: int | None = None
    farthest_um: int | None = None


@dataclass(slots=True)
class HunterSummary:
    """Summary of one hunter's match."""

    seat: int
    name: str
    catches: int = 0
    contests_won: int = 0
    contests_lost: int = 0
    contests_lost_to_mates: int = 0
    """Number of the lost contests that a team-mate won (R11.3)."""
    refused: dict[str, int] = field(default_factory=dict)
    """Number of requests refused for other reasons, by verdict."""
    forestalled: int = 0
    """Number of its active targets that another hunter caught without a contest between them."""
    withdrawn_ms: int | None = None
    out: str | None = None
    """Reason for leaving: "withdrawn (R1.6)" or "dropped out (R1.7)"; None if the hunter stayed."""


@dataclass(frozen=True, slots=True)
class Catch:
    """One catch, and the scores after its step."""

    judged_ms: int
    """Time at which the catch was judged [ms since reset]: the beginning of the step (R1.4)."""
    seat: int
    scores: tuple[int, ...]
    """Scores after the step: of the teams, or of the hunters if there are no teams."""


@dataclass(frozen=True, slots=True)
class TeamSummary:
    """Result of one team (R11.1)."""

    name: str
    seats: tuple[int, ...]
    score: int


@dataclass(slots=True)
class Capture:
    """One catch of a prey (R12.3)."""

    prey: int
    """Index of the prey."""
    step: int
    """Number of the step, from 1."""
    judged_ms: int
    """Time at which the catch was judged [ms since reset]: the beginning of the step (R1.4)."""
    seat: int
    """Seat of the hunter that caught the prey."""
    target: str
    """Name of the target that the prey played."""
    distance_um: int | None
    """Distance at the beginning of the step (R5.3); None under the policy `capstone`, which does not measure."""
    in_play_ms: int
    """Time for which the prey had been in play [ms]."""
    returned_ms: int | None = None
    """Time of the return [ms since reset]; None if the prey did not return before the end."""
    returned_as: str | None = None


@dataclass(slots=True)
class PreySummary:
    """Summary of one prey's match."""

    index: int
    name: str
    times_caught: int = 0
    out: bool = False
    """True if the prey is out at the end."""
    withdrawn_ms: int | None = None


@dataclass(frozen=True, slots=True)
class Unseen:
    """A target that a hunter did not see (R7.5)."""

    target: str
    distance_um: int
    off_heading_deg: float
    """Angle between the hunter's heading and the target's direction [degrees], 0 to 180."""


@dataclass(frozen=True, slots=True)
class HunterAction:
    """Action of one hunter in a step, and the rulings on its requests."""

    seat: int
    control: str
    action: str
    """Action in words."""
    chosen: str | None
    """Target of the rank in the action; None if the rank has no target, or the hunter takes no part."""
    ruling: Ruling | None
    """Ruling on the request; None without a request."""
    out: str | None
    """Reason for taking no part: "withdrawn (R1.6)" or "dropped out (R1.7)"; None if the hunter took part."""
    seen: int
    """Number of targets that the hunter saw (R7.5)."""
    unseen: tuple[Unseen, ...]
    """Targets that the hunter did not see, the nearest first."""
    by_name: tuple[Ruling, ...]
    """R8.4: Rulings on the hunter's requests by name, in their order."""


@dataclass(frozen=True, slots=True)
class PreyAction:
    """Action of one prey in a step, and its capture or return."""

    index: int
    name: str
    action: str
    """Action in words."""
    target: str | None
    """Target that the prey played at the beginning of the step; None while it was out."""
    caught_by: int | None
    """Seat of the hunter that caught the prey in this step; None if no hunter did."""
    returned_as: str | None
    """Target as which the prey returned at the step's end (R12.3); None if it did not return."""
    withdrawn: bool


def json_ready(value: Any) -> Any:
    """Return a part of a dict of facts as a JSON-ready value: verdicts by name, and lots in hexadecimal digits, since
    JSON readers may lack 64-bit integers.
    """
    if isinstance(value, Verdict):
        return value.name
    if isinstance(value, dict):
        return {
            key: f"{part:016x}" if key == "lot" and part is not None else json_ready(part)
            for key, part in value.items()
        }
    return [json_ready(part) for part in value] if isinstance(value, list | tuple) else value
