"""Our five adjudicators answer every conformance case: oracle, `arbitrate`, engine, a row of a batch, parallel env."""

import pytest
from conformance.arenas import AdjudicatorUnderTest, OracleUnderTest
from conformance.wrong_arenas import WRONG
from oracle.arbiter import judge
from rulebook.adjudicators import ADJUDICATORS

from catch_arena.arbitration import arbitrate
from catch_arena.conformance.cases import ArbiterCase, load_cases
from catch_arena.testing import run_conformance


@pytest.mark.parametrize("arbiter", [judge, arbitrate], ids=["oracle", "arbitrate"])
def test_an_arbiter_of_ours_answers_every_case(arbiter):
    """With the lots of the rulebook's appendix."""
    report = run_conformance(arbiter, exact_lots=True)
    assert report.passed, str(report)
    assert sum(result.played for result in report.results) == sum(
        isinstance(case, ArbiterCase) for case in load_cases()
    )


@pytest.mark.parametrize("kind", ADJUDICATORS)
def test_an_arena_of_ours_answers_every_case_that_it_can_play(kind):
    """Cases that need an arena, and cases for arbiters whose requests can be made by rank."""
    report = run_conformance(arena=AdjudicatorUnderTest(kind))
    assert report.passed, str(report)
    of_arbiters = sum(result.played and isinstance(result.case, ArbiterCase) for result in report.results)
    played = sum(result.played for result in report.results)
    assert of_arbiters >= 100
    assert played - of_arbiters == sum(not isinstance(case, ArbiterCase) for case in load_cases())


@pytest.mark.parametrize(("group", "wrong"), WRONG, ids=[f"{group}-{wrong.__name__}" for group, wrong in WRONG])
def test_a_wrong_arena_is_caught(group, wrong):
    """By at least one case of its group, and not for raising an error."""
    report = run_conformance(arena=OracleUnderTest(wrong), only=[f"{group}."])
    assert report.failures
    assert not any("raised" in difference.got for failure in report.failures for difference in failure.differences)


def test_every_group_with_cases_for_arenas_catches_a_wrong_one():
    groups = {case.group for case in load_cases() if not isinstance(case, ArbiterCase)}
    assert groups <= {group for group, _ in WRONG}
