"""Wrong rules, to be exchanged for those of chapter 5: what the known mistakes are made of."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from catch_arena.conformance.answers import WrongTarget
from catch_arena.conformance.mistakes.replaceable_rules import Request, Step, nearest
from catch_arena.text import in_short
from catch_arena.verdicts import Verdict

Finish = Callable[[Request, Step], None]
Order = tuple[Verdict, ...]

# Who wins


def everybody(eligible: Sequence[Request], _: Step) -> Sequence[Request]:
    """All that are eligible."""
    return eligible


def first(eligible: Sequence[Request], _: Step) -> Request:
    """Whoever asked first."""
    return eligible[0]


def last(eligible: Sequence[Request], _: Step) -> Request:
    """Whoever asked last."""
    return eligible[-1]


def low_seat(eligible: Sequence[Request], _: Step) -> Request:
    """The lowest seat."""
    return min(eligible, key=lambda request: request.hunter)


def high_seat(eligible: Sequence[Request], _: Step) -> Request:
    """The highest seat."""
    return max(eligible, key=lambda request: request.hunter)


def in_ties(drawn: Callable[[Sequence[Request], Step], Request]) -> Callable[[Sequence[Request], Step], Request]:
    """For equal distances only, not for first_come's lots."""
    return lambda tied, step: step.draw(tied) if step.given["policy"] == "first_come" else drawn(tied, step)


def least(measure: Callable[[Request], Any]) -> Callable[[Sequence[Request], Step], Sequence[Request]]:
    """Those with the least of something other than whole micrometres."""

    def tied(eligible: Sequence[Request], step: Step) -> Sequence[Request]:
        if step.given["policy"] == "first_come":
            return eligible
        measured = [measure(request) for request in eligible]
        return [request for request, one in zip(eligible, measured, strict=True) if one == min(measured)]

    return tied


def first_under_first_come(eligible: Sequence[Request], step: Step) -> Sequence[Request]:
    """The first request under that policy."""
    return eligible[:1] if step.given["policy"] == "first_come" else nearest(eligible, step)


def _wins(request: Request, step: Step) -> None:
    request.verdict, request.winner = step.won(request), request.hunter


def everybody_wins(request: Request, step: Step) -> None:
    """Each is granted its target."""
    if request.rivals:
        _wins(request, step)


def nobody_wins(request: Request, _: Step) -> None:
    """Where several are eligible, all lose."""
    if len(request.rivals) > 1:
        request.verdict, request.winner = Verdict.LOST_CONTEST, None


def _is_tied(request: Request) -> bool:
    """Whether others are as near as it is, and none nearer."""
    away = [one.away_um or 0 for one in request.rivals]
    return away.count(min(away, default=0)) > 1 and request.away_um == min(away)


def all_of_a_tie_win(request: Request, step: Step) -> None:
    """Each of the nearest is granted the target."""
    if _is_tied(request):
        _wins(request, step)


def nobody_of_a_tie_wins(request: Request, _: Step) -> None:
    """Where several are equally near, all lose."""
    if any(map(_is_tied, request.rivals)):
        request.verdict, request.winner = Verdict.LOST_CONTEST, None


def _granted_before(request: Request, step: Step) -> list[Request]:
    return [one for one in step.requests[: step.requests.index(request)] if one.verdict is Verdict.GRANTED]


def one_catch_a_step(request: Request, step: Step) -> None:
    """Only the first grant of a step stands."""
    if request.verdict is Verdict.GRANTED and _granted_before(request, step):
        request.verdict = Verdict.LOST_CONTEST


def gone_at_once(verdict: Verdict) -> Finish:
    """Whoever asks after a grant gets this verdict, as if the target was gone."""

    def finish(request: Request, step: Step) -> None:
        if request.distance_um is not None and request.target in {one.target for one in _granted_before(request, step)}:
            request.verdict, request.distance_um, request.winner = verdict, None, None

    return finish


