"""Conformance cases that can be asked of a service by name, their run on a node, and a node's grades by a spec."""

import itertools
import secrets
import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np
from msgspec.structs import replace

from catch_arena.arbitration import arbitrate
from catch_arena.config import TURTLESIM_SIDE_M
from catch_arena.conformance.adjudicator_calls import NoRuling, describe_request
from catch_arena.conformance.cases import DEFAULTS, ArbiterCase, ArenaCase, ExpectedRuling
from catch_arena.conformance.comparison import compare
from catch_arena.conformance.report import Report
from catch_arena.conformance.results import Failure, Result
from catch_arena.errors import BusError, ConfigError
from catch_arena.ros.middleware.graph_names import TURTLE
from catch_arena.ros.node_tests.node_under_test import ANSWER_S, NodeUnderTest, Place
from catch_arena.testing import select_cases
from catch_arena.text import counted
from catch_arena.tournament.grading import TestGrade
from catch_arena.tournament.grading_spec import GradingSpec, GradingTest
from catch_arena.verdicts import Ruling, Verdict

_SETTLE_S: Final = (0.15, 1.0)
"""Time for which a position is published before the request [s]: in the first play of a case, and in the second."""
_FITS_S: Final = 30.0
"""Longest wait for a target in the node's own list around which a case fits between the walls [s]."""
_OWN_NAME: Final = "hunter_0"
"""Name of the hunter in the cases."""
_LONG: Final = 200
"""Length above which the length of a name may matter, so that it is kept [characters]."""

_Question = tuple[Mapping[str, Any], ExpectedRuling]
"""The arguments of `arbitrate` for one request, and the right answer."""


def fits_a_service(case: ArbiterCase | ArenaCase) -> bool:
    """Return whether a case can be asked of a service by name: one hunter, one request, usual circumstances, and the
    same answer for the float32 of a Pose.
    """
    if not isinstance(case, ArbiterCase) or len(case.hunters) != 1 or len(case.expected) != 1:
        return False
    usual = {key: value for key, value in case.circumstances.items() if key not in {"caught", "seed", "step"}}
    names = [case.expected[0].target, *case.targets, *case.circumstances["caught"]]
    if any(value != DEFAULTS[key] for key, value in usual.items()) or not all(map(_can_be_sent, names)):
        return False
    if "" in case.targets:  # a target without a name could be caught only once
        return False
    arguments = case.arguments() | {"hunters": [_float32(case.hunters[0])]}
    return arbitrate(**arguments)[0].verdict is case.expected[0].verdict


def run_on_node(node: NodeUnderTest, cases: Sequence[ArbiterCase | ArenaCase]) -> Report:
    """Play the cases that fit a service, after `wait_for_node`, and return a report; the others are not played."""
    return Report(tuple(_result(node, case) for case in cases), "success")


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
    """Return the cases of a test that can be asked of a service, or raise ConfigError if there are none."""
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


def _result(node: NodeUnderTest, case: ArbiterCase | ArenaCase) -> Result:
    """Play a case. A wrong answer counts only if it comes twice."""
    if not isinstance(case, ArbiterCase) or not (_fits_own(case) if node.publishes_list else fits_a_service(case)):
        return Result(case, None, 0.0, "cannot be asked of a service")
    start = time.perf_counter()
    failure: Failure | None = None
    for settle_s in _SETTLE_S:
        failure = _play(node, case, settle_s)
        if failure is None or isinstance(failure.differences[0], NoRuling):
            break
    return Result(case, failure, time.perf_counter() - start)


