"""Reports name the mistakes of a wrong arbiter, each with one failure in full."""

import math
import re
from collections.abc import Iterable
from typing import Any

import pytest
from conformance.wrong_arbiters import KNOWN

from catch_arena.arbitration import arbitrate
from catch_arena.testing import Report, run_conformance


def counts(report: Report) -> dict[str, int]:
    return {one.looks_like: len(one.failures) for one in report.diagnoses}


def ids(failures: Iterable[Any]) -> list[str]:
    return sorted(failure.case.id for failure in failures)


def count_in_full(text: str) -> int:
    return len(re.findall(r"^ *FAILED [a-z]+\.", text, re.MULTILINE))


def minimal(*, hunters: Any, targets: Any, requests: Any, reach_m: float, **_: Any) -> list[Any]:
    """Find the winner, and check nothing else."""
    away = {seat: math.dist(hunters[seat], targets[name]) for seat, name in requests if name in targets}
    best: dict[str, int] = {}
    for seat, name in requests:
        if name in targets and away[seat] <= reach_m and (name not in best or away[seat] < away[best[name]]):
            best[name] = seat
    rulings: list[Any] = []
    for seat, name in requests:
        if name not in targets:
            rulings.append(("UNKNOWN_TARGET", seat, name))
            continue
        distance = round(1e6 * math.dist(hunters[seat], targets[name]))
        if distance > 1e6 * reach_m:
            rulings.append(("OUT_OF_REACH", seat, name, distance))
        else:
            verdict = "GRANTED" if seat == best.get(name) else "LOST_CONTEST"
            rulings.append((verdict, seat, name, distance, best.get(name)))
    return rulings


def service(*, hunters: Any, targets: Any, requests: Any, reach_m: float, **_: Any) -> list[Any]:
    """The original's service, with the least that makes it a referee."""
    left = dict(targets)
    returned = []
    for hunter, name in requests:
        if name not in left:
            returned.append(("UNKNOWN_TARGET", hunter, name, None, None))
            continue
        x, y = left[name]
        dx, dy = hunters[hunter][0] - x, hunters[hunter][1] - y
        if dx * dx + dy * dy <= reach_m:
            del left[name]
            returned.append(("GRANTED", hunter, name, None, None))
        else:
            returned.append(("OUT_OF_REACH", hunter, name, None, None))
    return returned


def first_come(*, hunters: Any, targets: Any, requests: Any, reach_m: Any, **_: Any) -> list[Any]:
    """Take the requests in their order; no evidence, no duplicates, no hunters that are out."""
    returned, taken = [], set()
    for hunter, name in requests:
        reach = reach_m if isinstance(reach_m, float) else reach_m[hunter]
        if name not in targets:
            verdict = "ALREADY_CAUGHT"
        elif math.dist(hunters[hunter], targets[name]) >= reach:
            verdict = "OUT_OF_REACH"
        else:
            verdict = "LOST_CONTEST" if name in taken else "GRANTED"
            taken.add(name)
        returned.append((verdict, hunter, name))
    return returned


@pytest.mark.parametrize("evidence", [True, False])
@pytest.mark.parametrize(
    ("student", "named"),
    [
        (first_come, "first come, first served"),
        (minimal, "reach is tested in floats, with <="),
        (service, "the distance is squared: the square root is missing"),
    ],
)
def test_a_students_arbiter_is_told_its_mistakes_on_one_page(student, named, evidence):
    """Each failure stands in one diagnosis; the first diagnoses have a case in full."""
    report = run_conformance(student, evidence=evidence)
    found = counts(report)
    assert named in found, str(report)
    assert ids(failure for one in report.diagnoses for failure in one.failures) == ids(report.failures)
    text = str(report)
    assert text.count("\n") < 60
    assert count_in_full(text) >= min(2, len(found))
    words = " ".join(text.split())  # as they are without line breaks
    assert f'looks like "{named}"' in words


def test_the_real_mistake_comes_before_exceptions():
    """A student wrote <= for reach, and did not think of all names."""

    def inclusive(*, requests: Any, **given: Any) -> Any:
        if not all(isinstance(name, str) for _, name in requests):
            raise TypeError("a name")
        return KNOWN["reach is tested in floats, with <="](requests=requests, **given)

    report = run_conformance(inclusive)
    assert [one.looks_like.partition(" (")[0] for one in report.diagnoses] == [
        "reach is tested in floats, with <=",
        "TypeError is raised",
    ]
    assert str(report).splitlines()[3].startswith("FAILED reach.300000-is-out ")