def _loses_to(request: Request, seat: int) -> None:
    if seat not in {one.hunter for one in request.rivals}:
        request.verdict, request.winner = Verdict.LOST_CONTEST, seat


def refused_requests_compete(request: Request, step: Step) -> None:
    """The nearest of all that asked wins, even if its request was refused."""
    if request.rivals:
        asked = [one for one in step.requests if one.target == request.target]
        _loses_to(request, min(asked, key=lambda one: one.away_um or 0).hunter)


def bystanders_compete(*, withdrawn: bool) -> Finish:
    """Whoever stands nearest to a target, asking or not, keeps the others from it."""

    def finish(request: Request, step: Step) -> None:
        if request.rivals and request.target is not None:
            target = step.given["targets"][request.target]
            away = [math.dist(place, target) for place in step.given["hunters"]]
            seat = away.index(min(away))
            if seat in step.given["inactive"] or not withdrawn:
                _loses_to(request, seat)

    return finish


def the_next_wins(request: Request, _: Step) -> None:
    """After a refused kill the next nearest is granted the target."""
    others = [one for one in request.rivals if one.verdict is not Verdict.KILL_FAILED]
    if request in others and len(others) < len(request.rivals):
        request.winner = min(others, key=lambda one: (one.away_um or 0, one.hunter)).hunter
        request.verdict = Verdict.GRANTED if request.winner == request.hunter else Verdict.LOST_CONTEST


def the_others_fail_too(request: Request, step: Step) -> None:
    """After a refused kill all get KILL_FAILED."""
    if request.verdict is Verdict.LOST_CONTEST:
        request.verdict = Verdict.KILL_FAILED if step.won(request) is Verdict.KILL_FAILED else request.verdict


# What is answered


def replaces(wrong: Verdict, right: Verdict) -> Finish:
    """One verdict for another."""

    def finish(request: Request, _: Step) -> None:
        if request.verdict is right:
            request.verdict = wrong

    return finish


def gives_evidence(
    *,
    distance: Callable[[Request], int | None] = lambda request: request.distance_um,
    winner: Callable[[Request], int | None] = lambda request: request.winner,
    policy: str = "",
) -> Finish:
    """Other evidence; under one policy alone where that is given."""

    def finish(request: Request, step: Step) -> None:
        if policy in {"", step.given["policy"]}:
            request.distance_um, request.winner = distance(request), winner(request)

    return finish


def nothing(_: Request) -> None:
    """No evidence."""
    return


def in_units(per_metre: int) -> Callable[[Request], int | None]:
    """The distance in another unit, of which a metre has so many."""
    return lambda request: None if request.distance_um is None else round(per_metre * request.metres)


def in_the_answers_order(requests: list[Request], step: Step) -> list[Request]:
    """The requests in the order of the answers."""
    left, found = list(requests), []
    for one in step.rulings:
        name = one.target.in_short if isinstance(one.target, WrongTarget) else in_short(one.target)
        place = next(
            (at for at, request in enumerate(left) if (request.hunter, in_short(request.name)) == (one.hunter, name)), 0
        )
        found.append(left.pop(place))
    return found


# What is understood


def with_arguments(**changes: Callable[[dict[str, Any]], Any]) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """Other arguments, each made from all that were given."""
    return lambda given: {**given, **{name: made(given) for name, made in changes.items()}}


def with_one_reach(chosen: Callable[[Sequence[float]], float]) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """For all hunters one of the reaches that stand there by seat."""

    def reach_m(given: dict[str, Any]) -> Any:
        reaches = given["reach_m"]
        return reaches if isinstance(reaches, int | float) else chosen(reaches)

    return with_arguments(reach_m=reach_m)


def with_names(
    understood: Callable[[int, Any, Mapping[str, Any]], object],
) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """Requests for something else: from the seat, the name and all arguments."""
    return with_arguments(
        requests=lambda given: [(seat, understood(seat, name, given)) for seat, name in given["requests"]]
    )


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
