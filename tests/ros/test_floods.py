"""Nodes that send far too much, over DDS: what they can cost the arena, and what they cannot take from others."""

import time
from itertools import count
from types import SimpleNamespace

import pytest
from ros import cdr, wire
from ros.processes import own_domain

from catch_arena.core.physics import TICK_MS
from catch_arena.messages import CatchTurtleResponse
from catch_arena.ros.middleware import dds_bus
from catch_arena.ros.middleware.bus import SPIN_S, open_bus
from catch_arena.ros.middleware.interfaces import TWIST, Interfaces
from catch_arena.ros.nodes.arena_node import ArenaNode
from catch_arena.service import ArenaService

TYPES = Interfaces()
FLOOD = 320
"""Messages between two ticks: 20,000 a second."""


@pytest.fixture(scope="module")
def domain():
    with own_domain() as own, pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_LOCALHOST_ONLY", "1")
        yield own


@pytest.fixture
def ours(domain):
    made = open_bus("cyclonedds", domain=domain, log=print)
    yield made
    made.close()


class Student:
    """A node on the wire, which drives one hunter and asks at one service."""

    def __init__(self, domain, hunter, service):
        self.keep = wire.Node(domain)
        self.twists = self.keep.writer(f"rt/{hunter}/cmd_vel", wire.TWIST)
        self.asks, self.answers = self.keep.client(service, wire.catch_turtle())
        self.number = 0

    @property
    def ready(self):
        return self.twists.matched() and self.asks.matched() and self.answers.matched()

    def drive(self, speed=0.0):
        self.twists.write(cdr.twist((speed, 0, 0), (0, 0, 0)))

    def ask(self, name):
        self.number += 1
        self.asks.write(cdr.begin(self.asks.handle, self.number).text(name).whole())

    def told(self):
        """What it was answered, by the number of the request."""
        found = {}
        for data in self.answers.take():
            reader = cdr.Reader(data)
            if reader.number("Q") == self.asks.handle:
                number = reader.number("q")
                found[number] = reader.number("?")
        return found


def wait_for(*conditions):
    end = time.monotonic() + 60
    while not all(condition() for condition in conditions):
        assert time.monotonic() < end
        time.sleep(0.01)


def ready(*nodes):
    wait_for(*(lambda node=node: node.ready for node in nodes))


@pytest.mark.parametrize("services", [("/catch_turtle",) * 2, ("/hunter_0/catch_turtle", "/hunter_1/catch_turtle")])
def test_a_request_is_judged_in_the_next_step_while_another_node_floods(ours, domain, services):
    """R8.4, at the service that all share and at each hunter's own."""
    service = ArenaService(
        "standard",
        hunters=2,
        hunter_poses=((2.0, 2.0, 0.0), (8.0, 8.0, 0.0)),
        control_period_ms=TICK_MS,
        control=("full", "full"),
        initial_targets=0,
        spawn_frequency_hz=0.001,
    )
    node = ArenaNode(ours, service, [0, 1], ["a", "b"], None, TYPES, clock=False, log=print)
    node.begin(1)
    flooding, quiet = (Student(domain, f"hunter_{seat}", services[seat]) for seat in range(2))
    ready(flooding, quiet)
    flooding.drive()
    quiet.drive()
    node.tick()
    for _ in range(10):
        name = service.spawn(8.1, 8.0)
        quiet.ask(name)
        for _ in range(FLOOD):
            flooding.ask(name)
        node.tick()
        assert quiet.told() == {quiet.number: True}
    assert flooding.told()
    assert [hunter.score for hunter in service.world.hunters] == [0, 10]


@pytest.mark.parametrize(("tick_s", "more"), [(0.0, 10), (2 * SPIN_S, 1)], ids=["in time", "late"])
def test_a_second_node_that_floods_a_hunter_does_not_take_it_from_its_driver(ours, domain, monkeypatch, tick_s, more):
    """Each sender's Twists have a queue of their own, and each sender is heard once, however late it is by then."""
    heard, clock = [], count(1.0, tick_s)
    ours.subscribe("/hunter_0/cmd_vel", TWIST, lambda twist, peer: heard.append((twist.linear.x, peer)))
    driver, other = (Student(domain, "hunter_0", "/none") for _ in range(2))
    wait_for(driver.twists.matched, other.twists.matched)
    driver.drive(1.0)
    for _ in range(FLOOD):
        other.drive(2.0)
    monkeypatch.setattr(dds_bus, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    ours.spin()
    assert [speed for speed, _ in heard] == [1.0] + more * [2.0]
    assert len({peer for _, peer in heard}) == 2


def test_a_spin_ends_in_time_and_has_heard_everybody(ours, domain, monkeypatch):
    """The rest of the flood waits, and is heard in the next spins; nobody else waits for it."""
    heard, clock = [], [0.0]

    def slow(word):
        heard.append(word)
        clock.append(clock[-1] + SPIN_S / 3)

    ours.serve("/flooded", TYPES.catch_turtle, lambda request: slow(request.message.name))
    ours.subscribe("/hunter_0/cmd_vel", TWIST, lambda *_: slow("twist"))
    flooding, quiet = (Student(domain, "hunter_0", "/flooded") for _ in range(2))
    ready(flooding, quiet)
    monkeypatch.setattr(dds_bus, "time", SimpleNamespace(monotonic=lambda: clock[-1]))
    for _ in range(16):
        flooding.ask("flood")
    quiet.drive()
    quiet.ask("quiet")
    ours.spin()
    assert sorted(heard[:3]) == ["flood", "quiet", "twist"]
    assert len(heard) < 10
    for _ in range(20):
        if heard.count("flood") < 16:
            ours.spin(1.0)  # does not wait while something is left
    assert heard.count("flood") == 16
    assert len(heard) == 18


def test_answers_that_nobody_hears_do_not_pile_up(ours, domain, monkeypatch):
    """A client that has no reader for them: each answer waits for it a while, and only so many do."""
    ours.serve("/deaf", TYPES.catch_turtle, lambda request: request.answer(CatchTurtleResponse(False)))
    asks = wire.Node(domain).writer("rq/deafRequest", wire.catch_turtle()[0])
    wait_for(asks.matched)
    monkeypatch.setattr(dds_bus, "time", SimpleNamespace(monotonic=lambda: 1.0))
    for _ in range(10):
        for number in range(FLOOD):
            asks.write(cdr.begin(asks.handle, number).text("x").whole())
        ours.spin()
    assert len(ours._late) == 64
