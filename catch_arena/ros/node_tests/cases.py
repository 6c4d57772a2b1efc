"""Cases of the conformance suite that a service by name can be asked, and the run of them on a node."""

import secrets
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from catch_arena.arbitration import arbitrate
from catch_arena.config import TURTLESIM_SIDE_M
from catch_arena.conformance.answers import Difference, DiffersError, UnreadableAnswer, request_in_words
from catch_arena.conformance.cases import DEFAULTS, ArbiterCase, ArenaCase, ExpectedRuling
from catch_arena.conformance.comparison import REFUSED, Call, Strictness, compare
from catch_arena.conformance.report import Report
from catch_arena.conformance.results import Failure, LeftOut, Result
from catch_arena.errors import BusError, MissingServiceError
from catch_arena.ros.middleware.graph_names import TURTLE
from catch_arena.ros.node_tests.node_under_test import ANSWER_S, NodeUnderTest, Place
from catch_arena.verdicts import Ruling, Verdict

_NOT_BY_SERVICE: Final = LeftOut("cannot be asked of a service", "cannot be asked of a service")
_SETTLE_S: Final = 0.15
"""So long a position stands before a node is asked: each of its topics comes some nine times."""
_SETTLE_AGAIN_S: Final = 1.0
"""The second time, for a node that is slow."""
_FITS_S: Final = 30.0
"""So long a target is waited for that is not too near a wall."""
_MOST_SILENT: Final = 3
"""Requests without an answer, one after the other, after which a node is given up."""
_ONES_OWN: Final = "hunter_0"
"""What cases call the hunter."""
_LONG: Final = 200
"""Characters of a name that may be at the limit."""
_STRICTNESS: Final = Strictness(evidence=False, success_only=True)
_WITHOUT_A_TARGETS_NAME: Final = frozenset(
    {
        "names.unknown",
        "names.empty",
        "names.ones-own",
        "names.255-characters",
        "names.255-characters-in-510-bytes",
        "names.256-characters",
    }
)
"""Cases about names that mean the same whatever the targets are called."""


class NodeLostError(BusError):
    """Raised where a node that was asked cases no longer answers.

    Args:
        case: the id of the first that it did not answer.
        why: it was given up.
        before: the report of the cases before that one.
    """

    def __init__(self, case: str, why: BusError, before: Report) -> None:
        super().__init__(f"the node fell silent at {case}: {why}")
        self.before = before


def can_be_asked(case: ArbiterCase | ArenaCase) -> bool:
    """Whether a case can be asked of a service by name: one hunter, one request, nothing out of the ordinary; and where
    the float32 of a Pose does not change the answer.
    """
    if not isinstance(case, ArbiterCase) or len(case.hunters) != 1 or len(case.expected) != 1:
        return False
    usual = {key: value for key, value in case.circumstances.items() if key not in {"caught", "seed", "step"}}
    names = [case.expected[0].target, *case.targets, *case.circumstances["caught"]]
    if any(value != DEFAULTS[key] for key, value in usual.items()) or not all(map(_can_be_sent, names)):
        return False
    if "" in case.targets:  # it would be caught for good, and no other name be fresh
        return False
    arguments = case.arguments() | {"hunters": [_float32(case.hunters[0])]}
    return arbitrate(**arguments)[0].verdict is case.expected[0].verdict


def run_on_node(node: NodeUnderTest, cases: Sequence[ArbiterCase | ArenaCase]) -> Report:
    """Try a node with those of the cases that can be asked of it; the report has the others as not played.

    Raises:
        BusError: where the service is not there.
        NodeLostError: where it no longer answers.
    """
    node.meet()
    run = _RunWithItsList(node) if node.keeps_the_list else _Run(node)
    results: list[Result] = []
    for case in cases:
        try:
            results.append(run.result(case))
        except MissingServiceError:
            raise
        except BusError as error:
            first = run.unanswered[0] if run.unanswered else case.id
            ids = [*(result.case.id for result in results), case.id]
            before = tuple(results[: ids.index(first)])
            raise NodeLostError(first, error, Report(before, _STRICTNESS)) from error
    return Report(tuple(results), _STRICTNESS)


