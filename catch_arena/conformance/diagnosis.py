"""Causes of failed cases: an error that is raised, a known mistake that fails the same cases, or a clause."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Final

import msgspec

from catch_arena.conformance.adjudicator_calls import KINDS, OF_GRANTS, NoRuling
from catch_arena.conformance.comparison import Compared
from catch_arena.conformance.results import Failure, Result
from catch_arena.files import tomllib

_TOLERATED: Final = 0.1
"""Largest number of cases that may contradict a mistake, as a share of the cases that it explains."""

_WEAKNESS: Final = {**dict.fromkeys(OF_GRANTS, 0), "verdict": 1, "evidence": 2, "": 3}
"""Kinds of failures from wrong grants, the strongest, to those without a kind."""

Ids = Mapping[str, tuple[str, ...]]
"""Names of cases by group."""


class Mistake(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A wrong rule, and the cases that an arbiter with it fails: a table of mistakes.toml."""

    looks_like: str
    rule: str
    """The rulebook's rule."""
    winner: Ids = {}
    granted: Ids = {}
    refused: Ids = {}
    verdict: Ids = {}
    evidence: Ids = {}
    """Cases that it fails, by the kind of failure (KINDS)."""

    def kinds(self, compared: Compared) -> dict[str, str]:
        """Return the kinds of its failures under a comparison: one of KINDS by the ids of cases."""
        found = {"evidence": KINDS, "verdicts": KINDS[:-1], "success": OF_GRANTS}[compared]
        return {
            f"{group}.{name}": kind for kind in found for group, names in getattr(self, kind).items() for name in names
        }


@cache
def known_mistakes() -> tuple[Mistake, ...]:
    """Return the mistakes in the order of mistakes.toml; of two that fit equally well the first is named."""
    text = (files("catch_arena.conformance") / "mistakes.toml").read_text(encoding="utf-8")
    return msgspec.convert(tomllib.loads(text)["mistake"], tuple[Mistake, ...])


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """Failures that have something in common."""

    looks_like: str
    """A known mistake, an error, or a clause."""
    rule: str
    """The rulebook's rule, or ""."""
    failures: tuple[Failure, ...]
    """The failed cases, in the order of the suite."""
    known: bool = False
    """True if an arbiter with a known mistake fails these cases."""


def diagnose(results: Sequence[Result], compared: Compared) -> tuple[Diagnosis, ...]:
    """Return diagnoses that contain each failure once: errors and unreadable answers, known mistakes, then clauses.

    In each of these three kinds, wrong grants come before wrong verdicts and those before wrong evidence, and then the
    diagnosis with the most failures comes first.
    """
    failures = {result.case.id: result.failure for result in results if result.failure is not None}
    groups: dict[tuple[str, str], list[Failure]] = {}
    judged = {}
    for id_, failure in failures.items():
        difference = failure.differences[0]
        if isinstance(difference, NoRuling):
            groups.setdefault((difference.looks_like, difference.rule), []).append(failure)
        else:
            judged[id_] = failure
    unreadable = [Diagnosis(*kind, tuple(group)) for kind, group in groups.items()]
    passed = {result.case.id for result in results if result.played and result.failure is None}
    known = _known(judged, passed, compared)
    explained = {failure.case.id for diagnosis in known for failure in diagnosis.failures}
    clauses: dict[str, list[Failure]] = {}
    for id_, failure in judged.items():
        if id_ not in explained:
            clauses.setdefault(failure.case.clauses[0], []).append(failure)
    by_clause = [Diagnosis(clause, "", tuple(group)) for clause, group in clauses.items()]
    return tuple(one for kind in (unreadable, known, by_clause) for one in sorted(kind, key=_weakness_and_number))


def _weakness_and_number(diagnosis: Diagnosis) -> tuple[int, int]:
    return min(_WEAKNESS[failure.kind] for failure in diagnosis.failures), -len(diagnosis.failures)


def _known(failed: Mapping[str, Failure], passed: set[str], compared: Compared) -> list[Diagnosis]:
    """Return the mistakes that explain the most failures, less the cases that contradict them, one after the other.

    A case contradicts a mistake that fails it if it passed, or if it failed by a weaker kind of difference.
    """
    fitting = []
    for mistake in known_mistakes():
        kinds = mistake.kinds(compared)
        explained = {id_ for id_, kind in kinds.items() if id_ in failed and failed[id_].kind == kind}
        weaker = {id_ for id_, kind in kinds.items() if id_ in failed and _WEAKNESS[failed[id_].kind] > _WEAKNESS[kind]}
        contradicted = len(weaker) + len(kinds.keys() & passed)
        if contradicted <= _TOLERATED * len(explained):
            fitting.append((mistake, explained, contradicted))
    left, found = set(failed), list[Diagnosis]()
    while fitting:
        mistake, ids, contradicted = max(fitting, key=lambda fit: len(fit[1] & left) - fit[2])
        new = ids & left
        if len(new) <= contradicted:
            break
        found.append(
            Diagnosis(mistake.looks_like, mistake.rule, tuple(failed[id_] for id_ in failed if id_ in new), True)
        )
        left -= new
    return found
