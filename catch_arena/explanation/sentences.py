"""The facts of an explanation as sentences, each with its clause."""

from collections.abc import Iterable, Sequence
from typing import Final

from catch_arena.explanation.formatting import exact_length, metres
from catch_arena.explanation.match_summary import Claim, Contest, Explanation, HunterSummary, Refusals
from catch_arena.explanation.sight import Unseen
from catch_arena.explanation.step_explanation import HunterAction, StepExplanation
from catch_arena.verdicts import REASONS, Verdict

_EMPTY_RANK: Final = "a rank that no target in its view has"
_LEFT: Final = {"withdrawn": "It was withdrawn (R1.6)", "dropped out": "It had dropped out (R1.7)"}
_MOST_UNSEEN: Final = 3
_NO_CONTEST: Final = "No contest: in no step could two hunters have caught the same target."


def paragraphs(explanation: Explanation) -> list[str]:
    """A whole match: its heading, what happened, and the hunters, with an empty line between them."""
    events = [(one.step, 0, contest_sentence(one, explanation.names)) for one in explanation.contests]
    events += [(run.first_step, 1, _refusals(run, explanation)) for run in explanation.refusals]
    found = [text for _, _, text in sorted(events)]
    if not explanation.contests:
        found.append(
            _NO_CONTEST
            if len(explanation.records) == len(explanation.names)
            else f"No contest of {explanation.records[0].name}."
        )
    return [
        _opening(explanation),
        "",
        *found,
        "",
        *(_summary_sentence(summary, explanation.policy) for summary in explanation.records),
    ]


def step_paragraphs(explanation: StepExplanation) -> list[str]:
    """One step."""
    begin, end = _seconds(explanation.begin_ms), _seconds(explanation.end_ms)
    return [
        f"Step {explanation.step}, from {begin} to {end}: requests are judged on the state at {begin} (R5.1).",
        *(_asked(one, explanation) for one in explanation.asked),
        *(_distances(target, explanation) for target in explanation.distances_um),
        *(contest_sentence(contest, explanation.names) for contest in explanation.contests),
    ]


def contest_sentence(contest: Contest, names: Sequence[str]) -> str:
    """One contest: who asked for what, from where, what decides, and the verdicts."""
    winner, *losers = contest.claims
    asked = _listed(names[claim.seat] for claim in contest.claims)
    asked = f"At {_seconds(contest.time_ms)} (step {contest.step}) {asked} asked for {contest.target}"
    if contest.clause == "R9.1":
        return f"{asked}: the capstone's service says yes to each of them, GRANTED (R9.1)."
    places = [f"{names[winner.seat]} was {metres(winner.distance_um)} away"]
    places += [f"{names[claim.seat]} {metres(claim.distance_um)}, {_compared(claim, winner)}" for claim in losers]
    outcome = (
        f"{names[winner.seat]} is granted it"
        if winner.verdict is Verdict.GRANTED
        else f"{names[winner.seat]} gets KILL_FAILED, as the simulator refuses the kill (R5.7)"
    )
    lost = (
        f"{_listed(names[claim.seat] for claim in losers)} {'get' if len(losers) > 1 else 'gets'} LOST_CONTEST (R5.6)"
    )
    return f"{asked}. {'; '.join(places)}. {_decision(contest, names)}: {outcome}, {lost}."


def _decision(contest: Contest, names: Sequence[str]) -> str:
    if contest.clause == "R5.4":
        return "The smaller distance decides (R5.4)"
    lots = _listed(f"{names[claim.seat]} {claim.lot:016x}" for claim in contest.claims if claim.lot is not None)
    if contest.clause == "R5.5":
        return f"An exact tie is drawn by lot, and the lowest lot wins (R5.5): {lots}"
    return f"The step's lots decide, and the lowest is served first (R5.9): {lots}"


def _compared(claim: Claim, winner: Claim) -> str:
    more = (claim.distance_um or 0) - (winner.distance_um or 0)
    if more == 0:
        return "just as far"
    return f"{exact_length(abs(more))} {'farther' if more > 0 else 'nearer'}"


def _refusals(run: Refusals, explanation: Explanation) -> str:
    if run.times == 1:
        when, often = f"At {_seconds(run.first_ms)} (step {run.first_step})", "asked"
    else:
        when = f"From {_seconds(run.first_ms)} to {_seconds(run.last_ms)} (steps {run.first_step} to {run.last_step})"
        often = f"asked {run.times} times"
    what = f"{len(run.targets)} targets" if len(run.targets) > 1 else "".join(run.targets) or _EMPTY_RANK
    place = ""
    if run.nearest_um is not None:
        farthest = "" if run.nearest_um == run.farthest_um else f" to {metres(run.farthest_um)}"
        place = f" from {metres(run.nearest_um)}{farthest}"
    limit = (
        f"; within reach is less than {metres(explanation.reaches_um[run.seat])}"
        if run.verdict is Verdict.OUT_OF_REACH
        else ""
    )
    asked = f"{when} {explanation.names[run.seat]} {often} for {what}{place}"
    return f"{asked}: {run.verdict.name}, {REASONS[run.verdict]}{limit}."


