"""Sentences about facts, each with its clause, and their parts."""

from collections.abc import Iterable, Sequence
from typing import Final

from catch_arena.config import ArbitrationPolicy
from catch_arena.explanation.facts import Claim, Contest, HunterSummary, PreySummary
from catch_arena.explanation.formatting import metres, millimetres, seconds
from catch_arena.explanation.seats import with_seat
from catch_arena.replay.named_requests import describe_name
from catch_arena.text import counted
from catch_arena.verdicts import Verdict

_DECISIONS: Final = {
    "R5.4": "The smaller distance decides",
    "R5.5": "The distances are equal, so the lowest lot decides",
    "R5.9": "The lowest lot of the step decides",
}
"""Reason for the winner of a contest, by clause."""


def contest_sentence(contest: Contest, names: Sequence[str], prey: str | None) -> str:
    """Return one contest in words: the hunters, the target, the distances, the deciding clause and the verdicts.

    `names` are the labels of the hunters, by seat, and `prey` that of the prey that played the target, if any.
    """
    winner, *losers = contest.claims
    intro = listed(names[claim.seat] for claim in contest.claims)
    intro = (
        f"At {seconds(contest.judged_ms)} (step {contest.step}) {intro} asked for {target_label(contest.target, prey)}"
    )
    if contest.clause == "R9.1":
        return f"{intro}: the capstone's service grants each of them, GRANTED (R9.1)."
    places = [f"{names[claim.seat]} was {_place(claim, winner)}" for claim in contest.claims]
    outcome = (
        f"{names[winner.seat]} catches it"
        if winner.verdict is Verdict.GRANTED
        else f"{names[winner.seat]} gets KILL_FAILED, because the simulator refuses the kill (R5.7)"
    )
    lost = listed(f"{names[claim.seat]}{' (a team-mate, R11.3)' if claim.mate else ''}" for claim in losers)
    decision = f"{_DECISIONS[contest.clause]} ({contest.clause}): {outcome}"
    return f"{intro}. {'; '.join(places)}. {decision}. LOST_CONTEST (R5.6): {lost}."


def _place(claim: Claim, winner: Claim) -> str:
    """Return the distance of a hunter of a contest in words, compared with the winner's, and its lot if it has one."""
    parts = [f"{metres(claim.distance_um)} away"]
    if claim.seat != winner.seat:
        more = (claim.distance_um or 0) - (winner.distance_um or 0)
        compared = f"{metres(abs(more))} {'farther' if more > 0 else 'nearer'}"
        parts.append(compared if more else "the same distance")
    if claim.lot is not None:
        parts.append(f"lot {claim.lot:016x}")
    return ", ".join(parts)


def margin_phrase(contest: Contest) -> str:
    """Return how the winner of a contest was preferred to the second claim: "by 11 mm", or "by lot"."""
    behind_um = contest.behind_um(contest.claims[1])
    return "by lot" if behind_um is None else f"by {millimetres(behind_um)}"


def target_label(target: str, prey: str | None) -> str:
    """Return the name of a target, with the label of the prey that plays it."""
    return target if prey is None else f"{target}, played by {prey}"


def request_phrase(
    target: str | None,
    verdict: Verdict,
    distances_um: tuple[int | None, int | None],
    reach_um: int,
    *,
    by_name: bool,
    prey: str | None = None,
) -> str:
    """Return a requested target, the smallest and the largest distance to it, and the verdict with its reason, in
    words. A distance that was not measured is None. `by_name`: the request has a name instead of a rank (R8.4); a rank
    without a target, and a name that was no string, have None as the target.
    """
    if by_name:
        asked_for = describe_name(target)
    else:
        asked_for = "a rank without a target in its view" if target is None else target_label(target, prey)
    nearest, farthest = distances_um
    place = "" if nearest is None else f" from {metres(nearest)}"
    place += "" if nearest == farthest else f" to {metres(farthest)}"
    limit = f"; within reach is less than {metres(reach_um)}" if verdict is Verdict.OUT_OF_REACH else ""
    return f"{asked_for}{place}: {verdict.name}, {verdict.reason}{limit}"


def prey_sentence(summary: PreySummary) -> str:
    """Return the summary of one prey in words."""
    parts = [f"caught {counted(summary.times_caught, 'time')}"]
    if summary.out:
        parts.append("out at the end")
    if summary.withdrawn_ms is not None:
        parts.append(f"withdrawn at {seconds(summary.withdrawn_ms)} (R12.5)")
    return f"{summary.name}: {'; '.join(parts)}."


def summary_sentence(summary: HunterSummary, policy: ArbitrationPolicy) -> str:
    """Return the summary of one hunter in words."""
    parts = [counted(summary.catches, "catch", "catches")]
    if policy != "capstone":  # under capstone no hunter loses
        parts += [
            f"{counted(summary.contests_won, 'contest')} won",
            f"{counted(summary.contests_lost, 'contest')} lost",
        ]
        if summary.contests_lost_to_mates:
            parts[-1] += f", {summary.contests_lost_to_mates} to its own team-mates (R11.3)"
    if summary.refused:
        reasons = ", ".join(f"{count} {verdict}" for verdict, count in summary.refused.items())
        parts.append(f"{counted(sum(summary.refused.values()), 'request')} refused ({reasons})")
    if summary.forestalled:
        parts.append(f"others caught {counted(summary.forestalled, 'target')} that it was driving to")
    if summary.withdrawn_ms is not None:
        parts.append(f"{summary.out} at {seconds(summary.withdrawn_ms)}")
    return f"{with_seat(summary.name, summary.seat)}: {'; '.join(parts)}."


def listed(words: Iterable[str]) -> str:
    """Return words as a list, such as «a, b and c»."""
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last
