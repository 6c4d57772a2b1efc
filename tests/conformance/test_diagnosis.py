"""What a wrong arbiter is told: its mistakes by name, wrong ideas first, each with a failure, and not much more."""

import hashlib
import math
import re
from collections.abc import Iterable
from typing import Any

import pytest
from conformance.students import Referee, minimal, one_loop, service
from conformance.wrong_arbiters import AlwaysCapstone, FirstCome, PlainArbiter
from hypothesis import given, settings
from hypothesis import strategies as st

from catch_arena.arbitration import arbitrate
from catch_arena.conformance.case_files import load_cases
from catch_arena.conformance.cases import ArbiterCase
from catch_arena.conformance.mistakes.known_mistakes import KNOWN, Mistake, rules_with
from catch_arena.conformance.mistakes.replaceable_rules import Request, Rules, judge
from catch_arena.testing import Report, run_conformance


def mistaken(*mistakes: Mistake) -> Any:
    """An arbiter with these mistakes, and with lots of its own."""

    def arbiter(**case: Any) -> list[tuple[object, ...]]:
        def ticket(request: Request) -> bytes:
            words = f"{case['seed']} {case['step']} {request.target} {request.hunter}"
            return hashlib.blake2b(words.encode()).digest()

        requests = judge(rules_with(mistakes), case, lot=lambda tied: min(tied, key=ticket))
        return [(one.verdict, one.hunter, one.name, one.distance_um, one.winner) for one in requests]

    return arbiter


def known(*names: str) -> list[Mistake]:
    return [next(one for one in KNOWN if one.looks_like == name) for name in names]


def counts(report: Report) -> dict[str, int]:
    return {one.looks_like: len(one.failures) for one in report.diagnoses}


def ids(failures: Iterable[Any]) -> list[str]:
    return sorted(failure.case.id for failure in failures)


def count_in_full(text: str) -> int:
    return len(re.findall(r"^ *FAILED [a-z]+\.", text, re.MULTILINE))


def test_rules_without_a_mistake_are_right():
    report = run_conformance(mistaken())
    assert report.passed, report
    assert not report.diagnoses


SEATS, NAMES = st.integers(0, 3), st.sampled_from(["a", "b", "gone", "nobody", "", "a" * 256, 7, None])
PLACES = st.tuples(*[st.integers(-3, 3).map(lambda part: 5 + part / 10)] * 2)  # so coarse that there are ties


@settings(max_examples=150, deadline=None)
@given(
    hunters=st.lists(PLACES, min_size=4, max_size=4),
    targets=st.fixed_dictionaries({"a": PLACES, "b": PLACES}),
    requests=st.lists(st.tuples(SEATS, NAMES), max_size=6),
    reach_m=st.sampled_from([0.3, 0.2, 1e-9]),
    policy=st.sampled_from(["nearest", "first_come", "capstone"]),
    inactive=st.sets(SEATS, max_size=2),
    kill_refused=st.sets(st.sampled_from(["a", "b"])),
    kill_service_up=st.booleans(),
    match_over=st.integers(0, 9).map(lambda chance: chance == 0),
)
def test_rules_without_a_mistake_rule_as_arbitrate_does(**case):
    """Another implementation, with lots drawn as there."""
    case |= {"caught": ["gone"], "seed": 3, "step": 5}
    rulings = arbitrate(**case)
    judged = judge(Rules(), case, rulings)
    assert [(one.verdict, one.hunter, one.distance_um, one.winner) for one in judged] == [
        (one.verdict, one.hunter, one.distance_um, one.winner) for one in rulings
    ]


def test_every_known_mistake_has_a_name_of_its_own_and_answers_some_case_otherwise():
    assert len({one.looks_like for one in KNOWN}) == len(KNOWN)
    cases = [case.arguments() for case in load_cases() if isinstance(case, ArbiterCase)]
    right = [mistaken()(**case) for case in cases]
    harmless = {one.looks_like for one in KNOWN if [mistaken(one)(**case) for case in cases] == right}
    assert harmless == {
        "ALREADY_CAUGHT is tested before UNKNOWN_TARGET",  # no name is both; the rulebook has an order even so
        "the nearest is found in floats, not in whole micrometres",  # shows in other variants
    }


