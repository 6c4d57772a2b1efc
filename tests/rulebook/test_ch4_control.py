"""Chapter 4, control: every clause on every adjudicator."""

import math

import pytest
from rulebook.conftest import ArenaFactory

from catch_arena.verdicts import Verdict

P = 0.1
"""The control period [s]."""
HIGH = {"max_speed_mps": 500.0, "max_turn_rate_radps": 500.0}
"""Limits that no controller of these tests reaches."""


@pytest.mark.rule("R4.1")
def test_r4_1_a_hunter_names_a_target_by_its_rank(arena: ArenaFactory) -> None:
    """1 is the nearest; it drives to the one that it named."""
    match = arena()
    for rank, number, heading in ((1, 2, 0.0), (2, 3, math.pi / 2), (3, 1, -math.pi / 2)):
        match.reset(1)
        match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(5.0, 2.0), (6.0, 5.0), (5.0, 7.0)])
        match.step(rank)
        assert match.hunter().active == number
        assert match.hunter().w == pytest.approx(max(-4.0, min(4.0, 6.0 * heading)), abs=1e-12)


@pytest.mark.rule("R4.1")
def test_r4_1_the_controller_drives_there_and_requests_within_reach(arena: ArenaFactory) -> None:
    """No request before S_t shows the target within reach, and then one at once."""
    match = arena()
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(7.0, 6.0)])
    for _ in range(60):
        x, y = match.hunter()[:2]
        within = math.hypot(7.0 - x, 6.0 - y) < 0.3
        match.step(1)
        assert match.verdicts == [Verdict.GRANTED if within else None]
        if within:
            break
    assert match.scores == [1]
    assert match.alive == []


@pytest.mark.rule("R4.1")
def test_r4_1_hold_means_no_velocity_and_no_request(arena: ArenaFactory) -> None:
    """Not even for a target that is within reach."""
    match = arena()
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(6.0, 5.0)])
    match.step(1)
    assert match.hunter().v > 0
    assert match.hunter().active == 1
    match.step(0)
    assert (match.hunter().v, match.hunter().w, match.hunter().active) == (0.0, 0.0, 0.0)
    match.reset(1)
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(5.01, 5.0)])
    match.step(0)
    assert match.verdicts == [None]
    assert (match.hunter().v, match.hunter().w, match.hunter().active) == (0.0, 0.0, 0.0)
    assert len(match.alive) == 1


@pytest.mark.rule("R4.1")
def test_r4_1_the_target_named_is_active_until_another_is_named(arena: ArenaFactory) -> None:
    """The number counts, not the rank; the view shows which one is active."""
    match = arena(observed_targets=2)
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(6.5, 5.0), (3.4, 5.0)])
    match.step(2)
    assert match.hunter().active == 2
    assert [target["active"] for target in match.seen_targets()] == [0.0, 1.0]
    match.step(1)
    assert match.hunter().active == 1
    assert [target["active"] for target in match.seen_targets()] == [1.0, 0.0]


@pytest.mark.rule("R4.1")
def test_r4_1_only_a_target_in_view_can_be_named(arena: ArenaFactory) -> None:
    """The third nearest of three is beyond a view of two: rank 2 is the second, and the mask has no third."""
    match = arena(observed_targets=2)
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(9.0, 5.0), (6.0, 5.0), (7.0, 5.0)])
    match.look()
    assert match.mask(0) == [1, 1, 1]
    match.step(2)
    assert match.hunter().active == 3


@pytest.mark.rule("R4.2")
@pytest.mark.parametrize(
    ("theta", "target", "bearing"),
    [
        (0.0, (6.0, 5.0), 0.0),
        (0.0, (6.0, 6.0), math.pi / 4),
        (3.0, (5.0, 4.0), 3 * math.pi / 2 - 3.0),
        (-3.0, (5.0, 6.0), -3 * math.pi / 2 + 3.0),
        (0.0, (4.0, 5.0), -math.pi),  # straight behind: the interval is half open
    ],
)
def test_r4_2_range_is_euclidean_and_the_bearing_error_is_wrapped(
    arena: ArenaFactory, theta: float, target: tuple[float, float], bearing: float
) -> None:
    """Read from the commands of proportional gains."""
    match = arena(gains={"ki_v": 0.0}, **HIGH)
    match.place(hunters=[(5.0, 5.0, theta)], targets=[target])
    match.step(1)
    assert match.hunter().v == pytest.approx(2.0 * math.hypot(target[0] - 5.0, target[1] - 5.0), abs=1e-12)
    assert match.hunter().w == pytest.approx(6.0 * bearing, abs=1e-12)


