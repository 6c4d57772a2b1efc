"""Chapter 2, motion: every clause on every adjudicator, and recordings of turtlesim."""

import csv
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from rulebook.conftest import ArenaFactory

from catch_arena.config import TURTLESIM_SIDE_M, ArenaConfig

CENTRE = TURTLESIM_SIDE_M / 2
TRACES = sorted((Path(__file__).parents[1] / "data").glob("turtlesim_*.csv"))


@pytest.mark.rule("R2.1")
def test_r2_1_the_side_is_turtlesims_unless_the_scenario_says_otherwise(arena: ArenaFactory) -> None:
    """float32(499) / float32(45); a hunter that drives on is stopped there."""
    assert float(np.float32(499) / np.float32(45)) == ArenaConfig().side_m == 11.088889122009277
    for side in (TURTLESIM_SIDE_M, 4.0):
        match = arena(control="velocity", side_m=side, max_speed_mps=30.0)
        match.place(hunters=[(1.0, 2.0, 0.0)])
        for _ in range(5):
            match.step((1.0, 0.0))
        assert match.hunter().x == side
        assert match.hunter().y == 2.0


@pytest.mark.rule("R2.1")
def test_r2_1_turtles_pass_through_each_other(arena: ArenaFactory) -> None:
    """Two hunters meet head on, over a target, and each arrives where the other was."""
    match = arena(control="full", hunters=2, max_speed_mps=2.0, control_period_ms=16)
    match.place(hunters=[(5.0, 5.0, 0.0), (5.96, 5.0, -math.pi)], targets=[(5.48, 5.0)])
    for _ in range(30):
        match.step(((1.0, 0.0), 0), ((1.0, 0.0), 0))
    assert match.hunter(0)[:2] == pytest.approx((5.96, 5.0), abs=1e-9)
    assert match.hunter(1)[:2] == pytest.approx((5.0, 5.0), abs=1e-9)
    assert len(match.alive) == 1


@pytest.mark.rule("R2.2")
def test_r2_2_the_heading_turns_first_then_the_position_moves_along_it(arena: ArenaFactory) -> None:
    """One tick."""
    match = arena(control="velocity", control_period_ms=16, max_speed_mps=2.0, max_turn_rate_radps=10.0)
    match.place(hunters=[(5.0, 5.0, 0.3)])
    match.step((0.5, 0.25))
    theta = 0.3 + 2.5 * 0.016
    assert match.hunter().theta == pytest.approx(theta, abs=1e-15)
    assert match.hunter().x == pytest.approx(5.0 + math.cos(theta) * 1.0 * 0.016, abs=1e-15)
    assert match.hunter().y == pytest.approx(5.0 + math.sin(theta) * 1.0 * 0.016, abs=1e-15)


@pytest.mark.rule("R2.2")
def test_r2_2_the_heading_is_wrapped_at_every_tick(arena: ArenaFactory) -> None:
    """Turning left through pi, and right through it, never leaves [-pi, pi)."""
    match = arena(control="velocity", control_period_ms=16, max_turn_rate_radps=20.0)
    for direction in (1.0, -1.0):
        headings = []
        for _ in range(60):
            match.step((0.0, direction))
            headings.append(match.hunter().theta)
        assert all(-math.pi <= theta < math.pi for theta in headings)
        jumps = [after - before for before, after in pairwise(headings)]
        assert sum(abs(jump) > math.pi for jump in jumps) in {3, 4}  # 60 ticks of 0.32 rad are three turns and a bit


@pytest.mark.rule("R2.2")
def test_r2_2_a_heading_that_is_given_as_pi_is_minus_pi(arena: ArenaFactory) -> None:
    """The interval is half open."""
    match = arena(hunter_poses=[(5.0, 5.0, math.pi)])
    assert match.hunter().theta == -math.pi


@pytest.mark.rule("R2.3")
def test_r2_3_each_coordinate_is_clamped_by_itself(arena: ArenaFactory) -> None:
    """A hunter that meets the wall at an angle slides along it."""
    match = arena(control="velocity", max_speed_mps=10.0)
    match.place(hunters=[(11.0, 5.0, math.pi / 4)])
    match.step((1.0, 0.0))
    assert match.hunter().x == TURTLESIM_SIDE_M
    assert match.hunter().y == pytest.approx(5.0 + 6 * 0.16 * math.sqrt(0.5), abs=1e-9)
    match.place(hunters=[(0.01, 0.01, -3 * math.pi / 4)])
    match.step((1.0, 0.0))
    assert match.hunter()[:2] == (0.0, 0.0)


