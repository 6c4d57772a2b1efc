"""Why cases failed: which of the known mistakes the answers look like, and what the others have in common."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, cast

from catch_arena.conformance.answers import OtherTarget, Raised
from catch_arena.conformance.arenas import OtherReading
from catch_arena.conformance.cases import ArbiterCase, Asked
from catch_arena.conformance.comparison import OtherLot, OtherRuling, Strictness
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
    shared: int = 0
    """How many of the failures need others too."""


def diagnose(results: Sequence[Result], strictness: Strictness) -> tuple[Diagnosis, ...]:
    """Each failure in one diagnosis, a known mistake or what it has in common with others; large ones first."""
    search = Search(results, strictness)
    found = search.mistakes()
    alone: dict[str, list[Failure]] = {one.looks_like: [] for one in found}
    shared: dict[str, list[Failure]] = {one.looks_like: [] for one in found}
    left: dict[tuple[str, str], list[Failure]] = {}
    for result in results:
        if result.failure is None:
            continue
        if culprits := search.culprits(found, result):
            (alone if len(culprits) == 1 else shared)[culprits[-1].looks_like].append(result.failure)
        else:
            words = _LOT if search.is_lawful(result) else _alike(result.failure)
            left.setdefault(words, []).append(result.failure)
    known = [
        Diagnosis(
            name,
            rule,
            (*_plain_first(alone[name]), *_plain_first(shared[name])),
            known=True,
            shared=len(shared[name]),
        )
        for name, rule, _ in found
        if alone[name] or shared[name]
    ]
    others = [Diagnosis(*words, tuple(_plain_first(failures)), known=False) for words, failures in left.items()]
    return tuple(sorted((*known, *others), key=lambda one: -len(one.failures)))


def _plain_first(failures: Iterable[Failure]) -> list[Failure]:
    """Those that fail as they stand, with few hunters and requests, come before others."""

    def trouble(failure: Failure) -> tuple[bool, int]:
        case = failure.case
        size = len(case.hunters) + len(case.asked) if isinstance(case, ArbiterCase) else len(case.play)
        return failure.how not in {"", "in an arena"}, size

    return sorted(failures, key=trouble)


def _alike(failure: Failure) -> tuple[str, str]:
    """What a failure has in common with others: what it looks like, and what the rulebook says."""
    difference = failure.main_difference
    if isinstance(difference, OtherReading):
        return reading_mistake(difference, failure.case)
    if isinstance(difference, OtherLot):
        return _LOT
    if isinstance(difference, OtherRuling):
        return _in_words(difference.right, difference.given, failure.case.clauses[0])
    if isinstance(difference, Raised):
        return f"{difference.error} is raised{difference.where}", "Every request gets exactly one verdict (R5.2)."
    return f"an answer that cannot be read: {difference.about.rpartition(': ')[2]}", f"Expected: {difference.expected}."


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
