"""R3.8 to R3.10 on the oracle: how targets wander and flee, worked out by hand."""

import math
from random import Random

import pytest
from oracle.arena import OracleArena
from oracle.arithmetic import PI, THREAT_LOT, WANDER, draw, fraction, key, wrap
from oracle.quiet import drive, quiet, rest
from oracle.turtles import Target

MIDDLE = 5.5444445610046385
"""Half of the arena's side, exactly."""


def bearing(target: Target, x: float, y: float) -> float:
    """The C library's bearing error of a direction in the world frame."""
    return math.remainder(math.atan2(y, x) - target.theta, math.tau)


def lone_target(arena: OracleArena, x: float, y: float, theta: float = 0.0) -> Target:
    """The arena's only target, put there; hunters stay."""
    arena.place([(hunter.x, hunter.y, hunter.theta) for hunter in arena.hunters], [(x, y)])
    (target,) = arena.alive
    target.theta = theta
    return target


@pytest.mark.rule("R3.8")
def test_r3_8_a_target_moves_as_a_hunter_with_its_command_does() -> None:
    """Bit for bit: pose and wall flag, along walls too."""
    arena = quiet(target_motion="wander", target_speed_mps=2.0, target_turn_rate_radps=4.0, side_m=3.0)
    target = lone_target(arena, 1.5, 1.5)
    walls = 0
    for _ in range(200):
        twin = quiet(side_m=3.0, hunter_poses=((target.x, target.y, target.theta),))
        twin.time = arena.time
        rest(arena)
        twin.hunters[0].v, twin.hunters[0].w = target.v, target.w
        twin._move()
        for moved in twin.hunters:
            assert (moved.x, moved.y, moved.theta) == (target.x, target.y, target.theta)
            assert moved.at_wall == target.at_wall
        walls += target.at_wall
    assert 0 < walls < 200


@pytest.mark.rule("R3.8")
def test_r3_8_places_are_those_of_still_targets_and_only_theta_is_wrapped() -> None:
    """At reset; half of the thetas as drawn lie beyond pi."""
    still, moving = (quiet(initial_targets=40, max_targets=64, target_motion=motion) for motion in ("still", "flee"))
    assert [(one.x, one.y) for one in still.alive] == [(one.x, one.y) for one in moving.alive]
    assert [wrap(one.theta) for one in still.alive] == [one.theta for one in moving.alive]
    assert any(one.theta > PI for one in still.alive)


@pytest.mark.rule("R3.9")
def test_r3_9_a_turn_rate_is_kept_for_its_period() -> None:
    """Six steps of 100 ms have one, where the period is 600 ms; each is the one that the hash draws."""
    arena = quiet(target_motion="wander", wander_period_ms=600, side_m=500.0, target_turn_rate_radps=2.0, seed=9)
    target = lone_target(arena, 250.0, 250.0)
    drawn = []
    for _ in range(60):
        rest(arena)
        drawn.append(target.w)
    stream = draw(key(9, WANDER), target.number)
    assert drawn[::6] == [(2.0 * fraction(draw(stream, period)) - 1.0) * 2.0 for period in range(10)]
    assert all(drawn[step] == drawn[step - step % 6] for step in range(60))
    assert len(set(drawn)) == 10


@pytest.mark.rule("R3.9")
def test_r3_9_a_period_counts_from_the_targets_own_appearance() -> None:
    """At 40 ms and then every 250 ms: the boundaries that first see a new one are at 300, 600, 800 and 1100 ms."""
    arena = quiet(target_motion="wander", wander_period_ms=250, spawn_frequency_hz=25.0, max_targets=1, side_m=500.0)
    rest(arena)
    (target,) = arena.alive
    stream = draw(key(1, WANDER), 1)
    for period in (0, 0, 1, 1, 1, 2, 2, 3, 3, 3, 4):
        rest(arena)
        assert target.w == (2.0 * fraction(draw(stream, period)) - 1.0) * 3.0


@pytest.mark.rule("R3.9")
def test_r3_9_what_hunters_do_does_not_change_where_a_target_wanders() -> None:
    """Two matches of one seed, with one hunter that rests and with four that drive."""
    one = quiet(target_motion="wander", initial_targets=6)
    other = quiet(target_motion="wander", initial_targets=6, hunters=4, max_speed_mps=9.0)
    for _ in range(150):
        rest(one)
        drive(other, *[(1.0, 0.5)] * 4)
        assert [(it.x, it.y, it.theta) for it in one.alive] == [(it.x, it.y, it.theta) for it in other.alive]


