"""R7.4 to R7.6 on the oracle: the limits of a view, its columns and its errors, worked out by hand."""

import math

import pytest
from oracle.arena import OracleArena
from oracle.arithmetic import ERROR, draw, fraction, key, to_float32
from oracle.quiet import drive, quiet, rest

from catch_arena.layout import MovingTargetFeatures, RivalFeatures, SelfFeatures, TargetFeatures

TABLES = SelfFeatures, TargetFeatures, MovingTargetFeatures, RivalFeatures
OWN, TARGET, MOVING_TARGET, RIVAL = (len(table._fields) for table in TABLES)
"""Widths of an observation's parts: names and widths are the table's, all values the oracle's."""


def seen_numbers(arena: OracleArena, seat: int = 0) -> int:
    """Number of targets that the hunter has a rank for."""
    mask = arena.masks()[seat]
    assert mask is not None
    return sum(mask) - 1


def seen_rivals(arena: OracleArena, seat: int = 0) -> int:
    """Number of rivals that stand in the observation of a hunter of an arena with still targets."""
    rivals = arena.observations()[seat][OWN + TARGET * arena.targets_seen :]
    return int(sum(rivals[RivalFeatures._fields.index("present") :: RIVAL]))


@pytest.mark.rule("R7.4")
def test_r7_4_a_moving_target_has_a_heading_and_a_velocity() -> None:
    """Relative to the observer, as the C library has them; ranks without a target are zero."""
    arena = quiet(hunters=2, target_motion="wander", initial_targets=3, max_targets=5, target_speed_mps=0.8)
    for _ in range(20):
        drive(arena, (0.3, 1.0), (0.5, -0.7))
    for hunter, numbers in zip(arena.hunters, arena.observations(), strict=True):
        assert len(numbers) == OWN + 5 * MOVING_TARGET + RIVAL
        rows = [numbers[OWN + MOVING_TARGET * rank :][:MOVING_TARGET] for rank in range(5)]
        assert rows[3:] == [[0.0] * MOVING_TARGET] * 2
        for row in rows[:3]:
            seen = dict(zip(MovingTargetFeatures._fields, row, strict=True))
            forward, left = seen["forward"], seen["left"]
            (target,) = (
                one
                for one in arena.alive
                if math.isclose(
                    math.dist((one.x, one.y), (hunter.x, hunter.y)), math.hypot(forward, left), rel_tol=1e-6
                )
            )
            turn = target.theta - hunter.theta
            heading = (seen["heading_cos"], seen["heading_sin"])
            assert heading == pytest.approx((math.cos(turn), math.sin(turn)), abs=1e-6)
            assert (seen["present"], seen["linear_velocity"]) == (1.0, to_float32(0.8))


@pytest.mark.rule("R7.5")
@pytest.mark.parametrize(("away", "seen"), [(2.499999, 1), (2.4999994, 1), (2.4999996, 0), (2.5, 0), (2.500001, 0)])
def test_r7_5_the_radius_is_measured_in_whole_micrometres(away: float, seen: int) -> None:
    """Targets and rivals strictly within it are seen, all round."""
    for theta in (0.0, 2.0, -3.0):
        arena = quiet(hunters=2, view_radius_m=2.5)
        arena.place([(3.0, 5.0, theta), (3.0 + away, 5.0, 0.0)], [(3.0 + away, 5.0)])
        assert seen_numbers(arena) == seen
        assert seen_rivals(arena) == seen


@pytest.mark.rule("R7.5")
@pytest.mark.parametrize("angle", [10.0, 90.0, 120.0, 180.0, 240.0, 359.0])
def test_r7_5_the_cone_opens_evenly_to_both_sides(angle: float) -> None:
    """A body a millionth of a radian within its edge is seen, and one as far beyond is not."""
    for side in (1.0, -1.0):
        for beyond, seen in ((-1e-6, 1), (1e-6, 0)):
            heading = 0.7
            towards = heading + side * (math.radians(angle / 2) + beyond)
            x, y = 5.0 + 2.0 * math.cos(towards), 5.0 + 2.0 * math.sin(towards)
            arena = quiet(hunters=2, view_angle_deg=angle)
            arena.place([(5.0, 5.0, heading), (x, y, 0.0)], [(x, y)])
            assert seen_numbers(arena) == seen
            assert seen_rivals(arena) == seen


@pytest.mark.rule("R7.5")
def test_r7_5_within_reach_everything_is_seen() -> None:
    """Behind one's back, and beyond the radius: by one's own reach, which is not everybody's."""
    arena = quiet(hunters=2, view_angle_deg=60.0, view_radius_m=0.1, reach_m=(0.5, 0.3))
    for away, far_reaching, usual in ((0.299999, 1, 1), (0.3, 1, 0), (0.499999, 1, 0), (0.5, 0, 0)):
        arena.place([(5.0, 5.0, 0.0), (5.0 - 2 * away, 5.0, 0.0)], [(5.0 - away, 5.0)])
        arena.hunters[1].x = 5.0 - 2 * away
        assert seen_numbers(arena, 0) == far_reaching
        arena.hunters[1].theta = math.pi
        assert seen_numbers(arena, 1) == usual


