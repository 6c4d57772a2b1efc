"""The suite is tested too: each wrong arbiter is caught by the group of cases that is about its mistake."""

import pytest
from conformance.wrong_arbiters import WRONG, PlainArbiter

from catch_arena.conformance.cases import ArbiterCase
from catch_arena.conformance.files import load_cases
from catch_arena.testing import run_conformance


def test_a_right_arbiter_with_lots_of_its_own_passes():
    """Any one of the tied may win, if it is one only and always the same."""
    report = run_conformance(PlainArbiter())
    assert report.passed, str(report)
    assert not run_conformance(PlainArbiter(), only=["ties"], exact_lots=True).passed


@pytest.mark.parametrize(("wrong", "group"), WRONG, ids=[f"{group}-{wrong.__name__}" for wrong, group in WRONG])
def test_a_wrong_arbiter_is_caught(wrong: type[PlainArbiter], group: str):
    """By at least one case of its group, with words that say what is wrong."""
    report = run_conformance(wrong(), only=[f"{group}."])
    assert report.failures
    for failure in report.failures:
        assert failure.case.group == group
        assert all(difference.expected != difference.got for difference in failure.differences)


def test_every_group_with_cases_for_arbiters_catches_one():
    groups = {case.group for case in load_cases() if isinstance(case, ArbiterCase)}
    assert groups == {group for _, group in WRONG}
