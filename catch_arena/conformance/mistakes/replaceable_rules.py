"""The third arbiter, beside the core's and the oracle's: chapter 5 plain and slow, every rule in a place of its own.
A known mistake is one of its rules replaced.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from catch_arena.verdicts import Ruling, Verdict

ORDER: Final = tuple(verdict for verdict in Verdict if verdict < Verdict.LOST_CONTEST)
"""R5.2: the tests in their order, each named by its verdict."""
WON: Final = frozenset({Verdict.GRANTED, Verdict.KILL_FAILED})
OF_CAPSTONE: Final = frozenset({Verdict.MATCH_OVER, Verdict.MALFORMED, Verdict.HUNTER_INACTIVE, Verdict.SERVICE_DOWN})
"""R9.1: the tests that are made under that policy."""


@dataclass(slots=True, eq=False)
class Request:
    """One request while it is judged."""

    hunter: int
    name: Any
    target: str | None
    """The one that the name stands for."""
    dx: float
    """To that target, without a sign, as dy; NaN where there is none."""
    dy: float
    metres: float
    away_um: int | None
    reach_m: float
    """The hunter's own (R2.7)."""
    verdict: Verdict | None = None
    distance_um: int | None = None
    """What the evidence says, as does the winner."""
    winner: int | None = None
    rivals: Sequence["Request"] = ()
    """All that were eligible for the target, this one among them."""


Lottery = Callable[[Sequence[Request]], Request] | None
"""Draws one of the tied; None draws as in the answer that is looked into, since lots may be anybody's own."""


@dataclass(frozen=True, slots=True)
class Step:
    """What is judged together."""

    given: Mapping[str, Any]
    """The arguments of `arbitrate`."""
    rulings: Sequence[Ruling]
    """The answer of the adjudicator whose mistakes are looked for."""
    lot: Lottery
    requests: list[Request] = field(default_factory=list)

    def won(self, request: Request) -> Verdict:
        """R5.7: what the winner of a contest gets."""
        return Verdict.KILL_FAILED if request.target in self.given["kill_refused"] else Verdict.GRANTED

    def draw(self, tied: Sequence[Request]) -> Request:
        """One of the tied."""
        if self.lot is not None:
            return self.lot(tied)
        won = [
            (one.hunter, one.target) for one in self.rulings if one.verdict in WON and one.winner in {one.hunter, None}
        ]
        return next((request for request in tied if (request.hunter, request.name) in won), tied[0])


def nearest(eligible: Sequence[Request], step: Step) -> Sequence[Request]:
    """R5.4: those among whom the lot decides; R5.9: under `first_come` these are all."""
    if step.given["policy"] == "first_come":
        return eligible
    least = min(request.away_um or 0 for request in eligible)
    return [request for request in eligible if request.away_um == least]


@dataclass(frozen=True, slots=True, kw_only=True)
class Rules:
    """Chapter 5 as functions, each of which may be exchanged; these are right."""

    given: Callable[[dict[str, Any]], dict[str, Any]] = dict
    """The arguments as they are understood."""
    order: tuple[Verdict, ...] = ORDER
    of_capstone: frozenset[Verdict] = OF_CAPSTONE
    is_name: Callable[[object], bool] = lambda name: isinstance(name, str) and len(name) <= 255
    stands_for: Callable[[str, str], bool] = lambda name, target: name == target
    duplicate: Callable[[Request, Sequence[Request], Sequence[Request]], bool] = lambda request, earlier, _: any(
        one.hunter == request.hunter for one in earlier
    )
    """From a request, and those before and after it."""
    metres: Callable[[float, float], float] = lambda dx, dy: math.sqrt(dx * dx + dy * dy)
    micrometres: Callable[[float], int] = lambda metres: math.floor(1e6 * metres + 0.5)
    within: Callable[[Request, float, int], bool] = lambda request, _, reach_um: (request.away_um or 0) < reach_um
    """From a request, and the reach in metres and in micrometres."""
    tied: Callable[[Sequence[Request], Step], Sequence[Request]] = nearest
    drawn: Callable[[Sequence[Request], Step], Request] = lambda tied, step: step.draw(tied)
    finish: Callable[[Request, Step], None] = lambda _, __: None
    """What happens to a request when all have their verdicts."""
    arrange: Callable[[list[Request], Step], list[Request]] = lambda requests, _: requests
    """In which order the requests are answered."""


