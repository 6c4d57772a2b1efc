"""Why cases failed: which of the known mistakes the answers look like, and what the others have in common."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple, cast

from catch_arena.conformance.answers import OtherTarget, Raised, Unreadable
from catch_arena.conformance.arenas import OtherReading
from catch_arena.conformance.cases import ArbiterCase, Asked
from catch_arena.conformance.comparison import OtherRuling, Strictness
from catch_arena.conformance.mistakes import EVIDENCE, meaning
from catch_arena.conformance.readings import reading_mistake
from catch_arena.conformance.results import Failure, Result
from catch_arena.conformance.search import Search
from catch_arena.verdicts import Verdict


class _Kind(NamedTuple):
    """What failures have in common; the fields are those of a Diagnosis."""

    looks_like: str
    rule: str
    known: bool = False
    conceptual: bool = True


_LOT: Final = _Kind(
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
    groups: dict[_Kind, list[tuple[bool, Failure]]] = {}
    for result in results:
        if result.failure is None:
            continue
        culprits = search.culprits(found, result)
        if culprits:
            kind = _Kind(culprits[-1].looks_like, culprits[-1].rule, known=True, conceptual=culprits[-1].conceptual)
        else:
            kind = _LOT if search.is_lawful(result) else _alike(result.failure)
        groups.setdefault(kind, []).append((len(culprits) > 1, result.failure))
    diagnoses = []
    for kind, members in groups.items():
        members.sort(key=lambda one: (one[0], _trouble(one[1])))
        failures = tuple(failure for _, failure in members)
        diagnoses.append(Diagnosis(**kind._asdict(), failures=failures, shared=sum(shared for shared, _ in members)))
    return tuple(sorted(diagnoses, key=lambda one: (not one.conceptual, -len(one.failures), not one.known)))


def _trouble(failure: Failure) -> tuple[bool, bool, int]:
    """What is easily understood comes first: as it stands, with some requests but few, and few hunters."""
    case, rearranged = failure.case, failure.how not in {"", "in an arena"}
    if isinstance(case, ArbiterCase):
        return rearranged, not case.asked, len(case.hunters) + len(case.asked)
    return rearranged, False, len(case.play)


def _alike(failure: Failure) -> _Kind:
    """What a failure has in common with others that no known mistake explains."""
    difference = failure.main_difference
    if isinstance(difference, OtherRuling):
        return _Kind(*_in_words(difference.right, difference.given, failure.case.clauses[0]), conceptual=False)
    if isinstance(difference, OtherReading):
        return _Kind(*reading_mistake(difference, failure.case))
    if isinstance(difference, Raised):
        return _Kind(
            f"{difference.error} is raised{difference.where}", "Every request gets exactly one verdict (R5.2)."
        )
    if isinstance(difference, Unreadable):
        return _Kind(difference.looks_like, difference.rule)
    return _LOT


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
