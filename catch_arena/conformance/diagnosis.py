"""Why cases failed: which of the known mistakes the answers look like, and what the others have in common."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, cast

from catch_arena.conformance.answers import OtherTarget, Raised, Unreadable
from catch_arena.conformance.arenas import OtherReading
from catch_arena.conformance.cases import ArbiterCase, Asked
from catch_arena.conformance.comparison import OtherRuling, Strictness
from catch_arena.conformance.mistakes import EVIDENCE, meaning
from catch_arena.conformance.readings import reading_mistake
from catch_arena.conformance.results import Failure, Result
from catch_arena.conformance.search import Search
from catch_arena.verdicts import Verdict

_LOT: Final = (
    "a lot is drawn wrongly",
    "A lot has one winner, the same in every order of requests and without the losers, and is fair to the tied (R5.5).",
)


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """Failures that look like one mistake."""

    looks_like: str
    rule: str
    """What the rulebook says."""
    failures: tuple[Failure, ...]
    """The plainest first; last those for which others of the diagnoses are needed too."""
    known: bool
    """An arbiter with this mistake answers exactly so; else only the answers are alike."""
    conceptual: bool
    """An idea is wrong, as who wins or what is within reach; else a single verdict, or the order of the tests."""
    shared: int = 0
    """How many of the failures need others too."""


def diagnose(results: Sequence[Result], strictness: Strictness) -> tuple[Diagnosis, ...]:
    """Each failure in one diagnosis, a known mistake or what it has in common with others; wrong ideas first, and of
    those the large ones.
    """
    search = Search(results, strictness)
    found = search.mistakes()
    alone: dict[str, list[Failure]] = {one.looks_like: [] for one in found}
    shared: dict[str, list[Failure]] = {one.looks_like: [] for one in found}
    left: dict[tuple[str, str, bool], list[Failure]] = {}
    for result in results:
        if result.failure is None:
            continue
        if culprits := search.culprits(found, result):
            (alone if len(culprits) == 1 else shared)[culprits[-1].looks_like].append(result.failure)
        else:
            words = (*_LOT, True) if search.is_lawful(result) else _alike(result.failure)
            left.setdefault(words, []).append(result.failure)
    known = [
        Diagnosis(
            one.looks_like,
            one.rule,
            (*_plain_first(alone[one.looks_like]), *_plain_first(shared[one.looks_like])),
            known=True,
            conceptual=one.conceptual,
            shared=len(shared[one.looks_like]),
        )
        for one in found
        if alone[one.looks_like] or shared[one.looks_like]
    ]
    others = [
        Diagnosis(looks_like, rule, tuple(_plain_first(failures)), known=False, conceptual=conceptual)
        for (looks_like, rule, conceptual), failures in left.items()
    ]
    return tuple(sorted((*known, *others), key=lambda one: (not one.conceptual, -len(one.failures))))


def _plain_first(failures: Iterable[Failure]) -> list[Failure]:
    """Those that fail as they stand, with some requests but few, and few hunters, come before others."""

    def trouble(failure: Failure) -> tuple[bool, bool, int]:
        case, rearranged = failure.case, failure.how not in {"", "in an arena"}
        if isinstance(case, ArbiterCase):
            return rearranged, not case.asked, len(case.hunters) + len(case.asked)
        return rearranged, False, len(case.play)

    return sorted(failures, key=trouble)


def _alike(failure: Failure) -> tuple[str, str, bool]:
    """What a failure has in common with others: what it looks like, what the rulebook says, and whether it is a wrong
    idea.
    """
    difference = failure.main_difference
    if isinstance(difference, OtherRuling):
        return (*_in_words(difference.right, difference.given, failure.case.clauses[0]), False)
    if isinstance(difference, OtherReading):
        return (*reading_mistake(difference, failure.case), True)
    if isinstance(difference, Raised):
        return f"{difference.error} is raised{difference.where}", "Every request gets exactly one verdict (R5.2).", True
    if isinstance(difference, Unreadable):
        return difference.looks_like, difference.rule, True
    return (*_LOT, True)


def _in_words(right: Asked, given: Asked, clause: str) -> tuple[str, str]:
    """One ruling where another was expected, and the rule."""
    expected, got = cast(Verdict, right.verdict), cast(Verdict, given.verdict)  # whom a lot draws is known by now
    if expected is not got:
        return f"{got.name} where {expected.name} is right ({clause})", meaning(expected)
    wrong = {
        "hunter": right.hunter != given.hunter,
        "target": isinstance(given.name, OtherTarget),
        "distance": right.distance_um != given.distance_um,
        "winner": right.winner != given.winner,
    }
    other = " and ".join(field for field in wrong if wrong[field])
    return f"{expected.name} with a wrong {other} ({clause})", EVIDENCE