@pytest.mark.rule("R2.3")
def test_r2_3_the_flag_says_for_the_whole_step_that_the_wall_was_met(arena: ArenaFactory) -> None:
    """The first tick's contact still shows at the end of the step, and the next step begins without it."""
    match = arena(control="velocity", max_speed_mps=2.0, max_turn_rate_radps=40.0)
    match.place(hunters=[(TURTLESIM_SIDE_M - 0.001, 5.0, 0.0)])
    assert match.hunter().at_wall == 0.0
    match.step((1.0, 1.0))  # six ticks of 0.64 rad: after the contact it drives away
    assert match.hunter().x < TURTLESIM_SIDE_M - 0.01
    assert match.hunter().at_wall == 1.0
    match.hold()
    assert match.hunter().at_wall == 0.0


@pytest.mark.rule("R2.3")
def test_r2_3_standing_at_the_wall_is_no_contact(arena: ArenaFactory) -> None:
    """Only a clamp that changes a coordinate sets the flag; driving on against the wall does."""
    match = arena(control="velocity")
    match.place(hunters=[(TURTLESIM_SIDE_M, 0.0, 0.0)])
    match.hold()
    assert match.hunter().at_wall == 0.0
    match.step((1.0, 0.0))
    assert match.hunter().at_wall == 1.0
    assert match.hunter().v == match.config.max_speed_mps


@pytest.mark.rule("R2.4")
@pytest.mark.parametrize(
    ("period_ms", "steps_before", "ticks", "stands"),
    [(1000, 0, 62, False), (1500, 0, 62, True), (1500, 2, 63, True), (1511, 1, 62, True)],
)
def test_r2_4_a_command_holds_in_ticks_that_are_at_most_1_s_later(
    arena: ArenaFactory, period_ms: int, steps_before: int, ticks: int, stands: bool
) -> None:
    """After 3000 ms there is a tick at 4000 ms, which still moves; after 1511 ms one at 2512 ms, which does not."""
    limits = {"max_speed_mps": 1.0, "max_turn_rate_radps": 1.0}
    match = arena(hunters=3, control=("velocity", "velocity", "target"), control_period_ms=period_ms, **limits)
    match.hold(steps_before)
    match.place(hunters=[(2.0, 5.0, 0.0), (2.0, 5.0, 0.0), (2.0, 8.0, 0.0)], targets=[(9.0, 8.0)])
    match.step((1.0, 0.0), (0.0, 1.0), 1)
    driver, turner, hosted = (match.hunter(seat) for seat in range(3))
    assert [driver.x, hosted.x, 2.0 + turner.theta] == pytest.approx([2.0 + ticks * 0.016] * 3, abs=1e-12)
    assert [driver.v, hosted.v, turner.w] == [0.0 if stands else 1.0] * 3


@pytest.mark.rule("R2.5")
@pytest.mark.parametrize("reverse", [False, True])
def test_r2_5_an_action_commands_its_share_of_the_limit(arena: ArenaFactory, reverse: bool) -> None:
    """In float64, from the float32 action; backwards only where the scenario lets hunters."""
    match = arena(control="velocity", reverse=reverse, max_speed_mps=2.5, max_turn_rate_radps=3.5)
    for linear, angular in ((1.0, -1.0), (0.1, 0.3), (0.0, 0.0), (-0.7, 1.0), (-1.0, -0.1)):
        match.place(hunters=[(5.0, 5.0, 0.0)])
        match.step((linear, angular))
        expected = float(np.float32(linear)) * 2.5
        assert match.hunter().v == (expected if reverse else max(expected, 0.0))
        assert match.hunter().w == float(np.float32(angular)) * 3.5


@pytest.mark.rule("R2.5")
def test_r2_5_the_hosted_controller_obeys_the_same_limits(arena: ArenaFactory) -> None:
    """A target far away and to the side asks for more of both."""
    match = arena(max_speed_mps=0.5, max_turn_rate_radps=0.25)
    for y, turn_rate in ((10.0, 0.25), (0.0, -0.25)):
        match.reset(1)
        match.place(hunters=[(1.0, 5.0, 0.0)], targets=[(9.0, y)])
        match.step(1)
        assert match.hunter().v == 0.5
        assert match.hunter().w == turn_rate


@pytest.mark.rule("R2.6")
@pytest.mark.parametrize("hunters", [2, 3, 7, 16])
def test_r2_6_hunters_start_evenly_on_a_circle_and_face_its_centre(arena: ArenaFactory, hunters: int) -> None:
    """The radius is 0.3 of the side if the scenario gives none."""
    match = arena(hunters=hunters)
    bearings = []
    for seat in range(hunters):
        x, y, theta = match.hunter(seat)[:3]
        assert math.hypot(x - CENTRE, y - CENTRE) == pytest.approx(0.3 * TURTLESIM_SIDE_M, abs=1e-12)
        bearing = math.atan2(y - CENTRE, x - CENTRE)
        bearings.append(bearing)
        assert math.cos(theta - bearing) == pytest.approx(-1.0, abs=1e-12)
        assert -math.pi <= theta < math.pi
    for before, after in pairwise(bearings):
        assert (after - before) % math.tau == pytest.approx(math.tau / hunters, abs=1e-12)


