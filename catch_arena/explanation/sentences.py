"""Facts as sentences, each with its clause."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Final

from catch_arena.config import ArbitrationPolicy
from catch_arena.explanation.facts import (
    Capture,
    Claim,
    Contest,
    HunterAction,
    HunterSummary,
    PreyAction,
    PreySummary,
    Refusals,
)
from catch_arena.explanation.formatting import exact_length, metres, seconds
from catch_arena.explanation.seats import with_seat
from catch_arena.explanation.seen_targets import Unseen
from catch_arena.replay.named_requests import describe_name
from catch_arena.verdicts import REASONS, Verdict

if TYPE_CHECKING:
    from catch_arena.explanation.match_summary import Explanation
    from catch_arena.explanation.step_explanation import StepExplanation

_EMPTY_RANK: Final = "a rank without a target in its view"
_CONTEST_RULES: Final[dict[ArbitrationPolicy, str]] = {
    "nearest": "Contests go to the nearest hunter (R5.4)",
    "first_come": "Contests go to the hunter with the lowest lot of the step (R5.9)",
    "capstone": "The capstone's service grants every request (R9.1)",
}
_DECISIONS: Final = {
    "R5.4": "The smaller distance decides",
    "R5.5": "The distances are equal, so the lowest lot decides",
    "R5.9": "The lowest lot of the step decides",
}
"""Reason for the winner of a contest, by clause."""
_LEFT: Final = {"withdrawn": "It was withdrawn (R1.6)", "dropped out": "It had dropped out (R1.7)"}
_MOST_UNSEEN: Final = 3


def opening_sentence(match: "Explanation") -> str:
    """Return the length of a match, its rule for contests, and the catches of each team and hunter, in words."""
    heading = f"{match.title}: " if match.title else ""
    sums = [f"{team.name} {team.score}" for team in sorted(match.teams, key=lambda team: team.rank)]
    of_teams = f"Teams (R11.1): {listed(sums)}. " if sums else ""
    length = f"{_counted(match.steps, 'step')}, {seconds(match.duration_ms)}"
    caught = zip(match.names, match.scores, strict=True)
    catches = listed(f"{with_seat(name, seat)} {score}" for seat, (name, score) in enumerate(caught))
    needed = f"A catch needs {match.hunters_per_catch} hunters of one team (R5.10). "
    rules = f"{_CONTEST_RULES[match.policy]}. {needed if match.hunters_per_catch > 1 else ''}"
    return f"{heading}{length}. {rules}{of_teams}Catches: {catches}."


def contest_sentence(contest: Contest, names: Sequence[str], prey: str | None) -> str:
    """Return one contest in words: the hunters, the target, the distances, the deciding clause and the verdicts.

    Args:
        contest: the contest.
        names: the labels of the hunters, by seat.
        prey: the label of the prey that played the target; None if no prey did.
    """
    winner, *losers = contest.claims
    intro = listed(names[claim.seat] for claim in contest.claims)
    intro = (
        f"At {seconds(contest.judged_ms)} (step {contest.step}) {intro} asked for {_target_label(contest.target, prey)}"
    )
    if contest.clause == "R9.1":
        return f"{intro}: the capstone's service grants each of them, GRANTED (R9.1)."
    places = [f"{names[claim.seat]} was {_place(claim, winner)}" for claim in contest.claims]
    outcome = (
        f"{names[winner.seat]} catches it"
        if winner.verdict is Verdict.GRANTED
        else f"{names[winner.seat]} gets KILL_FAILED, because the simulator refuses the kill (R5.7)"
    )
    lost = f"{listed(names[claim.seat] for claim in losers)} {'get' if len(losers) > 1 else 'gets'} LOST_CONTEST (R5.6)"
    sentence = f"{intro}. {'; '.join(places)}. {_DECISIONS[contest.clause]} ({contest.clause}): {outcome}, and {lost}"
    return f"{sentence}{_lost_to_mate(contest, names)}."


def _lost_to_mate(contest: Contest, names: Sequence[str]) -> str:
    winner, *losers = contest.claims
    mates = [names[claim.seat] for claim in losers if claim.mate]
    if not mates:
        return ""
    subject = "it" if len(losers) == 1 else listed(mates)
    if contest.hunters_per_catch > 1:
        partners = "partners" if len(mates) > 1 else "partner"
        be = "are" if len(mates) > 1 and len(losers) > 1 else "is"
        needed = f"a catch needs {contest.hunters_per_catch} hunters of one team"
        return f": {subject} {be} the {partners} of {names[winner.seat]}, since {needed} (R5.10)"
    return f": {subject} lost to {'their' if len(mates) > 1 else 'its'} own team-mate (R11.3)"


def no_contest_sentence(match: "Explanation") -> str:
    """Return the sentence for no contest: in the match, or of the hunters and prey that the explanation is about."""
    if len(match.records) == len(match.names):
        return "No contest: no target was requested by two hunters within reach in the same step."
    sides = (("with", [summary.name for summary in match.records]), ("for", [summary.name for summary in match.prey]))
    return f"No contest {' or '.join(f'{side} {listed(called)}' for side, called in sides if called)}."


def _place(claim: Claim, winner: Claim) -> str:
    """Return the distance of a hunter of a contest in words, compared with the winner's, and its lot if it has one."""
    parts = [f"{metres(claim.distance_um)} away"]
    if claim.seat != winner.seat:
        more = (claim.distance_um or 0) - (winner.distance_um or 0)
        compared = f"{exact_length(abs(more))} {'farther' if more > 0 else 'nearer'}"
        parts.append(compared if more else "the same distance")
    if claim.lot is not None:
        parts.append(f"lot {claim.lot:016x}")
    return ", ".join(parts)


