"""Somebody's node that serves catch_turtle, tried with cases of the conformance suite over the bus.

The arena plays the part that the node lives in: it publishes where turtle1 stands and which targets are alive, as
turtlesim and the exercise do, and then asks.
"""

import secrets
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from catch_arena.arbitration import arbitrate
from catch_arena.conformance.answers import Difference, DiffersError, UnreadableAnswer, request_in_words
from catch_arena.conformance.cases import DEFAULTS, ArbiterCase, ArenaCase, ExpectedRuling
from catch_arena.conformance.comparison import REFUSED, Call, Strictness, compare
from catch_arena.conformance.report import Report
from catch_arena.conformance.results import Failure, Result
from catch_arena.errors import BusError
from catch_arena.messages import CatchTurtleRequest, Pose, Turtle, TurtleArray
from catch_arena.ros.bus import Bus
from catch_arena.ros.interfaces import Empty, Interfaces, Name
from catch_arena.verdicts import Ruling, Verdict

TURTLE: Final = "turtle1"
"""The hunter, as the exercise knows it."""
_TICK_S: Final = 0.016
_SETTLE_S: Final = 0.15
"""So long a position stands before a node is asked: each of its topics comes some nine times."""
_SETTLE_AGAIN_S: Final = 1.0
"""The second time, for a node that is slow."""
_ANSWER_S: Final = 2.0
_THERE_S: Final = 10.0
"""So long a node may take to appear."""
_MOST_SILENT: Final = 3
"""Requests without an answer, one after the other, after which a node is given up."""
_ONES_OWN: Final = "hunter_0"
"""What cases call the hunter."""
_LONG: Final = 200
_STRICTNESS: Final = Strictness(evidence=False, success_only=True)

Place = tuple[float, float]


class NodeUnderTest:
    """A service on a bus, and the arena about it.

    Args:
        bus: the bus.
        service: its name, as in /catch_turtle.
        interfaces: the packages of the types.
    """

    def __init__(self, bus: Bus, service: str, interfaces: Interfaces) -> None:
        self._bus, self._service = bus, service
        self._pose = bus.publisher(f"/{TURTLE}/pose", interfaces.pose)
        self._alive = bus.publisher("/alive_turtles", interfaces.turtle_array)
        bus.serve("/kill", interfaces.kill, lambda request: request.answer(Empty()))
        bus.serve("/spawn", interfaces.spawn, lambda request: request.answer(Name(request.message.name)))
        self._client = bus.client(service, interfaces.catch_turtle)
        self._said: tuple[Pose, TurtleArray] = (Pose(0.0, 0.0, 0.0, 0.0, 0.0), TurtleArray(()))

    def run(self, cases: Sequence[ArbiterCase | ArenaCase]) -> Report:
        """Try it with those of the cases that can be asked of it; the report has the others as not played.

        Raises:
            BusError: where the service is not there, or no longer answers.
        """
        self._wait()
        return Report(tuple(_NodeRunner(self).run(cases)), _STRICTNESS)

    def _wait(self) -> None:
        """Until the service is there.

        Raises:
            BusError: where nobody serves it, or somebody who cannot answer over this bus.
        """
        end = time.monotonic() + _THERE_S
        while not self._client.ready:
            if time.monotonic() > end:
                raise BusError(f"nobody serves {self._service} on this bus: does the node run, in the same domain?")
            self._bus.spin(0.05)

    def ask(self, hunter: Place, targets: Mapping[str, Place], name: str, settle_s: float) -> bool | None:
        """Stand there among these targets for a while, and ask for one: the answer, None without one in time."""
        turtles = tuple(Turtle(target, x, y, 0.0) for target, (x, y) in targets.items())
        self._said = Pose(*hunter, 0.0, 0.0, 0.0), TurtleArray(turtles)
        self._tell(settle_s)
        call = self._client.call(CatchTurtleRequest(name))
        end = time.monotonic() + _ANSWER_S
        while call.response is None and time.monotonic() < end:
            self._tell(_TICK_S)
        return None if call.response is None else bool(call.response.success)

    def _tell(self, seconds: float) -> None:
        """Poses and the list, tick by tick, as turtlesim tells them."""
        end = time.monotonic() + seconds
        while (now := time.monotonic()) < end:
            self._pose(self._said[0])
            self._alive(self._said[1])
            tick = min(now + _TICK_S, end)
            while (left := tick - time.monotonic()) > 0.0:
                self._bus.spin(left)


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


class _NodeRunner:
    """Plays cases on a node, each with names that it has not heard before: what is caught once stays caught (R3.4)."""

    def __init__(self, node: NodeUnderTest) -> None:
        self._node = node
        self._run = secrets.token_hex(3)
        self._plays = 0
        self._silent = 0
        self._calls: list[Call] = []

    def run(self, cases: Sequence[ArbiterCase | ArenaCase]) -> list[Result]:
        return [
            self._result(case)
            if isinstance(case, ArbiterCase) and can_be_asked(case)
            else Result(case, None, 0.0, played=False)
            for case in cases
        ]

    def _result(self, case: ArbiterCase) -> Result:
        start = time.perf_counter()
        differences = self._play(case, _SETTLE_S)
        if differences and not any(isinstance(one, UnreadableAnswer) for one in differences):
            differences = self._play(case, _SETTLE_AGAIN_S)
        failure = Failure(case, "", differences) if differences else None
        return Result(case, failure, time.perf_counter() - start, calls=tuple(self._calls))

    def _play(self, case: ArbiterCase, settle_s: float) -> tuple[Difference, ...]:
        self._plays += 1
        self._calls = []
        given = case.arguments()
        (place,) = case.hunters
        try:
            for name in given["caught"]:  # it is, now
                first = {**given, "targets": {name: place}, "requests": [(0, name)], "caught": []}
                self._ask(
                    first,
                    ExpectedRuling(hunter=0, target=name, verdict=Verdict.GRANTED, distance_um=0, winner=0),
                    settle_s,
                )
            self._ask(given, case.expected[0], settle_s)
        except DiffersError as error:
            return error.differences
        return ()

    def _ask(self, arguments: Mapping[str, Any], expected: ExpectedRuling, settle_s: float) -> None:
        targets = {self._fresh(name): place for name, place in arguments["targets"].items()}
        name = str(expected.target)
        success = self._node.ask(arguments["hunters"][0], targets, self._fresh(name), settle_s)
        if success is None:
            self._silent += 1
            if self._silent == _MOST_SILENT:
                raise BusError(f"the node has not answered {_MOST_SILENT} requests one after the other: it is given up")
            raise DiffersError(
                UnreadableAnswer(
                    request_in_words(1, expected),
                    "an answer",
                    f"none within {_ANSWER_S:g} s",
                    "no answer comes",
                    "Every request gets exactly one verdict (R5.2).",
                )
            )
        self._silent = 0
        ruling = Ruling(Verdict.GRANTED if success else REFUSED, 0, name)
        self._calls.append(Call(arguments, (ruling,)))
        compare([ruling], [replace(expected, target=name)], lots=(), refused=(), strictness=_STRICTNESS)

    def _fresh(self, name: str) -> str:
        """A name that stands for it in this play; what matters in it stays: its ending, and a length at the limit."""
        if name == _ONES_OWN:
            return TURTLE
        if not name:
            return name
        head = f"{self._run}{self._plays}_"
        return head + name[len(head) if len(name) > _LONG else 0 :]


def _can_be_sent(name: object) -> bool:
    return isinstance(name, str) and "\0" not in name  # where CDR's texts end


def _float32(place: Place) -> Place:
    x, y = (float(np.float32(number)) for number in place)
    return x, y
