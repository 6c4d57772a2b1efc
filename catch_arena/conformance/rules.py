"""Chapter 5 once more, plain and slow, with every rule in a place of its own: a known mistake is a rule exchanged."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from catch_arena.conformance.cases import Asked
from catch_arena.verdicts import Verdict

ORDER: Final = tuple(verdict for verdict in Verdict if verdict < Verdict.LOST_CONTEST)
"""R5.2: the tests in their order, each named by its verdict."""
WON: Final = frozenset({Verdict.GRANTED, Verdict.KILL_FAILED})
OF_CAPSTONE: Final = frozenset({Verdict.MATCH_OVER, Verdict.MALFORMED, Verdict.HUNTER_INACTIVE, Verdict.SERVICE_DOWN})
"""R9.1: the tests that are made under that policy."""


@dataclass(slots=True, eq=False)
class Claim:
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
    verdict: Verdict | None = None
    distance_um: int | None = None
    """What the evidence says, as does the winner."""
    winner: int | None = None
    rivals: Sequence["Claim"] = ()
    """All that were eligible for the target, this one among them."""


Lottery = Callable[[Sequence[Claim]], Claim] | None
"""Draws one of the tied; None draws as in the answer that is looked into, since lots may be anybody's own."""


@dataclass(frozen=True, slots=True)
class Step:
    """What is judged together."""

    given: Mapping[str, Any]
    """The arguments of `arbitrate`."""
    answered: Sequence[Asked]
    """What the adjudicator said whose mistakes are looked for."""
    lot: Lottery
    claims: list[Claim] = field(default_factory=list)

    def won(self, claim: Claim) -> Verdict:
        """R5.7: what the winner of a contest gets."""
        return Verdict.KILL_FAILED if claim.target in self.given["kill_refused"] else Verdict.GRANTED

    def draw(self, tied: Sequence[Claim]) -> Claim:
        """One of the tied."""
        if self.lot is not None:
            return self.lot(tied)
        won = [
            (one.hunter, one.name) for one in self.answered if one.verdict in WON and one.winner in {one.hunter, None}
        ]
        return next((claim for claim in tied if (claim.hunter, claim.name) in won), tied[0])


def nearest(eligible: Sequence[Claim], step: Step) -> Sequence[Claim]:
    """R5.4: those among whom the lot decides; R5.9: under `first_come` these are all."""
    if step.given["policy"] == "first_come":
        return eligible
    least = min(claim.away_um or 0 for claim in eligible)
    return [claim for claim in eligible if claim.away_um == least]


@dataclass(frozen=True, slots=True, kw_only=True)
class Rules:
    """Chapter 5 as functions, each of which may be exchanged; these are right."""

    given: Callable[[dict[str, Any]], dict[str, Any]] = dict
    """The arguments as they are understood."""
    order: tuple[Verdict, ...] = ORDER
    of_capstone: frozenset[Verdict] = OF_CAPSTONE
    is_name: Callable[[object], bool] = lambda name: isinstance(name, str) and len(name) <= 255
    stands_for: Callable[[str, str], bool] = lambda name, target: name == target
    duplicate: Callable[[Claim, Sequence[Claim], Sequence[Claim]], bool] = lambda claim, earlier, _: any(
        one.hunter == claim.hunter for one in earlier
    )
    """From a claim, and those before and after it."""
    metres: Callable[[float, float], float] = lambda dx, dy: math.sqrt(dx * dx + dy * dy)
    micrometres: Callable[[float], int] = lambda metres: math.floor(1e6 * metres + 0.5)
    within: Callable[[Claim, float, int], bool] = lambda claim, _, reach_um: (claim.away_um or 0) < reach_um
    """From a claim, and the reach in metres and in micrometres."""
    tied: Callable[[Sequence[Claim], Step], Sequence[Claim]] = nearest
    drawn: Callable[[Sequence[Claim], Step], Claim] = lambda tied, step: step.draw(tied)
    finish: Callable[[Claim, Step], None] = lambda _, __: None
    """What happens to a claim when all have their verdicts."""
    arrange: Callable[[list[Claim], Step], list[Claim]] = lambda claims, _: claims
    """In which order the claims are answered."""