def refusals_sentence(run: Refusals, match: "Explanation") -> str:
    """Return one run of refusals in words: times, hunter, target and reason."""
    name, reach_um, prey = match.names[run.seat], match.reaches_um[run.seat], match.prey_by_target.get(run.target or "")
    if run.times == 1:
        when, request_phrase = f"At {seconds(run.first_ms)} (step {run.first_step})", "asked"
    else:
        when = f"From {seconds(run.first_ms)} to {seconds(run.last_ms)} (steps {run.first_step} to {run.last_step})"
        request_phrase = f"asked {run.times} times"
    farthest = "" if run.nearest_um == run.farthest_um else f" to {metres(run.farthest_um)}"
    place = f"{_from(run.nearest_um)}{farthest}"
    if run.by_name:
        target = describe_name(run.target)
    else:
        target = _EMPTY_RANK if run.target is None else _target_label(run.target, prey)
        target += "," if prey is not None and place else ""
    return f"{when} {name} {request_phrase} for {_verdict_phrase(target, place, run.verdict, reach_um)}."


def _target_label(target: str, prey: str | None) -> str:
    return target if prey is None else f"{target}, played by {prey}"


def _from(distance_um: int | None) -> str:
    return "" if distance_um is None else f" from {metres(distance_um)}"


def _verdict_phrase(target: str, place: str, verdict: Verdict, reach_um: int) -> str:
    """Return a requested target, the distance to it, and the verdict with its reason, in words."""
    limit = f"; within reach is less than {metres(reach_um)}" if verdict is Verdict.OUT_OF_REACH else ""
    return f"{target}{place}: {verdict.name}, {REASONS[verdict]}{limit}"


def capture_sentence(capture: Capture, match: "Explanation") -> str:
    """Return one capture of prey in words: the hunter, the distance, and the time of the return."""
    after = "; it did not return"
    if capture.returned_ms is not None:
        after = f"; it returned at {seconds(capture.returned_ms)} as {capture.returned_as}"
    hunter, prey = match.names[capture.seat], match.prey_names[capture.prey]
    place = "" if capture.distance_um is None else f",{_from(capture.distance_um)}"
    event = f"{hunter} caught {_target_label(capture.target, prey)}{place}"
    when = f"At {seconds(capture.judged_ms)} (step {capture.step})"
    return f"{when} {event}, after {seconds(capture.in_play_ms)} in play{after} (R12.3)."


def prey_sentence(summary: PreySummary) -> str:
    """Return the summary of one prey in words."""
    parts = [
        f"caught {_counted(summary.times_caught, 'time')}",
        f"returned {_counted(summary.returns, 'time')}",
        f"{seconds(summary.in_play_ms)} in play",
    ]
    if summary.out:
        parts.append("out at the end")
    if summary.withdrawn_ms is not None:
        parts.append(f"withdrawn at {seconds(summary.withdrawn_ms)} (R12.5)")
    return f"{summary.name}: {'; '.join(parts)}."


def summary_sentence(summary: HunterSummary, policy: ArbitrationPolicy) -> str:
    """Return the summary of one hunter in words."""
    parts = [_counted(summary.catches, "catch", "catches")]
    if policy != "capstone":  # under capstone no hunter loses
        for count, outcome, margin_um in (
            (summary.contests_won, "won", summary.won_by_um),
            (summary.contests_lost, "lost", summary.lost_by_um),
        ):
            average = "" if margin_um is None or policy != "nearest" else f", by {exact_length(margin_um)} on average"
            parts.append(f"{_counted(count, 'contest')} {outcome}{average}")
        if summary.contests_lost_to_mates:
            parts[-1] += f", {summary.contests_lost_to_mates} to its own team-mates (R11.3)"
    if summary.refused:
        reasons = ", ".join(f"{count} {verdict}" for verdict, count in summary.refused.items())
        parts.append(f"{_counted(sum(summary.refused.values()), 'request')} refused ({reasons})")
    if summary.forestalled:
        parts.append(f"others caught {_counted(summary.forestalled, 'target')} that it was driving to")
    if summary.never_seen:
        parts.append(f"others caught {_counted(summary.never_seen, 'target')} that it never saw (R7.5)")
    if summary.withdrawn_ms is not None:
        departure = "dropped out at {} (R1.7)" if summary.dropped_out else "withdrawn at {} (R1.6)"
        parts.append(departure.format(seconds(summary.withdrawn_ms)))
    return f"{with_seat(summary.name, summary.seat)}: {'; '.join(parts)}."