@pytest.mark.parametrize(
    ("mistake", "shown"),
    [
        ("first come, first served", "claimants.two"),
        ("a refused kill is GRANTED", "outages.kill-refused"),
    ],
)
def test_the_smallest_case_of_the_strongest_kind_is_shown(mistake, shown):
    report = run_conformance(KNOWN[mistake])
    assert report.diagnoses[0].failures[0].case.id == shown
    assert f"FAILED {shown} " in str(report)


def test_a_long_word_is_broken():
    def long_winded(**_: Any) -> Any:
        raise ValueError("turtle" * 30)

    text = str(run_conformance(long_winded, only=["claimants.two"]))
    assert max(map(len, text.splitlines())) == 80
    assert "turtle" * 30 in "".join(text.split())


def test_a_lot_that_always_falls_alike_is_told_though_the_evidence_is_missing():
    """Wrong verdicts come before missing evidence, whichever variant has them."""

    def lowest(**case: Any) -> list[Any]:
        lots = arbitrate(**{**case, "seed": 1, "step": 0})
        return [(one.verdict, one.hunter, one.target) for one in lots]

    report = run_conformance(lowest, only=["ties.fair-between-two"])
    (failure,) = report.failures
    assert failure.kind == "winner"
    assert "wins in some of the steps" in str(failure)


def test_a_large_case_is_told_briefly_but_with_all():
    """Sixteen hunters, each of whom is answered wrongly."""
    report = run_conformance(
        lambda **case: [("SERVICE_DOWN", *one) for one in case["requests"]], only=["claimants.sixteen"]
    )
    assert "and 14 more" in str(report)
    assert str(report).count("\n") < 30
    assert report.in_full().count("hunter 15 at") == 1
    assert report.in_full().count("got SERVICE_DOWN") == 16
    assert "hunter 15 at" not in str(report)


def test_verdicts_are_enough_for_a_diagnosis():
    """For an arbiter that does not give evidence yet."""

    def bare(**case: Any) -> list[tuple[object, ...]]:
        return [(one["verdict"], one["hunter"], one["target"]) for one in KNOWN["first come, first served"](**case)]

    report = run_conformance(bare, evidence=False)
    assert list(counts(report)) == ["first come, first served"]
    report = run_conformance(bare)
    assert set(counts(report)) >= {"first come, first served", "no evidence is given"}


def crashes(**case: Any) -> Any:
    return [case["targets"][name] for _, name in case["requests"]]


def grants_everything(**case: Any) -> Any:
    return [("granted", hunter, name) for hunter, name in case["requests"]]


def forgets_one_or_all(**case: Any) -> Any:
    return arbitrate(**case)[:-1] if len(case["requests"]) > 1 else None


@pytest.mark.parametrize(
    ("arbiter", "looks_like", "rule"),
    [
        (crashes, r"KeyError is raised (test_diagnosis.py, line ", "exactly one verdict (R5.2)"),
        (grants_everything, "verdict cannot be read", "It must be one of MATCH_OVER"),
        (forgets_one_or_all, "too few rulings are returned, or None", "a list with one ruling for each request"),
    ],
)
def test_answers_that_cannot_be_read_are_grouped_by_what_is_wrong(arbiter, looks_like, rule):
    report = run_conformance(arbiter, only=["names", "claimants.two"])
    found = next(one for one in report.diagnoses if one.looks_like.startswith(looks_like))
    assert rule in found.rule
    assert not found.known
    assert len(found.failures) > 1
    assert found is report.diagnoses[0]


def test_what_no_known_mistake_fails_is_grouped_by_clause():
    """Here everybody is refused now and then, by a rule that nobody has thought of."""

    def moody(**case: Any) -> Any:
        rulings = arbitrate(**case)
        grumpy = math.fsum(x for x, _ in case["hunters"]) > 16.0
        return [
            (("SERVICE_DOWN" if grumpy and one.verdict.name == "GRANTED" else one.verdict), one.hunter, one.target)
            for one in rulings
        ]

    report = run_conformance(moody, evidence=False)
    others = [one for one in report.diagnoses if not one.known]
    assert others
    for one in others:
        assert {failure.case.clauses[0] for failure in one.failures} == {one.looks_like}
        assert one.rule == ""