def judge(
    rules: Rules,
    arguments: Mapping[str, Any],
    rulings: Sequence[Ruling] = (),
    lot: Lottery = None,
) -> list[Request]:
    """The requests of one step, judged by these rules.

    Args:
        rules: the rules by which it judges.
        arguments: of `catch_arena.arbitrate`.
        rulings: the answer that is looked into.
        lot: for ties, None for whom that answer drew.
    """
    step = Step(rules.given(dict(arguments)), rulings, lot)
    step.requests.extend(_request(rules, step, hunter, name) for hunter, name in step.given["requests"])
    capstone = step.given["policy"] == "capstone"
    order = [verdict for verdict in rules.order if verdict in rules.of_capstone or not capstone]
    contests: dict[str, list[Request]] = {}
    for request in step.requests:
        for verdict in order:
            if _TESTS[verdict](rules, step, request):
                request.verdict = verdict
                break
        else:
            if capstone or request.target is None:
                request.verdict, request.winner = Verdict.GRANTED, request.hunter
            else:
                contests.setdefault(request.target, []).append(request)
    for eligible in contests.values():
        winner = rules.drawn(rules.tied(eligible, step), step)
        for request in eligible:
            request.rivals = eligible
            request.verdict = step.won(request) if request is winner else Verdict.LOST_CONTEST
            if len(eligible) > 1 or request.verdict is Verdict.GRANTED:
                request.winner = winner.hunter
    for request in step.requests:
        rules.finish(request, step)
    return rules.arrange(step.requests, step)


def _request(rules: Rules, step: Step, hunter: int, name: object) -> Request:
    targets, reach_m = step.given["targets"], step.given["reach_m"]
    reach_m = reach_m if isinstance(reach_m, int | float) else reach_m[hunter]
    target = next((one for one in targets if rules.stands_for(name, one)), None) if isinstance(name, str) else None
    if target is None:
        return Request(hunter, name, None, math.nan, math.nan, math.nan, None, reach_m)
    (x, y), (target_x, target_y) = step.given["hunters"][hunter], targets[target]
    dx, dy = abs(target_x - x), abs(target_y - y)
    metres = rules.metres(dx, dy)
    return Request(hunter, name, target, dx, dy, metres, rules.micrometres(metres), reach_m)


def _duplicate(rules: Rules, step: Step, request: Request) -> bool:
    place = step.requests.index(request)
    return rules.duplicate(request, step.requests[:place], step.requests[place + 1 :])


def _caught(rules: Rules, step: Step, request: Request) -> bool:
    return isinstance(request.name, str) and any(rules.stands_for(request.name, one) for one in step.given["caught"])


def _far(rules: Rules, _: Step, request: Request) -> bool:
    if request.target is None:
        return False
    request.distance_um = request.away_um
    return not rules.within(request, request.reach_m, max(1, rules.micrometres(request.reach_m)))


_TESTS: Final[Mapping[Verdict, Callable[[Rules, Step, Request], bool]]] = {
    Verdict.MATCH_OVER: lambda _, step, __: step.given["match_over"],
    Verdict.MALFORMED: lambda rules, _, request: not rules.is_name(request.name),
    Verdict.HUNTER_INACTIVE: lambda _, step, request: request.hunter in step.given["inactive"],
    Verdict.DUPLICATE: _duplicate,
    Verdict.UNKNOWN_TARGET: lambda rules, step, request: request.target is None and not _caught(rules, step, request),
    Verdict.ALREADY_CAUGHT: _caught,
    Verdict.SERVICE_DOWN: lambda _, step, __: not step.given["kill_service_up"],
    Verdict.OUT_OF_REACH: _far,
}
