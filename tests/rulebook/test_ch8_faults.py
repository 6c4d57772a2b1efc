"""Chapter 8, services: messages, the list of alive turtles, and faults drawn from the seed."""

import math

import pytest
from oracle.arithmetic import KILL_DOWN, KILL_REFUSED, PLACE, draw, fraction, key
from rulebook.conftest import ArenaFactory

from catch_arena.arbitration import arbitrate
from catch_arena.config import TURTLESIM_SIDE_M, ArenaConfig
from catch_arena.engine import Engine
from catch_arena.messages import (
    CatchTurtleRequest,
    CatchTurtleResponse,
    Pose,
    Turtle,
    TurtleArray,
    Twist,
)
from catch_arena.verdicts import Verdict
from catch_arena.world import HunterState

STILL = (0.0, 0.0)


@pytest.mark.rule("R8.1")
def test_r8_1_the_messages_have_the_capstones_fields() -> None:
    """In the order of its interface files."""
    assert Turtle._fields == ("name", "x", "y", "theta")
    assert TurtleArray._fields == ("turtles",)
    assert CatchTurtleRequest._fields == ("name",)
    assert CatchTurtleResponse._fields == ("success",)
    assert Pose._fields == ("x", "y", "theta", "linear_velocity", "angular_velocity")
    assert Twist._fields == ("linear_x", "angular_z")


@pytest.mark.rule("R8.1")
def test_r8_1_a_catch_is_asked_for_by_name_and_answered_by_success() -> None:
    """Through the arbiter's public face."""
    for name, success in (("target_turtle_1", True), ("target_turtle_2", False)):
        request = CatchTurtleRequest(name)
        (ruling,) = arbitrate(
            hunters=[(1.0, 1.0)], targets={"target_turtle_1": (1.1, 1.0)}, requests=[(0, request.name)]
        )
        assert CatchTurtleResponse(ruling.success) == (success,)


@pytest.mark.rule("R8.1")
def test_r8_1_a_hunters_pose_is_turtlesims() -> None:
    """The linear velocity has no sign there."""
    hunter = HunterState("hunter_0", 1.0, 2.0, 0.5, -1.5, 0.25, score=3, team=0)
    assert hunter.pose == Pose(1.0, 2.0, 0.5, 1.5, 0.25)


@pytest.mark.rule("R8.1", "R8.2")
def test_r8_1_the_alive_list_is_a_turtle_array() -> None:
    """Names, places and headings as requested at the spawn, which the appendix draws from the seed (A.5, A.6)."""
    engine = Engine(ArenaConfig(hunters=1, initial_targets=3))
    engine.reset([8])
    stream = key(8, PLACE)
    low, high = 0.5, TURTLESIM_SIDE_M - (11.088889122009277 - 10.5)
    expected = []
    for number in (1, 2, 3):
        f_x, f_y, f_theta = (fraction(draw(stream, 3 * (number - 1) + j)) for j in range(3))
        place = (low + f_x * (high - low), low + f_y * (high - low))
        expected.append((f"target_turtle_{number}", *place, math.tau * f_theta))
    assert engine.world(0).alive_turtles == TurtleArray(tuple(Turtle(*turtle) for turtle in expected))


@pytest.mark.rule("R8.2")
def test_r8_2_the_alive_list_keeps_its_spawning_order(arena: ArenaFactory) -> None:
    """A caught one leaves it wherever it stands, the others keep their order, and new ones stand at the end."""
    match = arena(hunters=2, control="full", reach_m=50.0, initial_targets=6, spawn_frequency_hz=2.5, max_targets=6)
    for step in range(40):
        before = match.alive
        match.step((STILL, 2 if step % 3 else 0), (STILL, 3 if step % 2 else 0))
        gone = [found.number for found in match.evidence() if found and found.verdict is Verdict.GRANTED]
        kept = [number for number in before if number not in gone]
        assert match.alive[: len(kept)] == kept
        assert match.alive == sorted(match.alive)
    assert match.used > 12


@pytest.mark.rule("R8.3")
def test_r8_3_the_kill_service_fails_by_the_step(arena: ArenaFactory) -> None:
    """At each step the whole service, as its stream says."""
    match = arena(hunters=2, control="full", faults={"kill_down": 0.5}, seed=12)
    stream = key(12, KILL_DOWN)
    down = [fraction(draw(stream, step)) < 0.5 for step in range(20)]
    assert 0 < sum(down) < 20
    for step in range(20):
        match.reset(12)
        match.hold(step)
        match.place(hunters=[(2.0, 2.0, 0.0), (8.0, 8.0, 0.0)], targets=[(2.0, 2.1), (8.0, 8.1)])
        match.step((STILL, 1), (STILL, 1))
        assert match.verdicts == [Verdict.SERVICE_DOWN if down[step] else Verdict.GRANTED] * 2


@pytest.mark.rule("R8.3")
def test_r8_3_a_kill_is_refused_by_step_and_target(arena: ArenaFactory) -> None:
    """Two targets in one step have a draw each."""
    match = arena(hunters=2, control="full", faults={"kill_refused": 0.5}, seed=13)
    outcomes = set()
    for step in range(20):
        match.reset(13)
        match.hold(step)
        match.place(hunters=[(2.0, 2.0, 0.0), (8.0, 8.0, 0.0)], targets=[(2.0, 2.1), (8.0, 8.1)])
        expected = []
        for number in match.alive:
            refused = fraction(draw(draw(key(13, KILL_REFUSED), step), number)) < 0.5
            expected.append(Verdict.KILL_FAILED if refused else Verdict.GRANTED)
        match.step((STILL, 1), (STILL, 1))
        assert match.verdicts == expected
        outcomes.add(tuple(expected))
    assert len(outcomes) == 4


@pytest.mark.rule("R8.3")
def test_r8_3_initial_targets_are_exempt(arena: ArenaFactory) -> None:
    """Even where every spawn fails."""
    for rates in ({"spawn_down": 1.0}, {"spawn_refused": 1.0}):
        match = arena(initial_targets=4, spawn_frequency_hz=10.0, faults=rates)
        assert match.alive == [1, 2, 3, 4]
        match.hold(5)
        assert match.alive == [1, 2, 3, 4]