@pytest.mark.rule("R4.3")
def test_r4_3_both_controllers_are_proportional_and_integral(arena: ArenaFactory) -> None:
    """Three steps by hand: each integral first grows by its error times the period."""
    gains = {"kp_v": 1.5, "ki_v": 0.75, "kp_w": 2.5, "ki_w": 1.25}
    match = arena(gains=gains, **HIGH)
    match.place(hunters=[(2.0, 2.0, 0.2)], targets=[(7.0, 8.0)])
    range_sum = bearing_sum = 0.0
    for _ in range(3):
        x, y, theta = match.hunter()[:3]
        d = math.hypot(7.0 - x, 8.0 - y)
        e = math.remainder(math.atan2(8.0 - y, 7.0 - x) - theta, math.tau)
        range_sum += d * P
        bearing_sum += e * P
        match.step(1)
        assert match.hunter().distance_integral == pytest.approx(range_sum, abs=1e-12)
        assert match.hunter().bearing_integral == pytest.approx(bearing_sum, abs=1e-12)
        assert match.hunter().v == pytest.approx(1.5 * d + 0.75 * range_sum, abs=1e-12)
        assert match.hunter().w == pytest.approx(2.5 * e + 1.25 * bearing_sum, abs=1e-12)


@pytest.mark.rule("R4.3")
def test_r4_3_the_integrals_rest_while_the_output_is_at_its_limit(arena: ArenaFactory) -> None:
    """Anti-windup: the growth shows in the output, and is taken back for the next step."""
    match = arena(gains={"kp_v": 1.0, "ki_v": 1.0, "kp_w": 0.0, "ki_w": 1.0}, max_speed_mps=4.05)
    match.place(hunters=[(2.0, 5.0, 0.0)], targets=[(6.0, 5.0)])
    match.step(1)  # 4 + 0.4 exceeds 4.05, though 4 alone does not
    assert match.hunter().v == 4.05
    assert match.hunter().distance_integral == 0.0
    x = match.hunter().x
    match.step(1)
    assert match.hunter().distance_integral == pytest.approx((6.0 - x) * P, abs=1e-12)


@pytest.mark.rule("R4.3")
def test_r4_3_an_output_that_just_reaches_its_limit_does_not_exceed_it(arena: ArenaFactory) -> None:
    """So the integrals grow: two metres ahead at a gain of 1 and a limit of 2, and pi behind likewise."""
    match = arena(gains={"kp_v": 1.0, "ki_v": 0.0, "kp_w": 1.0, "ki_w": 0.0}, max_turn_rate_radps=math.pi)
    match.place(hunters=[(7.0, 5.0, 0.0)], targets=[(5.0, 5.0)])
    match.step(1)
    assert (match.hunter().v, match.hunter().w) == (match.config.max_speed_mps, -math.pi)
    assert match.hunter().distance_integral == 2.0 * P
    assert match.hunter().bearing_integral == -math.pi * P


@pytest.mark.rule("R4.3")
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_r4_3_anti_windup_works_to_either_side(arena: ArenaFactory, side: float) -> None:
    """A turn that overshoots: the integral rests while the output is at a limit, and goes on below it."""
    match = arena(
        gains={"kp_v": 0.0, "ki_v": 0.0, "kp_w": 0.0, "ki_w": 100.0}, max_turn_rate_radps=3.0, control_period_ms=160
    )
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(6.0, 5.0 + 0.5 * side)])
    wound = 0.0
    rests = 0
    for _ in range(8):
        bearing = math.remainder(side * math.atan2(0.5, 1.0) - match.hunter().theta, math.tau)
        grown = wound + bearing * 0.160
        frozen = (100.0 * grown > 3.0 and bearing > 0) or (100.0 * grown < -3.0 and bearing < 0)
        rests += frozen
        wound = wound if frozen else grown
        match.step(1)
        assert match.hunter().bearing_integral == pytest.approx(wound, abs=1e-9)
        assert match.hunter().w == pytest.approx(max(-3.0, min(3.0, 100.0 * grown)), abs=1e-7)
    assert 0 < rests < 8


