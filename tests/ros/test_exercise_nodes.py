"""Our spawner and our controller play the exercise with a simulated turtlesim, all in one process."""

import weakref

import pytest
from ros.local import Hub
from ros.turtlesim import TYPES, Turtlesim

from catch_arena.messages import CatchTurtleRequest, CatchTurtleResponse, Pose, Turtle, TurtleArray
from catch_arena.ros.nodes import controller
from catch_arena.ros.nodes.controller import Controller
from catch_arena.ros.nodes.spawner import Spawner
from catch_arena.scenarios import scenario
from catch_arena.tournament.players import Players, enter

A_SECOND = 63
"""Ticks of 16 ms."""


@pytest.fixture
def hub():
    return Hub()


@pytest.fixture
def turtlesim(hub):
    return Turtlesim(hub.bus("turtlesim"))


class Node:
    """The spawner, a target a second; what it says, and the list that it publishes."""

    def __init__(self, hub, turtlesim):
        self.hub, self.turtlesim, self.log_lines = hub, turtlesim, []
        config = scenario("capstone").replace(spawn_frequency_hz=1.0, name_prefix="t_")
        self.bus = hub.bus("ours")
        self.spawner = Spawner(self.bus, ("turtle1",), TYPES, config, seed=1, log=self.log_lines.append)

    def play(self, ticks):
        for _ in range(ticks):
            self.spawner.tick()
            self.turtlesim.tick()
            self.bus.spin()

    @property
    def listed(self):
        return [turtle.name for turtle in self.hub.sent["/alive_turtles"][-1].turtles]

    def catch(self, name):
        """The answer to turtle1, which asks for a target."""
        call = self.hub.bus("student").client("/catch_turtle", TYPES.catch_turtle).call(CatchTurtleRequest(name))
        self.bus.spin()
        self.play(1)
        return call.result(0).success


@pytest.fixture
def node(hub, turtlesim):
    return Node(hub, turtlesim)


def test_a_target_appears_every_second_and_leaves_the_list_when_it_is_caught(node, turtlesim):
    """62 ticks of 16 ms are a second. What was caught is removed from turtlesim, and cannot be caught again."""
    node.play(61)
    assert turtlesim.requested == []
    node.play(2 * A_SECOND + 3)
    assert (turtlesim.requested, node.listed) == (["t_1", "t_2", "t_3"], ["t_1", "t_2", "t_3"])
    turtlesim.there["turtle1"] = turtlesim.there["t_2"]
    node.play(1)
    assert not node.catch("t_1")
    assert node.catch("t_2")
    node.play(2)
    assert not node.catch("t_2")
    assert node.listed == ["t_1", "t_3"]
    assert "t_2" not in turtlesim.there


def test_names_that_are_taken_are_passed_over_at_once_and_told_once(node, turtlesim):
    turtlesim.there |= {f"t_{number}": Pose(1.0, 1.0, 0.0, 0.0, 0.0) for number in range(1, 23)}
    node.play(2 * A_SECOND + 30)
    assert node.listed == ["t_23", "t_24"]
    (line,) = node.log_lines
    assert line.startswith("warning: t_1 is not spawned, because turtlesim has a turtle of that name")


@pytest.fixture
def drives(hub):
    """Makes turtle2's controller, with a target within its reach; what it says, and one control period."""
    with Players(enter(["nearest"], None), None) as players:

        def make(**options):
            log_lines, ours, others = [], hub.bus("ours"), hub.bus("others")
            node = Controller(ours, players, scenario("capstone"), "turtle2", TYPES, log=log_lines.append, **options)
            others.publisher("/alive_turtles", TYPES.turtle_array)(TurtleArray((Turtle("tom", 5.1, 5.0, 0.0),)))
            pose = others.publisher("/turtle2/pose", TYPES.pose)

            def period():
                pose(Pose(5.0, 5.0, 0.0, 0.0, 0.0))
                ours.spin()
                node.tick()
                others.spin()
                node.tick()

            return log_lines, period

        yield make


def serve(hub, service, name):
    requests = []
    hub.bus(name).serve(
        service, TYPES.catch_turtle, lambda request: requests.append(request.answer(CatchTurtleResponse(True)))
    )
    return requests


@pytest.mark.parametrize(
    ("services", "options", "expected"),
    [
        (["/catch_turtle"], {}, "/catch_turtle"),
        (["/catch_turtle", "/turtle2/catch_turtle"], {}, "/turtle2/catch_turtle"),
        (["/catch_turtle", "/turtle2/catch_turtle"], {"service": "/catch_turtle"}, "/catch_turtle"),
        (["/referee/catch"], {"service": "/referee/catch"}, "/referee/catch"),
    ],
)
def test_a_controller_asks_its_own_service_where_there_is_one(hub, drives, services, options, expected):
    calls = {service: serve(hub, service, "others") for service in services}
    log_lines, period = drives(**options)
    period()
    for bus, _ in hub.served.values():
        bus.spin()
    assert [service for service in services if calls[service]] == [expected]
    assert not any("no node serves" in line for line in log_lines)


def test_a_request_without_an_answer_is_repeated_after_a_second_and_then_forgotten(hub, drives, monkeypatch):
    now = 100.0
    monkeypatch.setattr(controller.time, "monotonic", lambda: now)
    calls = []
    referee = hub.bus("referee")
    referee.serve(
        "/catch_turtle", TYPES.catch_turtle, lambda request: calls.append(weakref.ref(request.answer.__self__))
    )
    _, period = drives()
    for expected in (1, 1, 2):
        now += 0.6
        period()
        referee.spin()
        assert len(calls) == expected
    hub.bus("spawner").publisher("/alive_turtles", TYPES.turtle_array)(TurtleArray(()))
    now += 1.2
    period()
    assert [call() for call in calls] == [None, None]


def test_where_nobody_judges_a_controller_says_so_once(drives):
    log_lines, period = drives()
    for _ in range(3):
        period()
    assert [line for line in log_lines if "no node serves" in line] == [
        "warning: tom is within reach, but no node serves /turtle2/catch_turtle or /catch_turtle"
    ]