def judge(
    rules: Rules,
    arguments: Mapping[str, Any],
    answered: Sequence[Asked] = (),
    lot: Lottery = None,
) -> list[Claim]:
    """The requests of one step, judged by these rules.

    Args: `arguments` of `catch_arena.arbitrate`; `answered`, the answer that is looked into; `lot`, for ties, None for
    whom that answer drew.
    """
    step = Step(rules.given(dict(arguments)), answered, lot)
    step.claims.extend(_claim(rules, step, hunter, name) for hunter, name in step.given["requests"])
    capstone = step.given["policy"] == "capstone"
    order = [verdict for verdict in rules.order if verdict in rules.of_capstone or not capstone]
    contests: dict[str, list[Claim]] = {}
    for claim in step.claims:
        for verdict in order:
            if _TESTS[verdict](rules, step, claim):
                claim.verdict = verdict
                break
        else:
            if capstone or claim.target is None:
                claim.verdict, claim.winner = Verdict.GRANTED, claim.hunter
            else:
                contests.setdefault(claim.target, []).append(claim)
    for eligible in contests.values():
        winner = rules.drawn(rules.tied(eligible, step), step)
        for claim in eligible:
            claim.rivals = eligible
            claim.verdict = step.won(claim) if claim is winner else Verdict.LOST_CONTEST
            if len(eligible) > 1 or claim.verdict is Verdict.GRANTED:
                claim.winner = winner.hunter
    for claim in step.claims:
        rules.finish(claim, step)
    return rules.arrange(step.claims, step)


def _claim(rules: Rules, step: Step, hunter: int, name: object) -> Claim:
    targets = step.given["targets"]
    target = next((one for one in targets if rules.stands_for(name, one)), None) if isinstance(name, str) else None
    if target is None:
        return Claim(hunter, name, None, math.nan, math.nan, math.nan, None)
    (x, y), (target_x, target_y) = step.given["hunters"][hunter], targets[target]
    dx, dy = abs(target_x - x), abs(target_y - y)
    metres = rules.metres(dx, dy)
    return Claim(hunter, name, target, dx, dy, metres, rules.micrometres(metres))


def _duplicate(rules: Rules, step: Step, claim: Claim) -> bool:
    place = step.claims.index(claim)
    return rules.duplicate(claim, step.claims[:place], step.claims[place + 1 :])


def _caught(rules: Rules, step: Step, claim: Claim) -> bool:
    return isinstance(claim.name, str) and any(rules.stands_for(claim.name, one) for one in step.given["caught"])


def _far(rules: Rules, step: Step, claim: Claim) -> bool:
    if claim.target is None:
        return False
    claim.distance_um = claim.away_um
    reach_m = step.given["reach_m"]
    return not rules.within(claim, reach_m, max(1, rules.micrometres(reach_m)))


_TESTS: Final[Mapping[Verdict, Callable[[Rules, Step, Claim], bool]]] = {
    Verdict.MATCH_OVER: lambda _, step, __: step.given["match_over"],
    Verdict.MALFORMED: lambda rules, _, claim: not rules.is_name(claim.name),
    Verdict.HUNTER_INACTIVE: lambda _, step, claim: claim.hunter in step.given["inactive"],
    Verdict.DUPLICATE: _duplicate,
    Verdict.UNKNOWN_TARGET: lambda rules, step, claim: claim.target is None and not _caught(rules, step, claim),
    Verdict.ALREADY_CAUGHT: _caught,
    Verdict.SERVICE_DOWN: lambda _, step, __: not step.given["kill_service_up"],
    Verdict.OUT_OF_REACH: _far,
}