@pytest.mark.rule("R4.3")
def test_r4_3_integrals_start_again_when_the_active_target_changes_and_on_hold(arena: ArenaFactory) -> None:
    """By number: the same rank can be another target."""
    match = arena(gains={"ki_w": 1.0}, **HIGH)
    match.place(hunters=[(2.0, 5.0, 0.0)], targets=[(2.0, 7.0), (2.0, 2.0)])
    match.step(1)
    match.step(1)
    assert match.hunter().active == 1
    assert match.hunter().distance_integral > 0.3
    assert match.hunter().bearing_integral > 0.1
    x, y = match.hunter()[:2]
    match.step(2)
    assert match.hunter().active == 2
    assert match.hunter().distance_integral == pytest.approx(math.hypot(2.0 - x, 2.0 - y) * P, abs=1e-12)
    assert match.hunter().bearing_integral < 0
    match.step(0)
    assert (match.hunter().distance_integral, match.hunter().bearing_integral) == (0.0, 0.0)


@pytest.mark.rule("R4.4")
def test_r4_4_under_velocity_control_the_nearest_target_is_requested_within_reach(arena: ArenaFactory) -> None:
    """Only the nearest, only within reach, and of two equally near the one with the lower number."""
    match = arena(control="velocity")
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(5.31, 5.0), (5.0, 5.4)])
    match.step((0.0, 0.0))
    assert match.verdicts == [None]
    match.reset(1)
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(5.0, 5.29), (5.0, 4.75), (5.25, 5.0)])
    match.step((0.0, 0.0))
    assert match.evidence()[0] == (Verdict.GRANTED, 2, 250_000, 0)
    assert match.alive == [1, 3]
    assert match.hunter().active == 0.0
    assert match.hunter().distance_integral == match.hunter().bearing_integral == 0.0


@pytest.mark.rule("R4.4")
def test_r4_4_under_full_control_the_hunter_chooses_what_it_requests(arena: ArenaFactory) -> None:
    """By rank, also out of reach; the target requested is the active one for that step."""
    match = arena(control="full")
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(5.1, 5.0), (5.2, 5.0), (8.0, 5.0)])
    match.step(((0.0, 0.0), 2))
    assert match.evidence()[0] == (Verdict.GRANTED, 2, 200_000, 0)
    assert match.hunter().active == 2.0
    match.step(((0.0, 0.0), 2))
    assert match.evidence()[0] == (Verdict.OUT_OF_REACH, 3, 3_000_000, None)
    assert match.hunter().active == 3.0
    match.step(((0.5, 0.25), 0))
    assert match.verdicts == [None]
    assert match.hunter().active == 0.0
    assert (match.hunter().v, match.hunter().w) == (1.0, 1.0)
    assert match.hunter().distance_integral == match.hunter().bearing_integral == 0.0


@pytest.mark.rule("R4.4")
def test_r4_4_seats_may_differ_in_their_control(arena: ArenaFactory) -> None:
    """One of each in one arena."""
    match = arena(hunters=3, control=("velocity", "target", "full"))
    match.place(
        hunters=[(2.0, 2.0, 0.0), (5.0, 5.0, 0.0), (8.0, 8.0, 0.0)], targets=[(2.1, 2.0), (5.0, 5.1), (8.0, 8.1)]
    )
    match.step((1.0, 0.0), 1, ((-1.0, 0.0), 1))
    assert match.verdicts == [Verdict.GRANTED] * 3
    assert [match.hunter(seat).v > 0 for seat in range(3)] == [True, True, False]
    assert match.hunter(1).w == 4.0
    assert [match.hunter(seat).active for seat in range(3)] == [0.0, 2.0, 3.0]