def _opening(explanation: Explanation) -> str:
    scores = (f"{name} {score}" for name, score in zip(explanation.names, explanation.scores, strict=True))
    title = f"{explanation.title}: " if explanation.title else ""
    return (
        f"{title}{_counted(explanation.steps, 'step')}, {_seconds(explanation.duration_ms)}, "
        f"policy {explanation.policy}. Catches: {_listed(scores)}."
    )


def _summary_sentence(summary: HunterSummary, policy: str) -> str:
    parts = [_counted(summary.catches, "catch", "catches")]
    if policy != "capstone":  # where nobody loses
        for count, what, by in (
            (summary.contests_won, "won", summary.won_by_um),
            (summary.contests_lost, "lost", summary.lost_by_um),
        ):
            average = "" if by is None or policy != "nearest" else f", by {exact_length(by)} on average"
            parts.append(f"{_counted(count, 'contest')} {what}{average}")
    if summary.refused:
        reasons = ", ".join(f"{count} {verdict}" for verdict, count in summary.refused.items())
        parts.append(f"{_counted(sum(summary.refused.values()), 'request')} refused ({reasons})")
    if summary.forestalled:
        parts.append(f"{_counted(summary.forestalled, 'target')} that it was heading for caught by others first")
    if summary.never_seen:
        parts.append(f"{_counted(summary.never_seen, 'target')} that it never had in sight caught by others (R7.5)")
    if summary.withdrawn_ms is not None:
        how = "dropped out at {} (R1.7)" if summary.dropped_out else "withdrawn at {} (R1.6)"
        parts.append(how.format(_seconds(summary.withdrawn_ms)))
    return f"{summary.name}: {'; '.join(parts)}."


def _asked(one: HunterAction, explanation: StepExplanation) -> str:
    chosen = f" ({one.chosen})" if one.chosen else ""
    seat = f"hunter_{one.seat}"
    who = seat if explanation.names[one.seat] == seat else f"{explanation.names[one.seat]} ({seat})"
    did = f"{who}, {one.control} control: {one.action}{chosen}."
    return " ".join((did, *filter(None, (_left(one), _requested(one, explanation), _sight(one, explanation)))))


def _left(one: HunterAction) -> str:
    return f"{_LEFT[one.out]}." if one.out is not None else ""


def _requested(one: HunterAction, explanation: StepExplanation) -> str:
    if one.verdict is None:
        return "It requested nothing."
    what = one.target or _EMPTY_RANK
    place = "" if one.distance_um is None else f" from {metres(one.distance_um)}"
    winner = (
        f"; the winner is {explanation.names[one.winner]}"
        if one.verdict is Verdict.LOST_CONTEST and one.winner is not None
        else ""
    )
    return f"It requested {what}{place}: {one.verdict.name}, {one.reason}{winner}."


def _sight(one: HunterAction, explanation: StepExplanation) -> str:
    """What was out of its sight, the nearest first, and why; nothing where it saw every target."""
    if not one.unseen:
        return ""
    limits = []
    if explanation.view_radius_m is not None:
        limits.append(f"nearer than {explanation.view_radius_m:g} m")
    if explanation.view_angle_deg < 360.0:
        limits.append(f"at most {explanation.view_angle_deg / 2.0:g} degrees off its heading")
    shown = [_out_of_sight(target) for target in one.unseen[:_MOST_UNSEEN]]
    if more := len(one.unseen) - len(shown):
        shown.append(f"{more} more")
    saw = f"{one.seen} of {_counted(one.seen + len(one.unseen), 'target')}"
    return f"It sees what is {_listed(limits)} (R7.5): {saw}. Out of its sight: {'; '.join(shown)}."


def _out_of_sight(one: Unseen) -> str:
    why = ["too far"] if one.too_far else []
    if one.outside_cone:
        side = "behind it" if one.off_heading_deg > 90.0 else "to its side"
        why.append(f"{side}, {one.off_heading_deg:.1f} degrees off its heading")
    return f"{one.target}, {metres(one.distance_um)} away, {' and '.join(why)}"


def _distances(target: str, explanation: StepExplanation) -> str:
    hidden = explanation.out_of_sight[target]
    ranked = sorted(
        (distance, name, " (out of its sight)" if seat in hidden else "")
        for seat, (distance, name) in enumerate(zip(explanation.distances_um[target], explanation.names, strict=True))
    )
    told = _listed(f"{name} {metres(distance)}{unseen}" for distance, name, unseen in ranked)
    return f"Distances to {target}: {told}."


def _listed(words: Iterable[str]) -> str:
    """«a, b and c»."""
    *most, last = words
    return f"{', '.join(most)} and {last}" if most else last


def _counted(count: int, one: str, many: str | None = None) -> str:
    return f"{count} {one if count == 1 else many or one + 's'}"


def _seconds(milliseconds: int) -> str:
    """To the tenth, or to the millisecond where that is needed."""
    return f"{milliseconds / 1000:.1f} s" if milliseconds % 100 == 0 else f"{milliseconds / 1000:.3f} s"
