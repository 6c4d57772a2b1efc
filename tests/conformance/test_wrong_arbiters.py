"""The suite is tested too: each wrong arbiter is caught by the group of cases that is about its mistake."""

from fnmatch import fnmatchcase

import pytest
from conformance.wrong_arbiters import WRONG, PlainArbiter

from catch_arena.conformance.case_files import load_cases
from catch_arena.conformance.cases import ArbiterCase
from catch_arena.testing import run_conformance


def test_a_right_arbiter_with_lots_of_its_own_passes():
    """Any one of the tied may win, if it is one only and always the same."""
    report = run_conformance(PlainArbiter())
    assert report.passed, str(report)
    assert not run_conformance(PlainArbiter(), only=["ties"], exact_lots=True).passed


@pytest.mark.parametrize(
    ("wrong", "group", "looks_like"), WRONG, ids=[f"{group}-{wrong.__name__}" for wrong, group, _ in WRONG]
)
def test_a_wrong_arbiter_is_caught_and_told_its_mistake(wrong: type[PlainArbiter], group: str, looks_like: str):
    """By at least one case of its group, with words that say what is wrong, and not with many."""
    report = run_conformance(wrong(), only=[f"{group}."])
    assert report.failures
    for failure in report.failures:
        assert failure.case.group == group
        assert all(difference.expected != difference.got for difference in failure.differences)
    assert fnmatchcase(report.diagnoses[0].looks_like, looks_like)
    assert str(report).count("\n") < 20 * len(report.diagnoses) + 4


def test_every_group_with_cases_for_arbiters_catches_one():
    groups = {case.group for case in load_cases() if isinstance(case, ArbiterCase)}
    assert groups == {group for _, group, _ in WRONG}
