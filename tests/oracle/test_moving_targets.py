"""R3.8 to R3.10 on the oracle: what must hold of targets that move, whatever the numbers are."""

import math
from random import Random

import pytest
from oracle.arbiter import GRANTED
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
@pytest.mark.parametrize("motion", ["wander", "flee"])
def test_r3_8_a_moving_target_keeps_within_the_walls_and_its_limits(motion: str) -> None:
    """In small and large arenas, at high and low speeds, with long and short steps, and hunters that chase."""
    met = set()
    for match in range(40):
        source = Random(match)
        side, speed, rate = source.choice([2.0, 11.088889122009277, 40.0]), source.choice([0.4, 1.0, 9.0]), 3.0
        arena = quiet(
            seed=match,
            hunters=3,
            side_m=side,
            target_motion=motion,
            target_speed_mps=speed,
            target_turn_rate_radps=source.choice([0.2, rate]),
            control_period_ms=source.choice([16, 100, 333, 1500]),
            initial_targets=5,
        )
        for _ in range(40):
            drive(arena, *((1.0, source.uniform(-1, 1)) for _ in arena.hunters))
            for target in arena.alive:
                assert 0.0 <= target.x <= side
                assert 0.0 <= target.y <= side
                assert -PI <= target.theta < PI
                assert target.v in ((speed,) if motion == "wander" else (speed, speed / 2))
                assert abs(target.w) <= rate
                met.add(target.at_wall)
                if not target.at_wall:
                    assert 0.0 < target.x < side
                    assert 0.0 < target.y < side
    assert met == {False, True}


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
def test_r3_8_a_target_has_no_watchdog() -> None:
    """In a step of three seconds it drives through all 187 or 188 ticks, and keeps its velocity; a hunter stops."""
    arena = quiet(target_motion="wander", target_turn_rate_radps=1e-9, control_period_ms=3000, side_m=100.0)
    target = lone_target(arena, 50.0, 50.0)
    drive(arena, (1.0, 0.0))
    assert (target.x, target.y) == pytest.approx((50.0 + 187 * 0.016, 50.0))
    assert target.v == 1.0
    assert arena.hunters[0].v == 0.0
    rest(arena)
    assert target.x == pytest.approx(50.0 + (187 + 188) * 0.016)


@pytest.mark.rule("R3.8")
def test_r3_8_a_target_that_appears_within_a_step_stands_still_until_the_next() -> None:
    """It appears 40 ms into a step, and after the step stands at its place: no velocity, no wall flag."""
    arena = quiet(target_motion="wander", spawn_frequency_hz=25.0, max_targets=1, initial_targets=0)
    rest(arena)
    (target,) = arena.alive
    place = quiet(initial_targets=1).alive[0]
    assert target.appeared == 40
    assert (target.x, target.y, target.theta) == (place.x, place.y, wrap(place.theta))
    assert (target.v, target.w, target.at_wall) == (0.0, 0.0, False)
    rest(arena)
    assert math.dist((target.x, target.y), (place.x, place.y)) == pytest.approx(6 * 0.016, rel=0.01)
    assert target.v == 1.0


@pytest.mark.rule("R3.8")
def test_r3_8_places_are_those_of_still_targets_and_only_theta_is_wrapped() -> None:
    """At reset; half of the thetas as drawn lie beyond pi."""
    still, moving = (quiet(initial_targets=40, max_targets=64, target_motion=motion) for motion in ("still", "flee"))
    assert [(one.x, one.y) for one in still.alive] == [(one.x, one.y) for one in moving.alive]
    assert [wrap(one.theta) for one in still.alive] == [one.theta for one in moving.alive]
    assert any(one.theta > PI for one in still.alive)


@pytest.mark.rule("R3.8")
def test_r3_8_reach_is_judged_where_the_target_stood_and_who_is_caught_does_not_move() -> None:
    """From the last micrometre within reach it flees at 10 m/s, and is caught; from the first one beyond it is not."""
    for away, caught in ((0.299999, True), (0.3, False)):
        arena = quiet(target_motion="flee", target_speed_mps=10.0)
        arena.place([(5.0, 5.0, 0.0)], [(5.0 + away, 5.0)])
        arena.step([((0.0, 0.0), 1)])
        (ruling,) = arena.rulings
        assert ruling is not None
        assert (ruling[0] == GRANTED) == caught
        assert ruling[2] == round(1e6 * away)
        assert (arena.alive == []) == caught