@pytest.mark.rule("R3.9")
@pytest.mark.parametrize(
    ("x", "y", "theta"), [(11.0, 3.0, 0.1), (0.05, 9.0, 3.0), (2.0, 0.01, -1.2), (11.04, 11.04, 0.8)]
)
def test_r3_9_a_target_that_met_a_wall_turns_towards_the_centre(x: float, y: float, theta: float) -> None:
    """The turn rate is six times the C library's bearing error, within its limit; it then leaves the wall."""
    arena = quiet(target_motion="wander", wander_period_ms=10**9)
    target = lone_target(arena, x, y, theta)
    rest(arena)
    assert target.at_wall
    turned = 0
    for _ in range(20):
        flag, expected = target.at_wall, bearing(target, MIDDLE - target.x, MIDDLE - target.y)
        rest(arena)
        if flag:
            assert target.w == pytest.approx(max(-3.0, min(3.0, 6.0 * expected)), abs=1e-12)
            turned += 1
    assert 2 < turned < 20
    assert not target.at_wall
    assert target.v == 1.0


@pytest.mark.rule("R3.10")
def test_r3_10_a_fleeing_target_turns_away() -> None:
    """From whichever side the threat comes: w is six times the C library's bearing error of the way away, limited."""
    for case in range(200):
        source = Random(case)
        arena = quiet(target_motion="flee")
        angle, away = source.uniform(-PI, PI), source.uniform(0.01, 1.99)
        (hunter,) = arena.hunters
        hunter.x, hunter.y = MIDDLE - away * math.cos(angle), MIDDLE - away * math.sin(angle)
        target = lone_target(arena, MIDDLE, MIDDLE, source.uniform(-PI, PI))
        error = bearing(target, math.cos(angle), math.sin(angle))
        rest(arena)
        assert target.w == pytest.approx(max(-3.0, min(3.0, 6.0 * error)), abs=1e-9)
        assert target.v == 1.0
        assert abs(bearing(target, math.cos(angle), math.sin(angle))) <= abs(error)
        rest(arena, 25)
        assert math.dist((target.x, target.y), (hunter.x, hunter.y)) > min(2.0, away + 0.5)


@pytest.mark.rule("R3.10")
def test_r3_10_of_equally_near_threats_one_is_drawn_by_lot() -> None:
    """The lot is the hash's, with the step and the number in it; others who stand farther away do not matter."""
    counts = {True: 0, False: 0}
    for seed in range(200):
        arena = quiet(target_motion="flee", hunters=3, seed=seed)
        rest(arena, seed % 3)
        arena.place([(6.5, 5.5, 0.0), (4.5, 5.5, 0.0), (5.5, 4.4, 0.0)], [(5.5, 5.5)])
        step = arena.steps
        rest(arena)
        lots = draw(draw(key(seed, THREAT_LOT), step), arena.alive[0].number)
        from_ahead = draw(lots, 0) < draw(lots, 1)
        assert (arena.alive[0].w != 0.0) == from_ahead
        counts[from_ahead] += 1
    assert min(counts.values()) > 70


@pytest.mark.rule("R3.10")
@pytest.mark.parametrize(
    ("target_at", "hunter_at", "wanted"),
    [
        ((0.2, 5.5), (1.2, 5.5), (-1.0 + 1.6, 0.0)),
        ((5.5, 0.75), (5.5, 1.75), (0.0, -1.0 + 0.5)),
        ((11.088889122009277 - 0.1, 0.1), (10.0, 0.1), (1.0 - 1.8, 1.8)),
        ((5.5, 11.088889122009277 - 0.5), (4.5, 11.088889122009277 - 0.5), (1.0, -1.0)),
        ((1.0, 5.5), (2.0, 5.5), (-1.0, 0.0)),
        ((1.5, 5.5), (1.5, 4.5), (0.0, 1.0)),
    ],
)
def test_r3_10_a_wall_bends_the_way_inwards(
    target_at: tuple[float, float], hunter_at: tuple[float, float], wanted: tuple[float, float]
) -> None:
    """By twice the depth in its last metre; at a metre's distance and beyond there is none."""
    arena = quiet(target_motion="flee")
    arena.hunters[0].x, arena.hunters[0].y = hunter_at
    target = lone_target(arena, *target_at, 0.4)
    error = bearing(target, *wanted)
    rest(arena)
    assert target.w == pytest.approx(max(-3.0, min(3.0, 6.0 * error)), abs=1e-9)


@pytest.mark.rule("R6.2")
def test_r6_2_progress_is_measured_to_where_the_target_stood() -> None:
    """A hunter at rest makes none, however the target moves; one that drives makes what it drove."""
    for speed in (0.0, 1.0):
        arena = quiet(target_motion="flee", target_speed_mps=5.0, rewards={"progress": 1.0})
        arena.place([(2.0, 5.5, 0.0)], [(3.5, 5.5)])
        drive(arena, (speed, 0.0))
        assert arena.alive[0].x > 3.8
        assert arena.parts[0][4] == pytest.approx(speed * 2.0 * 6 * 0.016)
        assert arena.rewards[0] == arena.parts[0][4]
