"""A node graded by a spec: what its service answers in cases of the conformance suite, and points."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from catch_arena.conformance.answers import counted
from catch_arena.conformance.cases import ArbiterCase, ArenaCase
from catch_arena.conformance.report import Report
from catch_arena.errors import ConfigError
from catch_arena.ros.node_tests.cases import NodeLostError, can_be_asked, run_on_node
from catch_arena.ros.node_tests.node_under_test import NodeUnderTest
from catch_arena.testing import select_cases
from catch_arena.tournament.grading import GradingSpec, GradingTest


@dataclass(frozen=True, slots=True)
class NodeGrade:
    """What one test gave."""

    test: str
    points: float
    """Those of the test where no case failed, else 0."""
    possible: float
    cases: int
    passed: int
    failures: tuple[str, ...]
    """A line for the clause, or the clauses, of each failed case, after one that says where the node fell silent, if it
    did.
    """
    hints: tuple[str, ...]
    log: str = ""

    def __str__(self) -> str:
        """For people: what was asked, then which clauses failed, then what that looks like."""
        head = (
            f"{'failed' if self.failures else 'passed'}  {self.points:g}/{self.possible:g}  {self.test}: "
            f"{self.passed} of {counted(self.cases, 'case')}"
        )
        return "\n        ".join([head, *self.failures, *(f"hint: {hint}" for hint in self.hints)])


def grade_node(spec: GradingSpec, node: NodeUnderTest) -> Iterator[NodeGrade]:
    """The tests of a spec, one after the other. A node that ends or falls silent keeps what it has earned, and gets
    nothing for that test and the rest; the cases that it had answered are told.

    Raises:
        ConfigError: for a test without cases that can be asked of a service, before any is asked.
        MissingServiceError: where the service is not there.
    """
    tests = [(test, _cases(test)) for test in spec.tests]
    node.meet()
    lost: NodeLostError | None = None
    for test, cases in tests:
        if lost is not None:
            yield NodeGrade(test.name, 0.0, test.points, len(cases), 0, (str(lost),), ())
            continue
        try:
            report = run_on_node(node, cases)
        except NodeLostError as error:
            lost = error
            told = _grade(test, lost.before)
            yield replace(told, points=0.0, cases=len(cases), failures=(str(lost), *told.failures))
        else:
            if not any(result.played for result in report.results):
                raise ConfigError(f"{test.name}: none of its cases can be asked of a node that keeps the list itself")
            yield _grade(test, report)


def _cases(test: GradingTest) -> list[ArbiterCase | ArenaCase]:
    if not test.cases:
        raise ConfigError(f'{test.name}: cases must be given for a node, as in cases = ["reach", "names"]')
    try:
        found = [case for case in select_cases(test.cases) if can_be_asked(case)]
    except ConfigError as error:
        raise ConfigError(f"{test.name}: {error}") from None
    if not found:
        raise ConfigError(f"{test.name}: none of its cases can be asked of a service: it knows one hunter, and names")
    return found


def _grade(test: GradingTest, report: Report) -> NodeGrade:
    played = sum(result.played for result in report.results)
    by_clauses: dict[str, list[str]] = {}
    for failure in report.failures:
        by_clauses.setdefault(", ".join(failure.case.clauses), []).append(failure.case.id)
    return NodeGrade(
        test=test.name,
        points=0.0 if report.failures else test.points,
        possible=test.points,
        cases=played,
        passed=played - len(report.failures),
        failures=tuple(
            f"{clauses}: {counted(len(ids), 'case')}: {', '.join(ids)}" for clauses, ids in by_clauses.items()
        ),
        hints=tuple(f"it looks like «{one.looks_like}». {one.rule}" for one in report.diagnoses),
    )
