"""Chapter 9, the capstone profile: every clause on every adjudicator."""

import math

import pytest
from rulebook.conftest import Arbiter, ArenaFactory

from catch_arena.config import TURTLESIM_SIDE_M, Gains
from catch_arena.scenarios import scenario
from catch_arena.verdicts import Verdict

STILL = (0.0, 0.0)


@pytest.mark.rule("R9.1")
def test_r9_1_the_scenario_has_the_originals_numbers() -> None:
    """One hunter, a target every two seconds, none at the start, and room to see the oldest."""
    capstone = scenario("capstone")
    assert capstone.hunters == 1
    assert capstone.policy == "capstone"
    assert capstone.spawn_frequency_hz == 0.5
    assert capstone.spawn_period_ms == 2000
    assert capstone.initial_targets == 0
    assert capstone.observed_targets == capstone.max_targets == 64
    assert capstone.gains == Gains(kp_v=2.0, ki_v=0.0, kp_w=6.0, ki_w=0.0)
    assert capstone.max_speed_mps == pytest.approx(2 * TURTLESIM_SIDE_M * math.sqrt(2))
    assert capstone.max_turn_rate_radps == pytest.approx(6 * math.pi)
    assert capstone.side_m == TURTLESIM_SIDE_M
    assert capstone.control_period_ms == 100
    assert scenario("capstone", hunters=3).hunters == 3


@pytest.mark.rule("R9.1")
def test_r9_1_by_name_every_request_that_finds_the_service_up_succeeds(arbiter: Arbiter) -> None:
    """An unknown, a far and an already caught target, a second request, and two hunters for one turtle."""
    rulings = arbiter(
        hunters=[(1.0, 1.0), (9.0, 9.0)],
        targets={"a": (1.0, 1.0)},
        requests=[(0, "a"), (1, "a"), (0, "nobody"), (1, "gone"), (0, "a")],
        caught=["gone"],
        kill_refused=["a"],
        policy="capstone",
    )
    assert {ruling.verdict for ruling in rulings} == {Verdict.GRANTED}
    assert [ruling.distance_um for ruling in rulings] == [None] * 5
    assert [ruling.winner for ruling in rulings] == [0, 1, 0, 1, 0]


@pytest.mark.rule("R9.1")
def test_r9_1_two_hunters_can_both_be_told_success_for_one_turtle(arena: ArenaFactory) -> None:
    """The score counts both grants; the turtle leaves once, so R5.8 does not hold."""
    match = arena(hunters=2, control="full", policy="capstone", rewards={"rival_catch": -1.0})
    match.place(hunters=[(5.0, 5.0, 0.0), (9.0, 9.0, 0.0)], targets=[(5.1, 5.0), (1.0, 1.0)])
    match.step((STILL, 1), (STILL, 1))
    assert match.evidence() == [(Verdict.GRANTED, 1, None, 0), (Verdict.GRANTED, 1, None, 1)]
    assert match.scores == [1, 1]
    assert match.alive == [2]
    assert sum(match.scores) + len(match.alive) > match.spawned
    assert match.rewards == [0.0, 0.0]
    assert [part[:2] for part in match.parts] == [(1.0, 1.0)] * 2


@pytest.mark.rule("R9.1")
def test_r9_1_a_kill_that_the_simulator_refuses_is_a_success_too(arena: ArenaFactory) -> None:
    """The grant counts; the turtle stays, since nobody has removed it."""
    match = arena(control="full", policy="capstone", faults={"kill_refused": 1.0})
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(5.1, 5.0)])
    for catches in (1, 2):
        match.step((STILL, 1))
        assert match.evidence() == [(Verdict.GRANTED, 1, None, 0)]
        assert match.scores == [catches]
        assert match.alive == [1]


@pytest.mark.rule("R9.1")
def test_r9_1_a_far_target_is_caught_too(arena: ArenaFactory) -> None:
    """Under full control; the hosted controller still asks only within reach."""
    match = arena(hunters=2, control=("full", "target"), policy="capstone")
    match.place(hunters=[(1.0, 1.0, 0.0), (2.0, 2.0, 0.0)], targets=[(10.0, 10.0)])
    match.step((STILL, 0), 1)
    assert match.verdicts == [None, None]
    match.step((STILL, 1), 0)
    assert match.verdicts == [Verdict.GRANTED, None]
    assert match.alive == []


@pytest.mark.rule("R9.1")
def test_r9_1_the_arena_too_keeps_the_tests_that_come_before(arena: ArenaFactory) -> None:
    """A rank without a target, a withdrawn hunter, and the service down."""
    match = arena(hunters=2, control="full", policy="capstone")
    match.place(hunters=[(1.0, 1.0, 0.0), (2.0, 2.0, 0.0)], targets=[(2.0, 2.0)])
    match.withdraw(1)
    match.step((STILL, 2), (STILL, 1))
    assert match.verdicts == [Verdict.MALFORMED, Verdict.HUNTER_INACTIVE]
    match = arena(control="full", policy="capstone", faults={"kill_down": 1.0})
    match.place(hunters=[(1.0, 1.0, 0.0)], targets=[(1.0, 1.0)])
    match.step((STILL, 1))
    assert match.verdicts == [Verdict.SERVICE_DOWN]
    assert match.alive == [1]