class _Run:
    """Plays cases on a node, each with names that it has not heard before: what is caught once stays caught (R3.4)."""

    def __init__(self, node: NodeUnderTest) -> None:
        self._node = node
        self._id = secrets.token_hex(3)
        self._plays = 0
        self._case = ""
        self._calls: list[Call] = []
        self.unanswered: list[str] = []
        """The ids of the last cases, if they had no answer."""

    def result(self, case: ArbiterCase | ArenaCase) -> Result:
        """What came of a case. A wrong answer counts if it comes twice, the second time after a second's peace."""
        start = time.perf_counter()
        if not isinstance(case, ArbiterCase) or not self._can_play(case):
            return Result(case, None, 0.0, _NOT_BY_SERVICE)
        self._case = case.id
        differences = self._played(case, _SETTLE_S)
        if differences and not any(isinstance(one, UnreadableAnswer) for one in differences):
            differences = self._played(case, _SETTLE_AGAIN_S)
        failure = Failure(case, "", differences) if differences else None
        return Result(case, failure, time.perf_counter() - start, calls=tuple(self._calls))

    def _played(self, case: ArbiterCase, settle_s: float) -> tuple[Difference, ...]:
        self._plays += 1
        self._calls = []
        try:
            self._play(case, settle_s)
        except DiffersError as error:
            return error.differences
        return ()

    # what follows differs for nodes that keep the list

    def _can_play(self, case: ArbiterCase) -> bool:
        return can_be_asked(case)

    def _play(self, case: ArbiterCase, settle_s: float) -> None:
        given = case.arguments()
        for name in given["caught"]:  # it is, now
            alone = given | {"targets": {name: case.hunters[0]}, "requests": [(0, name)], "caught": []}
            self._send_request(alone, _granted(name), settle_s)
        self._send_request(given, case.expected[0], settle_s)

    def _sent(self, name: str) -> str:
        """A name that stands for it in this play; what matters in it stays: its ending, and a length at the limit."""
        if name == _ONES_OWN:
            return TURTLE
        head = f"{self._id}{self._plays}_"
        return head + name[len(head) if len(name) > _LONG else 0 :] if name else name

    def _send_request(self, arguments: Mapping[str, Any], expected: ExpectedRuling, settle_s: float) -> None:
        name = str(expected.target)
        targets = {self._sent(one): place for one, place in arguments["targets"].items()}
        success = self._node.ask(arguments["hunters"][0], targets, self._sent(name), settle_s)
        if success is None:
            self.unanswered.append(self._case)
            if len(self.unanswered) == _MOST_SILENT:
                raise BusError(f"it has not answered {_MOST_SILENT} requests one after the other, and is given up")
            raise DiffersError(
                UnreadableAnswer(
                    request_in_words(1, expected),
                    "an answer",
                    f"none within {ANSWER_S:g} s",
                    "no answer comes",
                    "Every request gets exactly one verdict (R5.2).",
                )
            )
        self.unanswered.clear()
        ruling = Ruling(Verdict.GRANTED if success else REFUSED, 0, name)
        self._calls.append(Call(arguments, (ruling,)))
        compare([ruling], [replace(expected, target=name)], lots=(), refused=(), strictness=_STRICTNESS)


class _RunWithItsList(_Run):
    """On a node that keeps the list: the hunter comes to the node's targets, which are where the node wants them."""

    def _can_play(self, case: ArbiterCase) -> bool:
        (one,) = case.expected if can_be_asked(case) else (None,)
        if one is None or len(case.targets) != 1 or not any(True for _ in _places(case, (5.5, 5.5))):
            return False
        names_mean_nothing = case.group != "names" and (
            one.target in case.targets or one.target in case.circumstances["caught"]
        )
        return names_mean_nothing or case.id in _WITHOUT_A_TARGETS_NAME

    def _play(self, case: ArbiterCase, settle_s: float) -> None:
        given = case.arguments()
        caught: dict[str, str] = {}
        for name in given["caught"]:
            self._node.wait_for_target()
            listed = self._node.listed
            caught[name], place = next(iter(listed.items()))
            hunter = _float32(place)
            alone = given | {"hunters": [hunter], "targets": listed, "requests": [(0, caught[name])], "caught": []}
            self._send_request(alone, _granted(caught[name]), settle_s)
        (expected,) = case.expected
        asked = str(expected.target)
        end = time.monotonic() + _FITS_S
        while time.monotonic() < end:
            self._node.wait_for_target()
            listed = self._node.listed
            for target, place in listed.items():
                stands_for = {**caught, next(iter(case.targets)): target}
                name = stands_for.get(asked, asked)
                for hunter in _places(case, place):
                    arguments = given | {
                        "hunters": [hunter],
                        "targets": listed,
                        "requests": [(0, name)],
                        "caught": [one for one in caught.values() if one not in listed],
                    }
                    if arbitrate(**arguments)[0].verdict is expected.verdict:
                        return self._send_request(arguments, replace(expected, target=name), settle_s)
            self._node.ask_nothing(settle_s)
        raise BusError(f"for {_FITS_S:g} s no target that the node lists was where {case.id} could be asked")

    def _sent(self, name: str) -> str:
        return TURTLE if name == _ONES_OWN else name


def _places(case: ArbiterCase, target: Place) -> Iterator[Place]:
    """Where the hunter may stand so that it is as far from a target as in the case: as there, or mirrored or turned."""
    (hunter,), (there,) = case.hunters, case.targets.values()
    dx, dy = hunter[0] - there[0], hunter[1] - there[1]
    for along, across in ((dx, dy), (dy, dx)):
        for x in (along, -along):
            for y in (across, -across):
                place = _float32((target[0] + x, target[1] + y))
                if all(0.0 <= number <= TURTLESIM_SIDE_M for number in place):
                    yield place


def _granted(name: str) -> ExpectedRuling:
    return ExpectedRuling(hunter=0, target=name, verdict=Verdict.GRANTED, distance_um=0, winner=0)


def _can_be_sent(name: object) -> bool:
    return isinstance(name, str) and "\0" not in name  # where CDR's texts end


def _float32(place: Place) -> Place:
    x, y = (float(np.float32(number)) for number in place)
    return x, y