def action_sentences(hunter: HunterAction, step: "StepExplanation") -> str:
    """Return one hunter's action in a step in words, with its requests and the targets out of its sight."""
    chosen = f" ({hunter.chosen})" if hunter.chosen else ""
    sentences = [
        f"{with_seat(step.names[hunter.seat], hunter.seat)}, {hunter.control} control: {hunter.action}{chosen}."
    ]
    if hunter.out is not None:
        sentences.append(f"{_LEFT[hunter.out]}.")
    sentences.append(_requested(hunter, step))
    if hunter.unseen:
        sentences.append(_sight(hunter, step))
    return " ".join(sentences)


def prey_action_sentences(prey: PreyAction, names: Sequence[str]) -> str:
    """Return one prey's action in a step in words, with its capture and return."""
    if prey.withdrawn:
        parts = ["withdrawn (R12.5)."]
    elif prey.target is None:
        parts = ["out (R12.3)."]
    else:
        parts = [f"{prey.action}, as {prey.target}."]
    if prey.caught_by is not None:
        parts.append(f"It was caught by {names[prey.caught_by]} (R12.3).")
    if prey.returned_as is not None:
        parts.append(f"It returned as {prey.returned_as}.")
    return f"{prey.name}: {' '.join(parts)}"


def _requested(hunter: HunterAction, step: "StepExplanation") -> str:
    parts, reach_um = [], step.reaches_um[hunter.seat]
    if (ruling := hunter.ruling) is not None:
        winner = ""
        if ruling.verdict is Verdict.LOST_CONTEST and ruling.winner is not None:
            mate = ", its own team-mate (R11.3)" if hunter.mate else ""
            winner = f"; the winner is {step.names[ruling.winner]}{mate}"
        target = _EMPTY_RANK if ruling.target is None else str(ruling.target)
        parts.append(f"{_verdict_phrase(target, _from(ruling.distance_um), ruling.verdict, reach_um)}{winner}")
    for ruling_by_name in hunter.by_name:
        name = describe_name(None if ruling_by_name.target is None else str(ruling_by_name.target))
        parts.append(_verdict_phrase(name, _from(ruling_by_name.distance_um), ruling_by_name.verdict, reach_um))
    return f"It requested {'; then '.join(parts) or 'nothing'}."


def _sight(hunter: HunterAction, step: "StepExplanation") -> str:
    """Return the targets out of a hunter's sight in words, the nearest first, with the reasons."""
    limits = []
    if step.view_radius_m is not None:
        limits.append(f"nearer than {step.view_radius_m:g} m")
    if step.view_angle_deg < 360.0:
        limits.append(f"at most {step.view_angle_deg / 2.0:g} degrees off its heading")
    shown = [_out_of_sight(target) for target in hunter.unseen[:_MOST_UNSEEN]]
    if more := len(hunter.unseen) - len(shown):
        shown.append(f"{more} more")
    saw = f"{hunter.seen} of {_counted(hunter.seen + len(hunter.unseen), 'target')}"
    return f"It sees targets that are {listed(limits)} (R7.5): {saw}. Out of its sight: {'; '.join(shown)}."


def _out_of_sight(target: Unseen) -> str:
    why = ["too far"] if target.too_far else []
    if target.outside_cone:
        side = "to its rear" if target.off_heading_deg > 90.0 else "to its side"
        why.append(f"{side}, {target.off_heading_deg:.1f} degrees off its heading")
    return f"{target.target}, {metres(target.distance_um)} away, {' and '.join(why)}"


def distances_sentence(target: str, step: "StepExplanation") -> str:
    """Return the distance of every hunter to one target in words, the nearest first."""
    ranked = sorted(
        (distance, name, " (out of its sight)" if seat in step.out_of_sight[target] else "")
        for seat, (distance, name) in enumerate(zip(step.distances_um[target], step.names, strict=True))
    )
    distances = listed(f"{name} {metres(distance)}{unseen}" for distance, name, unseen in ranked)
    prey = step.prey_by_target.get(target)
    player = f", played by {prey}" if prey is not None else ""
    return f"Distances to {target}{player}: {distances}."


def listed(words: Iterable[str]) -> str:
    """Return words as a list, such as «a, b and c»."""
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def _counted(count: int, singular: str, plural: str | None = None) -> str:
    return f"{count} {singular if count == 1 else plural or singular + 's'}"
