"""Grades of a node by a spec: points for conformance cases that its service answers right."""

from collections.abc import Iterator

from catch_arena.conformance.adjudicator_calls import counted
from catch_arena.conformance.cases import ArbiterCase, ArenaCase
from catch_arena.conformance.report import Report
from catch_arena.errors import ConfigError
from catch_arena.ros.node_tests.cases import fits_a_service, run_on_node
from catch_arena.ros.node_tests.node_under_test import NodeUnderTest
from catch_arena.testing import select_cases
from catch_arena.tournament.grading import TestGrade
from catch_arena.tournament.grading_spec import GradingSpec, GradingTest


def grade_node(spec: GradingSpec, node: NodeUnderTest) -> Iterator[TestGrade]:
    """Yield a node's grades in the tests of a spec, one after the other. A request without an answer fails its case.

    Raises:
        ConfigError: for a test without cases that can be asked of a service, before the first request.
        BusError: if no node serves the service.
    """
    tests = [(test, cases_of(test)) for test in spec.tests]
    node.wait_for_node()
    for test, cases in tests:
        yield _grade(test, run_on_node(node, cases))


def cases_of(test: GradingTest) -> list[ArbiterCase | ArenaCase]:
    """Return the cases of a test that can be asked of a service.

    Raises:
        ConfigError: if there are none.
    """
    if not test.cases:
        raise ConfigError(f'{test.name}: cases must be given for a node, as in cases = ["reach", "names"]')
    try:
        found = [case for case in select_cases(test.cases) if fits_a_service(case)]
    except ConfigError as error:
        raise ConfigError(f"{test.name}: {error}") from None
    if not found:
        raise ConfigError(
            f"{test.name}: none of its cases can be asked of a service, which has one hunter and names only"
        )
    return found


def _grade(test: GradingTest, report: Report) -> TestGrade:
    """Return a grade; its failures have one line for each set of clauses of failed cases.

    Raises:
        ConfigError: if no case was played.
    """
    played = sum(result.played for result in report.results)
    if not played:
        raise ConfigError(f"{test.name}: none of its cases can be asked of a node that publishes the list itself")
    by_clauses: dict[str, list[str]] = {}
    for failure in report.failures:
        by_clauses.setdefault(", ".join(failure.case.clauses), []).append(failure.case.id)
    passed = played - len(report.failures)
    return TestGrade(
        test=test.name,
        points=0.0 if report.failures else test.points,
        possible=test.points,
        figures={"cases": played, "passed": passed},
        measured=f"{passed} of {counted(played, 'case')}",
        failures=tuple(
            f"{clauses}: {counted(len(ids), 'case')}: {', '.join(ids)}" for clauses, ids in by_clauses.items()
        ),
        hints=tuple(f"it looks like «{one.looks_like}». {one.rule}" for one in report.diagnoses),
    )