@pytest.mark.rule("R3.8")
def test_r3_8_still_targets_know_nothing_of_the_settings_of_moving_ones() -> None:
    """The digests stay, step after step, whatever they are."""
    settings = {"hunters": 3, "control": "target", "initial_targets": 8, "spawn_frequency_hz": 2.0}
    plain = quiet(**settings)
    set_up = quiet(
        **settings, target_speed_mps=7.0, target_turn_rate_radps=1.0, wander_period_ms=3, alarm_m=9.0, dropouts="fixed"
    )
    for _ in range(60):
        for arena in (plain, set_up):
            arena.step([1, 2, 1])
        assert plain.digest() == set_up.digest()
        assert plain.observations() == set_up.observations()


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
def test_r3_9_turn_rates_are_uniform() -> None:
    """Ten thousand of them, of 40 targets: each tenth of the range has its share."""
    arena = quiet(
        target_motion="wander", wander_period_ms=100, side_m=5000.0, initial_targets=40, max_targets=64, time_limit_s=99
    )
    tenths = [0] * 10
    for _ in range(250):
        rest(arena)
        for target in arena.alive:
            if not target.at_wall:
                tenths[int((target.w + 3.0) / 0.6)] += 1
    assert sum(tenths) > 9000
    assert all(abs(count - sum(tenths) / 10) < 150 for count in tenths)


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
    """Its command is six times the C library's bearing error, within its limit; it then leaves the wall."""
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
def test_r3_10_alarm_is_raised_strictly_within_its_distance() -> None:
    """In whole micrometres: 1.999999 m alarm it, 2.000000 m do not, and it wanders at half its speed."""
    stream = draw(key(1, WANDER), 1)
    for away, speed in ((1.999999, 1.0), (1.9999996, 0.5), (2.0, 0.5), (5.0, 0.5)):
        arena = quiet(target_motion="flee")
        arena.place([(1.5, 5.5, 0.0)], [(1.5 + away, 5.5)])
        (target,) = arena.alive
        rest(arena)
        assert target.v == speed
        wandered = (2.0 * fraction(draw(stream, 0)) - 1.0) * 3.0
        assert target.w == (0.0 if speed == 1.0 else wandered)


@pytest.mark.rule("R3.10")
def test_r3_10_without_alarm_or_hunters_a_target_wanders() -> None:
    """An alarm of 0 m is never raised; a withdrawn hunter is no threat."""
    deaf = quiet(target_motion="flee", alarm_m=0.0)
    deaf.place([(5.5, 5.5, 0.0)], [(5.5, 5.5)])
    alone = quiet(target_motion="flee")
    alone.place([(5.5, 5.0, 0.0)], [(5.5, 5.5)])
    alone.withdraw(0)
    slow = quiet(target_motion="wander", target_speed_mps=0.5)
    slow.place([(1.5, 5.5, 0.0)], [(5.5, 5.5)])
    for _ in range(20):
        for arena in (deaf, alone, slow):
            rest(arena)
        assert deaf.alive[0].__dict__ == alone.alive[0].__dict__ == slow.alive[0].__dict__


@pytest.mark.rule("R3.10")
def test_r3_10_of_two_threats_the_nearer_by_a_micrometre_counts() -> None:
    """One stands ahead, one behind: fleeing from the one ahead means to turn about."""
    for ahead, behind, turns in ((1.0, 1.000001, True), (1.000001, 1.0, False)):
        arena = quiet(target_motion="flee", hunters=2)
        arena.place([(5.5 + ahead, 5.5, 0.0), (5.5 - behind, 5.5, 0.0)], [(5.5, 5.5)])
        rest(arena)
        assert (arena.alive[0].w != 0.0) == turns


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
def test_r3_10_a_threat_at_the_same_place_is_behind_it() -> None:
    """It drives straight on, in whichever direction it looks."""
    for theta in (0.0, 1.0, -2.5, 3.0):
        arena = quiet(target_motion="flee")
        arena.hunters[0].x = arena.hunters[0].y = 5.5
        target = lone_target(arena, 5.5, 5.5, theta)
        rest(arena)
        assert target.w == pytest.approx(0.0, abs=1e-12)
        assert (target.x, target.y) == pytest.approx(
            (5.5 + 6 * 0.016 * math.cos(theta), 5.5 + 6 * 0.016 * math.sin(theta)), abs=1e-9
        )


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


@pytest.mark.rule("R3.10")
def test_r3_10_it_flees_though_it_met_a_wall_in_the_step_before() -> None:
    """The wall flag bends nothing: the push does."""
    commands = []
    for flag in (False, True):
        arena = quiet(target_motion="flee")
        arena.hunters[0].x, arena.hunters[0].y = 1.0, 4.9
        target = lone_target(arena, 0.0, 5.5, 2.0)
        target.at_wall = flag
        rest(arena)
        commands.append((target.v, target.w))
    assert commands[0] == commands[1]


@pytest.mark.rule("R3.10")
def test_r3_10_a_target_escapes_a_slower_hunter_and_not_a_faster_one() -> None:
    """Chased by the hosted controller at half of its speed, and at twice."""
    for speed, caught in ((0.5, False), (2.0, True)):
        arena = quiet(target_motion="flee", control="target", max_speed_mps=speed)
        arena.place([(2.0, 2.0, 0.0)], [(3.0, 3.0)])
        for _ in range(200):
            if not arena.alive:
                break
            arena.step([1])
        assert (arena.alive == []) == caught


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