@pytest.mark.rule("R7.5")
def test_r7_5_room_is_for_what_is_seen() -> None:
    """Two places for targets and one for rivals, and nearer ones behind one's back."""
    arena = quiet(hunters=4, observed_targets=2, observed_hunters=1, view_angle_deg=90.0)
    behind, ahead = [(4.0, 5.0), (4.5, 5.0)], [(7.0, 5.0), (6.5, 5.0), (8.0, 5.0)]
    arena.place([(5.0, 5.0, 0.0), (4.4, 5.0, 0.0), (9.0, 5.0, 0.0), (9.5, 5.0, 0.0)], [*behind, *ahead])
    numbers = arena.observations()[0]
    assert [numbers[OWN], numbers[OWN + TARGET], numbers[OWN + 2 * TARGET]] == [1.5, 2.0, 4.0]


@pytest.mark.rule("R7.5")
def test_r7_5_a_target_out_of_sight_stays_the_active_one() -> None:
    """The hunter drives past: the state has the target's number, and no rank is active."""
    arena = quiet(control="target", view_angle_deg=90.0, gains={"kp_w": 0.0, "ki_v": 1.0})
    arena.place([(5.0, 5.0, 0.7)], [(5.6, 5.0)])
    arena.step([1])
    rest_of_steps = 0
    while seen_numbers(arena):
        arena.step([1])
        rest_of_steps += 1
    assert rest_of_steps < 20
    assert arena.hunters[0].active == arena.alive[0].number
    assert arena.hunters[0].distance_integral > 0.0
    assert arena.observations()[0][OWN : OWN + TARGET] == [0.0] * TARGET


@pytest.mark.rule("R6.2")
def test_r6_2_progress_counts_towards_seen_targets_alone() -> None:
    """The nearest is behind; without any in sight there is none. Beyond the observation's room there may be."""
    for places, progress in (([(4.0, 5.0), (7.0, 5.0)], 0.192), ([(4.0, 5.0)], 0.0)):
        arena = quiet(view_angle_deg=90.0, observed_targets=1)
        arena.place([(5.0, 5.0, 0.0)], places)
        drive(arena, (1.0, 0.0))
        assert arena.parts[0][4] == pytest.approx(progress)


@pytest.mark.rule("R7.6")
def test_r7_6_an_error_is_that_of_its_target_or_seat() -> None:
    """The hash draws it, whatever the rank; kind 1 is a rival by its seat."""
    arena = quiet(hunters=3, view_noise_m=0.05, seed=11)
    arena.place([(2.0, 2.0, 0.0), (6.0, 2.0, 0.0), (4.0, 2.0, 0.0)], [(9.0, 2.0), (5.0, 2.0)])
    rest(arena)

    def error(kind: int, who: int, axis: int) -> float:
        k = draw(draw(draw(draw(draw(key(11, ERROR), 1), 0), kind), who), axis)
        f = [fraction(draw(k, i)) for i in range(4)]
        return 0.05 * 1.7320508075688772 * (f[0] + f[1] + f[2] + f[3] - 2.0)

    numbers = arena.observations()[0]
    near, far = numbers[OWN : OWN + 2], numbers[OWN + TARGET : OWN + TARGET + 2]
    assert near == [to_float32(3.0 + error(0, 2, 0)), to_float32(error(0, 2, 1))]
    assert far == [to_float32(7.0 + error(0, 1, 0)), to_float32(error(0, 1, 1))]
    rivals = numbers[OWN + 8 * TARGET :]
    assert rivals[:2] == [to_float32(2.0 + error(1, 2, 0)), to_float32(error(1, 2, 1))]
    assert rivals[RIVAL : RIVAL + 2] == [to_float32(4.0 + error(1, 1, 0)), to_float32(error(1, 1, 1))]


@pytest.mark.rule("R7.6")
def test_r7_6_order_masks_and_controllers_go_by_the_true_places() -> None:
    """A match under target control with much noise plays as one without."""
    settings = {"hunters": 3, "control": "target", "initial_targets": 10, "view_radius_m": 4.0, "target_motion": "flee"}
    noisy, exact = quiet(**settings, view_noise_m=3.0), quiet(**settings)
    for _ in range(60):
        assert noisy.masks() == exact.masks()
        noisy.step([1, 1, 2])
        exact.step([1, 1, 2])
        assert noisy.digest() == exact.digest()
        assert noisy.rewards == exact.rewards


@pytest.mark.rule("R7.6")
def test_r7_6_of_rivals_that_are_alike_the_lower_seat_comes_first() -> None:
    """Which of them is which shows in their errors alone."""
    arena = quiet(hunters=4, view_noise_m=0.1)
    arena.place([(3.0, 3.0, 0.0), *[(5.0, 5.0, 1.0)] * 3], [])
    alone = []
    for seat in (1, 2, 3):
        arena.hunters[seat].x = 4.9
        alone.append(arena.observations()[0][OWN + 8 * TARGET] + 0.1)
        arena.hunters[seat].x = 5.0
    rivals = arena.observations()[0][OWN + 8 * TARGET :]
    assert rivals[::RIVAL] == pytest.approx(alone, abs=1e-6)
