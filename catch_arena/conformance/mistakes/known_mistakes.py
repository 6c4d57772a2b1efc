"""The mistakes that arbiters are known to make, each as rules of chapter 5 exchanged for wrong ones.

A mistake's `change` holds fields of Rules: `order` is made from that of other mistakes, `given` and `finish` come after
theirs, and all else takes the place of what was there.
"""

import math
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, NamedTuple

from catch_arena.conformance.mistakes import wrong_rules as wrong
from catch_arena.conformance.mistakes.replaceable_rules import OF_CAPSTONE, ORDER, Request, Rules, Step
from catch_arena.conformance.mistakes.wrong_rules import Finish
from catch_arena.verdicts import REASONS, Verdict


class Mistake(NamedTuple):
    """A way to be wrong."""

    looks_like: str
    rule: str
    """What the rulebook says."""
    change: Mapping[str, Any]
    conceptual: bool = True
    """An idea is wrong; else a single verdict, the order of the tests, or what is told besides the verdict."""


def rules_with(mistakes: Iterable[Mistake]) -> Rules:
    """The rules with these mistakes in them."""
    rules = Rules()
    for one in mistakes:
        made = {
            name: _COMBINED[name](getattr(rules, name), new) for name, new in one.change.items() if name in _COMBINED
        }
        rules = replace(rules, **{**one.change, **made})
    return rules


def mistaken_verdicts(seen: Iterable[tuple[object, object]]) -> Iterator[Mistake]:
    """One verdict for another; `seen`, pairs of what was expected and what was answered."""
    for right, given in seen:
        if right is not given and isinstance(right, Verdict) and isinstance(given, Verdict):
            yield _slip(
                f"{given.name} where {right.name} is right", meaning(right), finish=wrong.replaces(given, right)
            )


def _mistake(looks_like: str, rule: str, **change: Any) -> Mistake:
    return Mistake(looks_like, rule, change)


def _slip(looks_like: str, rule: str, **change: Any) -> Mistake:
    return Mistake(looks_like, rule, change, conceptual=False)


def _in_turn(old: Finish, new: Finish) -> Finish:
    def both(request: Request, step: Step) -> None:
        old(request, step)
        new(request, step)

    return both


_COMBINED: Final[Mapping[str, Callable[[Any, Any], Any]]] = {
    "order": lambda old, new: new(old),
    "given": lambda old, new: lambda given: new(old(given)),
    "finish": _in_turn,
}


def meaning(verdict: Verdict) -> str:
    """A verdict in words, with its clause."""
    return f"{verdict.name} means: {REASONS[verdict]}."


def _out_of_order() -> Iterator[Mistake]:
    """Any one of the tests in another place, those that move least first."""
    rule = f"R5.2 has the order {', '.join(verdict.name for verdict in ORDER)}."
    for by in range(1, len(ORDER)):
        for one, then in zip(ORDER, ORDER[by:], strict=False):
            yield _slip(f"{then.name} is tested before {one.name}", rule, order=wrong.put(then, one, behind=False))
            if by > 1:  # else that is the same
                order = wrong.put(one, then, behind=True)
                yield _slip(f"{one.name} is tested only after {then.name}", rule, order=order)


_NEAREST: Final = "Of those within reach the nearest wins, whoever asked first and whatever its seat (R5.4)."
_LOT: Final = "A tie is drawn by a lot from the seed, the step, the target and the tied seats (R5.5)."
_REACH: Final = "Within reach is distance_um < reach_um: 299999 is in, 300000 is out (R5.3)."
_OWN_REACH: Final = "Each hunter has a reach of its own, which says who may catch, and not who wins (R2.7, R5.3, R5.4)."
_DISTANCE: Final = "The distance is floor(1e6 * sqrt(dx * dx + dy * dy) + 0.5) micrometres (R5.3)."
_FIRST_STANDS: Final = "A hunter's first request in a step stands, whatever its verdict; more are DUPLICATE (R5.2)."
_NAME: Final = "A name is any string of at most 255 characters; all else is MALFORMED (R5.2)."
_SAME_NAME: Final = "A name stands for the target that is called exactly so (R5.2)."
_REFUSED: Final = "A refused kill: the winner gets KILL_FAILED, the others LOST_CONTEST, nobody a catch (R5.7)."
EVIDENCE: Final = "The distance is told where reach was tested, the winner of a contest or a grant (R5.6)."
_APART: Final = "All requests of a step are judged on the state at its beginning (R5.1)."
_ELIGIBLE: Final = "A contest is among the requests for one target that passed every test of R5.2 (R5.1, R5.5)."
_CAPSTONE: Final = "Under capstone all succeed but MATCH_OVER, MALFORMED, HUNTER_INACTIVE, SERVICE_DOWN (R9.1)."
_POLICY: Final = "The policy says who wins: nearest, first_come (by lot, not by order) or capstone (R5.9)."

