"""Wrong rules, to be exchanged for those of chapter 5: what the known mistakes are made of."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from catch_arena.conformance.answers import OtherTarget, shown
from catch_arena.conformance.rules import Claim, Step, nearest
from catch_arena.verdicts import Verdict

Finish = Callable[[Claim, Step], None]
Order = tuple[Verdict, ...]

# Who wins


def everybody(eligible: Sequence[Claim], _: Step) -> Sequence[Claim]:
    """All that are eligible."""
    return eligible


def first(eligible: Sequence[Claim], _: Step) -> Claim:
    """Whoever asked first."""
    return eligible[0]


def last(eligible: Sequence[Claim], _: Step) -> Claim:
    """Whoever asked last."""
    return eligible[-1]


def low_seat(eligible: Sequence[Claim], _: Step) -> Claim:
    """The lowest seat."""
    return min(eligible, key=lambda claim: claim.hunter)


def high_seat(eligible: Sequence[Claim], _: Step) -> Claim:
    """The highest seat."""
    return max(eligible, key=lambda claim: claim.hunter)


def in_ties(drawn: Callable[[Sequence[Claim], Step], Claim]) -> Callable[[Sequence[Claim], Step], Claim]:
    """For equal distances only, not for first_come's lots."""
    return lambda tied, step: step.draw(tied) if step.given["policy"] == "first_come" else drawn(tied, step)


def least(measure: Callable[[Claim], float]) -> Callable[[Sequence[Claim], Step], Sequence[Claim]]:
    """Those with the least of something other than whole micrometres."""

    def tied(eligible: Sequence[Claim], step: Step) -> Sequence[Claim]:
        if step.given["policy"] == "first_come":
            return eligible
        measured = [measure(claim) for claim in eligible]
        return [claim for claim, one in zip(eligible, measured, strict=True) if one == min(measured)]

    return tied


def first_under_first_come(eligible: Sequence[Claim], step: Step) -> Sequence[Claim]:
    """The first request under that policy."""
    return eligible[:1] if step.given["policy"] == "first_come" else nearest(eligible, step)


def _wins(claim: Claim, step: Step) -> None:
    claim.verdict, claim.winner = step.won(claim), claim.hunter


def everybody_wins(claim: Claim, step: Step) -> None:
    """Each is granted its target."""
    if claim.rivals:
        _wins(claim, step)


def nobody_wins(claim: Claim, _: Step) -> None:
    """Where several are eligible, all lose."""
    if len(claim.rivals) > 1:
        claim.verdict, claim.winner = Verdict.LOST_CONTEST, None


def _is_tied(claim: Claim) -> bool:
    """Whether others are as near as it is, and none nearer."""
    away = [one.away_um or 0 for one in claim.rivals]
    return away.count(min(away, default=0)) > 1 and claim.away_um == min(away)


def all_of_a_tie_win(claim: Claim, step: Step) -> None:
    """Each of the nearest is granted the target."""
    if _is_tied(claim):
        _wins(claim, step)


def nobody_of_a_tie_wins(claim: Claim, _: Step) -> None:
    """Where several are equally near, all lose."""
    if any(map(_is_tied, claim.rivals)):
        claim.verdict, claim.winner = Verdict.LOST_CONTEST, None


def _granted_before(claim: Claim, step: Step) -> list[Claim]:
    return [one for one in step.claims[: step.claims.index(claim)] if one.verdict is Verdict.GRANTED]


def one_catch_a_step(claim: Claim, step: Step) -> None:
    """Only the first grant of a step stands."""
    if claim.verdict is Verdict.GRANTED and _granted_before(claim, step):
        claim.verdict = Verdict.LOST_CONTEST


def gone_at_once(verdict: Verdict) -> Finish:
    """Whoever asks after a grant gets this verdict, as if the target was gone."""

    def finish(claim: Claim, step: Step) -> None:
        if claim.distance_um is not None and claim.target in {one.target for one in _granted_before(claim, step)}:
            claim.verdict, claim.distance_um, claim.winner = verdict, None, None

    return finish


def _loses_to(claim: Claim, seat: int) -> None:
    if seat not in {one.hunter for one in claim.rivals}:
        claim.verdict, claim.winner = Verdict.LOST_CONTEST, seat