@pytest.mark.parametrize(
    ("wrong", "looks_like", "lines"),
    [(FirstCome, "first come, first served", 24), (AlwaysCapstone, "the policy is always capstone", 24)],
)
def test_one_mistake_is_one_diagnosis_of_all_cases(wrong: type[PlainArbiter], looks_like: str, lines: int):
    """With one failure in full, and the others by name."""
    report = run_conformance(wrong())
    (diagnosis,) = report.diagnoses
    assert (diagnosis.looks_like, diagnosis.known, diagnosis.shared) == (looks_like, True, 0)
    assert ids(diagnosis.failures) == ids(report.failures)
    text = str(report)
    assert text.startswith(f'1. looks like "{looks_like}": {len(report.failures)} failures\n')
    assert count_in_full(text) == 1
    assert f"{len(report.failures) - 1} more: " in text
    assert text.count("\n") < lines
    assert count_in_full(report.in_full()) == len(report.failures)


@pytest.mark.parametrize(
    "names",
    [
        ("first come, first served", "within reach is tested with <="),
        ("the lowest seat wins", "no winner is given", "DUPLICATE is never said"),
        ("reach is tested in floats", "spaces around names do not matter", "HUNTER_INACTIVE is never said"),
    ],
)
def test_several_mistakes_are_told_apart(names):
    """Also where a case needs two of them to go wrong as it does."""
    report = run_conformance(mistaken(*known(*names)))
    assert set(counts(report)) == set(names)
    assert all(one.known for one in report.diagnoses)


@pytest.mark.parametrize(
    ("student", "largest", "others"),
    [
        (
            one_loop,
            "ties go to the first request",
            {"MALFORMED is never said", "within reach is tested with <=", "the policy is always nearest"},
        ),
        (
            Referee(),
            "distances are cut off, not rounded",
            {"no winner is given", "an empty name is MALFORMED", "spaces around names do not matter"},
        ),
        (
            service,
            "first come, first served",
            {"no evidence is given", "the distance is a square: the root is missing", "DUPLICATE is never said"},
        ),
    ],
)
def test_a_students_arbiter_is_told_its_mistakes(student, largest, others):
    """Each failure stands in one diagnosis; ten of them have a case, in a dozen lines or so, and the others the name
    of one.
    """
    groups = ["basics", "claimants", "duplicates", "inactive", "names", "reach", "policies"]
    report = run_conformance(student, only=[*groups, *([] if student is service else ["ties", "outages"])])
    found = counts(report)
    assert next(iter(found)) == largest
    assert others <= set(found)
    assert ids(failure for one in report.diagnoses for failure in one.failures) == ids(report.failures)
    text = str(report)
    assert count_in_full(text) == min(10, len(found))
    assert text.count("\n") < 16 * len(found)
    words = " ".join(text.split())  # as they are without line breaks
    assert all(name in words for name in found)
    assert all(one.failures[0].case.id in words for one in report.diagnoses)


def test_a_wrong_idea_is_told_before_evidence_that_is_missing_in_more_cases():
    """Who asks first gets the target, and nobody learns a distance or a winner."""

    def in_turn(*, hunters: Any, targets: Any, requests: Any, reach_m: float, **_: Any) -> list[Any]:
        served: set[str] = set()
        rulings: list[Any] = []
        for seat, name in requests:
            if name not in targets:
                rulings.append(("UNKNOWN_TARGET", seat, name))
            elif math.dist(hunters[seat], targets[name]) >= reach_m:
                rulings.append(("OUT_OF_REACH", seat, name))
            else:
                rulings.append(("LOST_CONTEST" if name in served else "GRANTED", seat, name))
                served.add(name)
        return rulings

    report = run_conformance(in_turn, only=["claimants", "eligibility", "reach"])
    first, *others = report.diagnoses
    assert "first come" in first.looks_like or "first request" in first.looks_like, str(report)
    assert max(len(one.failures) for one in others) > len(first.failures)


def test_wrong_ideas_are_told_before_what_is_left_out_and_each_kind_by_its_size():
    """Although the least arbiter says nothing of duplicates in more cases than those where its `<=` shows."""
    report = run_conformance(minimal, only=["basics", "claimants", "duplicates", "eligibility", "reach", "names.list"])
    ideas = [one for one in report.diagnoses if one.conceptual]
    assert report.diagnoses[: len(ideas)] == tuple(ideas)
    for kind in (ideas, report.diagnoses[len(ideas) :]):
        sizes = [len(one.failures) for one in kind]
        assert sizes == sorted(sizes, reverse=True)
    found = list(counts(report))
    assert found[0] == "reach is tested in floats, with <="
    assert counts(report)["DUPLICATE is never said"] > counts(report)[found[0]]
    full = str(report).partition("\n\n")[0]
    assert "FAILED reach." in full
    assert "expected OUT_OF_REACH, 300000 um away; got GRANTED" in full
    assert [one.looks_like for one in ideas if one.looks_like.startswith("TypeError is raised (students.py, line")]