def _play(node: NodeUnderTest, case: ArbiterCase, settle_s: float) -> Failure | None:
    """Ask the questions of a case."""
    token = "" if node.publishes_list else f"{secrets.token_hex(4)}_"
    for arguments, expected in _questions_of_own(node, case) if node.publishes_list else _questions(case):
        name = str(expected.target)
        targets = {_sent(token, one): place for one, place in arguments["targets"].items()}
        success = node.request_catch(arguments["hunters"][0], targets, _sent(token, name), settle_s)
        if success is None:
            none_s = f"none within {ANSWER_S:g} s"
            silence = NoRuling(describe_request(1, expected), "an answer", none_s, "no answer comes")
            return Failure(case, "", (silence,))
        ruling = Ruling(Verdict.GRANTED if success else Verdict.OUT_OF_REACH, 0, name)  # any refusal is equal here
        if differences := compare([ruling], [expected], "success"):
            return Failure(case, "", tuple(differences))
    return None


def _sent(token: str, name: str) -> str:
    """Return the name that is sent to the node, with a token that makes it new: a caught target stays caught (R3.4).

    The ending of a name is kept, and so is its length if that is above _LONG.
    """
    if name == _OWN_NAME:
        return TURTLE
    return token + name[len(token) if len(name) > _LONG else 0 :] if name else name


def _questions(case: ArbiterCase) -> Iterator[_Question]:
    """Yield a case's questions: first those that catch the targets which are caught in it."""
    given = case.arguments()
    for name in given["caught"]:
        alone = {"targets": {name: case.hunters[0]}, "requests": [(0, name)], "caught": []}
        yield given | alone, _granted(name)
    yield given, case.expected[0]


def _fits_own(case: ArbiterCase) -> bool:
    """Return whether a case can be asked with targets whose places and names the node chooses."""
    return fits_a_service(case) and len(case.targets) == 1 and (case.group != "names" or case.id == "names.unknown")


def _questions_of_own(node: NodeUnderTest, case: ArbiterCase) -> Iterator[_Question]:
    """Yield a case's questions about the node's own targets: an answer may change its list before the next question."""
    given, (expected,), (only,) = case.arguments(), case.expected, case.targets
    requested = str(expected.target)
    caught: dict[str, str] = {}
    for name in given["caught"]:
        node.wait_for_target()
        caught[name], place = next(iter(node.listed.items()))
        alone = {"hunters": [_float32(place)], "targets": node.listed, "requests": [(0, caught[name])], "caught": []}
        yield given | alone, _granted(caught[name])
    end = time.monotonic() + _FITS_S
    while time.monotonic() < end:
        node.wait_for_target()
        listed = node.listed
        gone = [name for name in caught.values() if name not in listed]
        for target, place in listed.items():
            name = {**caught, only: target}.get(requested, requested)
            for hunter in _places(case, place):
                position = {"hunters": [hunter], "targets": listed, "requests": [(0, name)], "caught": gone}
                if arbitrate(**given | position)[0].verdict is expected.verdict:
                    yield given | position, replace(expected, target=name)
                    return
    raise BusError(f"the node listed no target that fits the case {case.id} for {_FITS_S:g} s")


def _places(case: ArbiterCase, target: Place) -> Iterator[Place]:
    """Yield places at the case's distance from a target [m]: on the same side, mirrored or turned."""
    (hunter,), (case_target,) = case.hunters, case.targets.values()
    dx, dy = hunter[0] - case_target[0], hunter[1] - case_target[1]
    for along, across in ((dx, dy), (dy, dx)):
        for x, y in itertools.product((along, -along), (across, -across)):
            place = _float32((target[0] + x, target[1] + y))
            if all(0.0 <= number <= TURTLESIM_SIDE_M for number in place):
                yield place


def _granted(name: str) -> ExpectedRuling:
    return ExpectedRuling(hunter=0, target=name, answer=Verdict.GRANTED.name, distance_um=0, winner=0)


def _can_be_sent(name: object) -> bool:
    return isinstance(name, str) and "\0" not in name  # a zero byte ends a string in CDR


def _float32(place: Place) -> Place:
    x, y = (float(np.float32(number)) for number in place)
    return x, y


def _grade(test: GradingTest, report: Report) -> TestGrade:
    """Return a grade; its failures have one line for each set of clauses of failed cases."""
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