def refused_requests_compete(claim: Claim, step: Step) -> None:
    """The nearest of all that asked wins, even if its request was refused."""
    if claim.rivals:
        asked = [one for one in step.claims if one.target == claim.target]
        _loses_to(claim, min(asked, key=lambda one: one.away_um or 0).hunter)


def bystanders_compete(*, withdrawn: bool) -> Finish:
    """Whoever stands nearest to a target, asking or not, keeps the others from it."""

    def finish(claim: Claim, step: Step) -> None:
        if claim.rivals and claim.target is not None:
            target = step.given["targets"][claim.target]
            away = [math.dist(place, target) for place in step.given["hunters"]]
            seat = away.index(min(away))
            if seat in step.given["inactive"] or not withdrawn:
                _loses_to(claim, seat)

    return finish


def the_next_wins(claim: Claim, _: Step) -> None:
    """After a refused kill the next nearest is granted the target."""
    others = [one for one in claim.rivals if one.verdict is not Verdict.KILL_FAILED]
    if claim in others and len(others) < len(claim.rivals):
        claim.winner = min(others, key=lambda one: (one.away_um or 0, one.hunter)).hunter
        claim.verdict = Verdict.GRANTED if claim.winner == claim.hunter else Verdict.LOST_CONTEST


def the_others_fail_too(claim: Claim, step: Step) -> None:
    """After a refused kill all are told so."""
    if claim.verdict is Verdict.LOST_CONTEST:
        claim.verdict = Verdict.KILL_FAILED if step.won(claim) is Verdict.KILL_FAILED else claim.verdict


# What is told


def says(wrong: Verdict, right: Verdict) -> Finish:
    """One verdict for another."""

    def finish(claim: Claim, _: Step) -> None:
        if claim.verdict is right:
            claim.verdict = wrong

    return finish


def tells(
    *,
    distance: Callable[[Claim], int | None] = lambda claim: claim.distance_um,
    winner: Callable[[Claim], int | None] = lambda claim: claim.winner,
    policy: str = "",
) -> Finish:
    """Other evidence; under one policy alone where that is given."""

    def finish(claim: Claim, step: Step) -> None:
        if policy in {"", step.given["policy"]}:
            claim.distance_um, claim.winner = distance(claim), winner(claim)

    return finish


def nothing(_: Claim) -> None:
    """No evidence."""
    return


def in_parts(of_a_metre: int) -> Callable[[Claim], int | None]:
    """The distance in another unit, of which a metre has so many."""
    return lambda claim: None if claim.distance_um is None else round(of_a_metre * claim.metres)


def as_they_came(claims: list[Claim], step: Step) -> list[Claim]:
    """The claims in the order of the answers."""
    left, found = list(claims), []
    for one in step.answered:
        name = one.name.shown if isinstance(one.name, OtherTarget) else shown(one.name)
        place = next(
            (at for at, claim in enumerate(left) if (claim.hunter, shown(claim.name)) == (one.hunter, name)), 0
        )
        found.append(left.pop(place))
    return found


# What is understood


def given(**changes: Callable[[dict[str, Any]], Any]) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """Other arguments, each made from all that were given."""
    return lambda given: {**given, **{name: made(given) for name, made in changes.items()}}


def names(understood: Callable[[int, Any, Mapping[str, Any]], object]) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """Requests for something else: from the seat, the name and all arguments."""
    return given(requests=lambda given: [(seat, understood(seat, name, given)) for seat, name in given["requests"]])


def nearest_target(seat: int, name: Any, given: Mapping[str, Any]) -> Any:
    """The nearest target's name for any other target's."""
    place, targets = given["hunters"][seat], given["targets"]
    known = isinstance(name, str) and name in targets
    return min(targets, key=lambda one: math.dist(place, targets[one])) if known else name


def equal_as(form: Callable[[str], str]) -> Callable[[str, str], bool]:
    """Names are equal that have an equal form."""
    return lambda name, target: form(name) == form(target)


# In which order


def never(verdict: Verdict) -> Callable[[Order], Order]:
    """A test left out."""
    return lambda old: tuple(one for one in old if one is not verdict)


def put(verdict: Verdict, beside: Verdict, *, behind: bool) -> Callable[[Order], Order]:
    """A test beside another one."""

    def order(old: Order) -> Order:
        rest = [one for one in old if one is not verdict]
        if len(rest) == len(old) or beside not in rest:
            return old
        rest.insert(rest.index(beside) + behind, verdict)
        return tuple(rest)

    return order