def test_a_large_case_is_told_briefly_but_with_all():
    """Sixteen hunters, each of whom is answered wrongly."""
    report = run_conformance(
        lambda **case: [("SERVICE_DOWN", *one) for one in case["requests"]], only=["claimants.sixteen"]
    )
    assert "and 14 more" in str(report)
    assert str(report).count("\n") < 30
    assert report.in_full().count("hunter 15 at") == 1
    assert "hunter 15 at" not in str(report)


@pytest.mark.parametrize(
    ("metres", "name"),
    [
        (lambda dx, dy: abs(dx) + abs(dy), "dx + dy"),
        (lambda dx, dy: max(abs(dx), abs(dy)), "the larger one of dx and dy"),
    ],
)
def test_another_measure_in_contests_alone_or_in_the_reach_alone_is_named(metres, name):
    """By a second implementation, of contests and nothing else."""

    def measured(reach: Any, contest: Any) -> Any:
        def arbiter(**case: Any) -> list[tuple[object, ...]]:
            def away(seat: int, named: str) -> tuple[float, float]:
                return tuple(
                    one - other for one, other in zip(case["hunters"][seat], case["targets"][named], strict=True)
                )

            near = [one for one in case["requests"] if reach(*away(*one)) < 0.3]
            best: dict[str, int] = {}
            for one in sorted(near, key=lambda one: contest(*away(*one))):
                best.setdefault(one[1], one[0])
            answers: list[tuple[object, ...]] = []
            for seat, named in case["requests"]:
                distance = round(1e6 * math.hypot(*away(seat, named)))
                if (seat, named) in near:
                    verdict = "GRANTED" if seat == best[named] else "LOST_CONTEST"
                    answers.append((verdict, seat, named, distance, best[named]))
                else:
                    answers.append(("OUT_OF_REACH", seat, named, distance))
            return answers

        return arbiter

    for arbiter, looks_like in (
        (measured(math.hypot, metres), f"the nearest is found by {name}"),
        (measured(metres, math.hypot), f"reach is tested by {name}"),
    ):
        assert looks_like in counts(run_conformance(arbiter, only=["claimants", "reach.no-"]))


def test_verdicts_are_enough_for_a_diagnosis():
    """For an arbiter that does not give evidence yet."""

    def bare(**case: Any) -> list[tuple[object, ...]]:
        return [ruling[:3] for ruling in mistaken(*known("first come, first served"))(**case)]

    report = run_conformance(bare, only=["claimants", "basics"], evidence=False)
    assert list(counts(report)) == ["first come, first served"]
    report = run_conformance(bare, only=["claimants", "basics"])
    assert set(counts(report)) == {"no evidence is given", "first come, first served"}


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
        (forgets_one_or_all, "None or too few rulings are returned", "a list with one ruling for each request"),
    ],
)
def test_answers_that_cannot_be_read_are_grouped_by_what_is_wrong(arbiter, looks_like, rule):
    report = run_conformance(arbiter, only=["names", "claimants.two"])
    found = next(one for one in report.diagnoses if one.looks_like.startswith(looks_like))
    assert rule in found.rule
    assert not found.known
    assert len(found.failures) > 1
    assert found is report.diagnoses[0]
    if arbiter is forgets_one_or_all:
        assert len(report.diagnoses) == 1
        assert {len(failure.case.expected) for failure in found.failures} >= {1, 2}
        assert "expected 1 ruling, one for each request, in their order; got None" in " ".join(str(report).split())


def test_rulings_in_another_order_than_the_requests_are_told():
    """As of an arbiter that goes target by target."""

    def by_target(**case: Any) -> Any:
        return sorted(arbitrate(**case), key=lambda ruling: str(ruling.target))

    report = run_conformance(by_target, only=["basics", "claimants", "identity"])
    assert list(counts(report)) == ["the rulings are not in the order of the requests"]


def test_what_no_known_mistake_answers_is_grouped_by_clause_and_verdicts():
    """Here everybody is refused now and then, by a rule that nobody has thought of."""

    def moody(**case: Any) -> Any:
        rulings = arbitrate(**case)
        grumpy = len(case["hunters"]) == 3
        return [
            (("SERVICE_DOWN" if grumpy and one.verdict.name == "GRANTED" else one.verdict), one.hunter, one.target)
            for one in rulings
        ]

    report = run_conformance(moody, evidence=False)
    others = [one for one in report.diagnoses if one.looks_like != "a lot is drawn wrongly"]
    assert len(others) > 1
    for one in others:
        assert not one.known
        assert {f"SERVICE_DOWN where GRANTED is right ({failure.case.clauses[0]})" for failure in one.failures} == {
            one.looks_like
        }
        assert one.rule == "GRANTED means: caught (R5.4)."