KNOWN: Final[Sequence[Mistake]] = (
    _mistake("ties go to the lowest seat", _LOT, drawn=wrong.in_ties(wrong.low_seat)),
    _mistake("ties go to the highest seat", _LOT, drawn=wrong.in_ties(wrong.high_seat)),
    _mistake("ties go to the first request", _LOT, drawn=wrong.in_ties(wrong.first)),
    _mistake("ties go to the last request", _LOT, drawn=wrong.in_ties(wrong.last)),
    _mistake("everybody in a tie wins", _LOT, finish=wrong.all_of_a_tie_win),
    _mistake("nobody in a tie wins", _LOT, finish=wrong.nobody_of_a_tie_wins),
    _mistake("first come, first served", _NEAREST, tied=wrong.everybody, drawn=wrong.first),
    _mistake("last come, first served", _NEAREST, tied=wrong.everybody, drawn=wrong.last),
    _mistake("the lowest seat wins", _NEAREST, tied=wrong.everybody, drawn=wrong.low_seat),
    _mistake("the highest seat wins", _NEAREST, tied=wrong.everybody, drawn=wrong.high_seat),
    _mistake("the farthest wins", _NEAREST, tied=wrong.least(lambda request: -(request.away_um or 0))),
    _mistake("everybody within reach wins", _NEAREST, finish=wrong.everybody_wins),
    _mistake("nobody wins where several ask", _NEAREST, finish=wrong.nobody_wins),
    _mistake(
        "the nearest is found in floats, not in whole micrometres",
        _NEAREST,
        tied=wrong.least(lambda request: request.metres),
    ),
    _mistake("the nearest is found by dx + dy", _NEAREST, tied=wrong.least(lambda request: request.dx + request.dy)),
    _mistake(
        "the nearest is found by the larger one of dx and dy",
        _NEAREST,
        tied=wrong.least(lambda request: max(request.dx, request.dy)),
    ),
    _mistake(
        "one after the other: who comes after a catch gets ALREADY_CAUGHT",
        _APART,
        tied=wrong.everybody,
        drawn=wrong.first,
        finish=wrong.gone_at_once(Verdict.ALREADY_CAUGHT),
    ),
    _mistake(
        "one after the other: who comes after a catch gets UNKNOWN_TARGET",
        _APART,
        tied=wrong.everybody,
        drawn=wrong.first,
        finish=wrong.gone_at_once(Verdict.UNKNOWN_TARGET),
    ),
    _mistake("only one catch in a step", _APART, finish=wrong.one_catch_a_step),
    _mistake("refused requests win contests", _ELIGIBLE, finish=wrong.refused_requests_compete),
    _mistake(
        "a withdrawn hunter nearby wins without asking", _ELIGIBLE, finish=wrong.bystanders_compete(withdrawn=True)
    ),
    _mistake("a hunter nearby wins without asking", _ELIGIBLE, finish=wrong.bystanders_compete(withdrawn=False)),
    _mistake(
        "the nearest target is given, whichever was named", _ELIGIBLE, given=wrong.with_names(wrong.nearest_target)
    ),
    # Reach
    _mistake("reach is tested in floats", _REACH, within=lambda request, reach_m, _: request.metres < reach_m),
    _mistake(
        "reach is tested in floats, with <=", _REACH, within=lambda request, reach_m, _: request.metres <= reach_m
    ),
    _mistake("within reach is tested with <=", _REACH, within=lambda request, _, reach_um: request.away_um <= reach_um),
    _mistake(
        "reach is tested by dx + dy", _REACH, within=lambda request, reach_m, _: request.dx + request.dy < reach_m
    ),
    _mistake(
        "reach is tested by the larger one of dx and dy",
        _REACH,
        within=lambda request, reach_m, _: max(request.dx, request.dy) < reach_m,
    ),
    _mistake("reach is 0.3 m whatever reach_m says", _REACH, within=lambda request, *_: request.away_um < 300_000),
    _mistake(
        "a reach of less than a micrometre lets nobody in",
        "reach_m counts as one micrometre at least (R5.3).",
        within=lambda request, reach_m, _: request.away_um < math.floor(1e6 * reach_m + 0.5),
    ),
    _mistake("reach is not tested", _REACH, within=lambda *_: True),
    _mistake("all have the longest reach", _OWN_REACH, given=wrong.with_one_reach(max)),
    _mistake("all have the shortest reach", _OWN_REACH, given=wrong.with_one_reach(min)),
    _mistake("all have the reach of hunter 0", _OWN_REACH, given=wrong.with_one_reach(lambda reaches: reaches[0])),
    _mistake("reach is 0.5 m whatever reach_m says", _REACH, within=lambda request, *_: request.away_um < 500_000),
    _mistake(
        "who reaches farther wins",
        _OWN_REACH,
        tied=wrong.least(lambda request: (-request.reach_m, request.away_um)),
    ),
    _mistake(
        "the nearest is found in shares of each reach",
        _OWN_REACH,
        tied=wrong.least(lambda request: (request.away_um or 0) / request.reach_m),
    ),
    _mistake("distances are cut off, not rounded", _DISTANCE, micrometres=lambda metres: int(1e6 * metres)),
    _mistake("distances are rounded up", _DISTANCE, micrometres=lambda metres: math.ceil(1e6 * metres)),
    _mistake("distances are rounded to millimetres", _DISTANCE, micrometres=lambda metres: 1000 * round(1e3 * metres)),
    _mistake("the distance is dx + dy", _DISTANCE, metres=lambda dx, dy: dx + dy),
    _mistake("the distance is the larger one of dx and dy", _DISTANCE, metres=max),
    _mistake("the distance is dx alone", _DISTANCE, metres=lambda dx, _: dx),
    _mistake("the distance is dy alone", _DISTANCE, metres=lambda _, dy: dy),
    _mistake("the distance is a square: the root is missing", _DISTANCE, metres=lambda dx, dy: dx * dx + dy * dy),
    # Evidence
    _slip(
        "no evidence is given",
        "Compare with --verdicts-only until distances and winners are given (R5.6).",
        finish=wrong.gives_evidence(distance=wrong.nothing, winner=wrong.nothing),
    ),
    _slip("no distance is given", EVIDENCE, finish=wrong.gives_evidence(distance=wrong.nothing)),
    _slip("no winner is given", EVIDENCE, finish=wrong.gives_evidence(winner=wrong.nothing)),
    _slip(
        "only who is granted learns the winner",
        EVIDENCE,
        finish=wrong.gives_evidence(
            winner=lambda request: request.winner if request.verdict is Verdict.GRANTED else None
        ),
    ),
    _slip(
        "losers do not learn the winner",
        EVIDENCE,
        finish=wrong.gives_evidence(
            winner=lambda request: None if request.verdict is Verdict.LOST_CONTEST else request.winner
        ),
    ),
    _slip(
        "only losers learn the winner",
        EVIDENCE,
        finish=wrong.gives_evidence(
            winner=lambda request: request.winner if request.verdict is Verdict.LOST_CONTEST else None
        ),
    ),
    _slip(
        "a refused kill without a rival has a winner",
        EVIDENCE,
        finish=wrong.gives_evidence(
            winner=lambda request: request.hunter if request.verdict is Verdict.KILL_FAILED else request.winner
        ),
    ),
    _slip(
        "a distance is given to everybody",
        EVIDENCE,
        finish=wrong.gives_evidence(distance=lambda request: request.away_um),
    ),
    _slip(
        "no distance is given to those out of reach",
        EVIDENCE,
        finish=wrong.gives_evidence(distance=lambda request: request.distance_um if request.rivals else None),
    ),
    _slip(
        "losers are given the winner's distance",
        EVIDENCE,
        finish=wrong.gives_evidence(
            distance=lambda request: min((one.away_um or 0 for one in request.rivals), default=request.distance_um)
        ),
    ),
    _mistake("distances are in millimetres", _DISTANCE, finish=wrong.gives_evidence(distance=wrong.in_units(1000))),
    _mistake("distances are in whole metres", _DISTANCE, finish=wrong.gives_evidence(distance=wrong.in_units(1))),
    _mistake(
        "the rulings are not in the order of the requests",
        "There is one ruling for each request, in their order (`catch-arena docs conformance`).",
        arrange=wrong.in_the_answers_order,
    ),
    # The order of the tests
    *_out_of_order(),
    # Names
    _mistake("anything is a name", _NAME, given=wrong.with_names(lambda _, name, __: str(name))),
    _mistake(
        "names of 256 characters are allowed", _NAME, is_name=lambda name: isinstance(name, str) and len(name) <= 256
    ),
    _mistake(
        "names of 255 characters are refused", _NAME, is_name=lambda name: isinstance(name, str) and len(name) < 255
    ),
    _mistake("a name may be as long as it likes", _NAME, is_name=lambda name: isinstance(name, str)),
    _mistake(
        "the length of a name is counted in bytes",
        _NAME,
        is_name=lambda name: isinstance(name, str) and len(name.encode(errors="replace")) <= 255,
    ),
    _mistake("an empty name is MALFORMED", _NAME, is_name=lambda name: isinstance(name, str) and 0 < len(name) <= 255),
    _mistake("capital letters do not matter in names", _SAME_NAME, stands_for=wrong.equal_as(str.casefold)),
    _mistake("spaces around names do not matter", _SAME_NAME, stands_for=wrong.equal_as(str.strip)),
    _mistake(
        "letters that look the same are the same (NFC)",
        _SAME_NAME,
        stands_for=wrong.equal_as(lambda name: unicodedata.normalize("NFC", name)),
    ),
    _mistake(
        "letters that mean the same are the same (NFKC)",
        _SAME_NAME,
        stands_for=wrong.equal_as(lambda name: unicodedata.normalize("NFKC", name)),
    ),
    _mistake(
        "a name ends at its first NUL", _SAME_NAME, stands_for=lambda name, target: name.partition("\0")[0] == target
    ),
    _mistake("the beginning of a name is enough", _SAME_NAME, stands_for=lambda name, target: target.startswith(name)),
    _mistake(
        "a name that contains a target's name is enough", _SAME_NAME, stands_for=lambda name, target: target in name
    ),
    # Duplicates
    _mistake(
        "a hunter's last request stands, not its first",
        _FIRST_STANDS,
        duplicate=lambda request, _, later: any(one.hunter == request.hunter for one in later),
    ),
    _mistake(
        "all requests of a hunter that asks twice are duplicates",
        _FIRST_STANDS,
        duplicate=lambda request, earlier, later: any(one.hunter == request.hunter for one in (*earlier, *later)),
    ),
    _mistake(
        "a refused request does not count as the first",
        _FIRST_STANDS,
        duplicate=lambda request, earlier, _: any(
            one.hunter == request.hunter and one.verdict is None for one in earlier
        ),
    ),
    _mistake(
        "a malformed request does not count as the first",
        _FIRST_STANDS,
        duplicate=lambda request, earlier, _: any(
            one.hunter == request.hunter and one.verdict is not Verdict.MALFORMED for one in earlier
        ),
    ),
    _mistake(
        "only a second request for the same target is a duplicate",
        _FIRST_STANDS,
        duplicate=lambda request, earlier, _: any(
            (one.hunter, one.name) == (request.hunter, request.name) for one in earlier
        ),
    ),
    # Kills
    _mistake("a refused kill is credited", _REFUSED, given=wrong.with_arguments(kill_refused=lambda _: ())),
    _mistake("a refused kill is GRANTED", _REFUSED, finish=wrong.replaces(Verdict.GRANTED, Verdict.KILL_FAILED)),
    _mistake(
        "one refused kill refuses all of its step",
        _REFUSED,
        given=wrong.with_arguments(kill_refused=lambda given: given["kill_refused"] and list(given["targets"])),
    ),
    _mistake("after a refused kill the next nearest wins", _REFUSED, finish=wrong.the_next_wins),
    _mistake("after a refused kill the others are told KILL_FAILED too", _REFUSED, finish=wrong.the_others_fail_too),
    # Policies
    _mistake("the policy is always nearest", _POLICY, given=wrong.with_arguments(policy=lambda _: "nearest")),
    _mistake("the policy is always capstone", _POLICY, given=wrong.with_arguments(policy=lambda _: "capstone")),
    _mistake("first_come goes by the order of the requests", _POLICY, tied=wrong.first_under_first_come),
    _mistake(
        "first_come is taken for nearest",
        _POLICY,
        given=wrong.with_arguments(policy=lambda given: given["policy"].replace("first_come", "nearest")),
    ),
    _mistake(
        "capstone is taken for nearest",
        _POLICY,
        given=wrong.with_arguments(policy=lambda given: given["policy"].replace("capstone", "nearest")),
    ),
    _mistake(
        "under capstone no winner is given",
        _CAPSTONE,
        finish=wrong.gives_evidence(winner=wrong.nothing, policy="capstone"),
    ),
    _mistake(
        "under capstone a distance is given",
        _CAPSTONE,
        finish=wrong.gives_evidence(distance=lambda request: request.away_um, policy="capstone"),
    ),
    *(
        _mistake(f"under capstone {verdict.name} is said too", _CAPSTONE, of_capstone=OF_CAPSTONE | {verdict})
        for verdict in ORDER
        if verdict not in OF_CAPSTONE
    ),
    *(
        _mistake(f"under capstone {verdict.name} is never said", _CAPSTONE, of_capstone=OF_CAPSTONE - {verdict})
        for verdict in ORDER
        if verdict in OF_CAPSTONE
    ),
    # Tests that are not made
    *(_slip(f"{verdict.name} is never said", meaning(verdict), order=wrong.never(verdict)) for verdict in ORDER),
)
"""Where two explain as much the first is named, so the subtle ones come before the gross ones."""