@pytest.mark.rule("R2.6")
def test_r2_6_the_figure_is_turned_by_a_random_angle(arena: ArenaFactory) -> None:
    """Seat 0's bearing differs from seed to seed, and fills the circle."""
    bearings = []
    for seed in range(60):
        match = arena(hunters=2, seed=seed)
        bearings.append(math.atan2(match.hunter().y - CENTRE, match.hunter().x - CENTRE))
    assert len(set(bearings)) == 60
    quadrants = [sum(q <= (b % math.tau) / (math.pi / 2) < q + 1 for b in bearings) for q in range(4)]
    assert min(quadrants) >= 5


@pytest.mark.rule("R2.6")
def test_r2_6_a_single_hunter_starts_in_the_centre_with_heading_0(arena: ArenaFactory) -> None:
    """The seed and the radius do not matter, as in turtlesim."""
    for seed in (1, 2):
        assert arena(seed=seed, start_radius_m=2.0).hunter()[:3] == (CENTRE, CENTRE, 0.0)


@pytest.mark.rule("R2.6")
def test_r2_6_the_scenarios_poses_and_radius_are_taken(arena: ArenaFactory) -> None:
    """Poses as they are, with the heading wrapped."""
    match = arena(hunters=2, hunter_poses=[(1.0, 2.0, 0.5), (0.0, 3.25, 4.0)])
    assert match.hunter(0)[:3] == (1.0, 2.0, 0.5)
    assert match.hunter(1)[:2] == (0.0, 3.25)
    assert match.hunter(1).theta == pytest.approx(4.0 - math.tau, abs=1e-15)
    match = arena(hunters=2, start_radius_m=1.25)
    assert math.hypot(match.hunter(1).x - CENTRE, match.hunter(1).y - CENTRE) == pytest.approx(1.25, abs=1e-12)


def trace(path: Path) -> list[list[float]]:
    """A recording of real turtlesim: x, y, theta and the velocities that each tick integrated."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["x", "y", "theta", "linear_velocity", "angular_velocity"]
    return [[float(cell) for cell in row] for row in rows[1:]]


def farthest(recorded: list[list[float]], driven: list[tuple[float, float, float]]) -> tuple[float, float]:
    """The largest differences: in the plane [m], and in heading [rad]."""
    apart = max(math.hypot(x - row[0], y - row[1]) for row, (x, y, _) in zip(recorded, driven, strict=True))
    turned = max(
        abs(math.remainder(theta - row[2], math.tau)) for row, (*_, theta) in zip(recorded, driven, strict=True)
    )
    return apart, turned


@pytest.mark.rule("R10.1")
@pytest.mark.parametrize("path", TRACES, ids=lambda path: path.stem)
def test_r10_1_motion_stays_within_10_micrometres_of_real_turtlesim(arena: ArenaFactory, path: Path) -> None:
    """Steps of one tick, driven with the recorded velocities from the recording's first pose, walls included."""
    recorded = trace(path)
    limit = 16.0  # a power of two: a float32 velocity is its share of it exactly
    match = arena(
        control="velocity",
        control_period_ms=16,
        hunter_poses=[recorded[0][:3]],
        max_speed_mps=limit,
        max_turn_rate_radps=limit,
    )
    driven = [match.hunter()[:3]]
    for row in recorded[1:]:
        match.step((row[3] / limit, row[4] / limit))
        assert (match.hunter().v, match.hunter().w) == (np.float32(row[3]), np.float32(row[4]))
        driven.append(match.hunter()[:3])
    apart, turned = farthest(recorded, driven)
    assert apart < 1e-5
    assert turned < 1e-5
    assert len(recorded) * 0.016 > 40


@pytest.mark.rule("R10.1")
@pytest.mark.parametrize("path", TRACES, ids=lambda path: path.stem)
def test_r10_1_the_tick_alone_stays_within_10_micrometres_of_real_turtlesim(path: Path) -> None:
    """The one that draws what lies between two steps."""
    from catch_arena.core.math import sincos
    from catch_arena.core.physics import DT, next_pose, turned

    recorded = trace(path)
    x, y, theta = recorded[0][:3]
    driven = [(x, y, theta)]
    for row in recorded[1:]:
        x, y, *_ = next_pose(x, y, *sincos(theta), row[3] * DT, *sincos(row[4] * DT), TURTLESIM_SIDE_M)
        theta = turned(theta, row[4] * DT, 1)
        driven.append((x, y, theta))
    apart, turned = farthest(recorded, driven)
    assert apart < 1e-5
    assert turned < 1e-5
