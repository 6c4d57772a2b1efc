"""Chapter 12, prey: every clause on every adjudicator; tests/oracle/test_prey.py places prey by hand."""

import math

import pytest
from rulebook.adjudicators import Adjudicator
from rulebook.conftest import ArenaFactory

ASK = ((0.0, 0.0), 1)
"""Requests the nearest target, at rest."""
HOLD = ((0.0, 0.0), 0)
FORWARD = (1.0, 0.0)
EVERYWHERE = {"side_m": 2.0, "reach_m": 3.0}
"""An arena in which everything is within reach."""


def stand_by(match: Adjudicator, index: int = 0, *, away: float = 0.1) -> None:
    """The hunter stands that far to the left of the target that was prey's at reset."""
    target = match.targets[index]
    match.place(hunters=[(target.x - away, target.y, 0.0)])


@pytest.mark.rule("R12.1")
def test_r12_1_the_first_numbers_are_preys(arena: ArenaFactory) -> None:
    """By index; the other initial targets are nobody's."""
    match = arena(control="full", prey=2, initial_targets=3)
    assert match.prey == [(1, 0, -1), (2, 0, -1)]
    assert match.alive == [1, 2, 3]


@pytest.mark.rule("R12.2")
@pytest.mark.parametrize("reverse", [False, True])
def test_r12_2_prey_drives_within_the_targets_limits(arena: ArenaFactory, reverse: bool) -> None:
    """An action is that share of the limits; backwards only where hunters may reverse."""
    limits = {"target_speed_mps": 0.5, "target_turn_rate_radps": 2.0, "side_m": 100.0}
    match = arena(control="full", prey=2, initial_targets=3, reverse=reverse, **limits)
    before = match.targets
    match.step(HOLD, prey=[FORWARD, (-0.5, 0.25)])
    ahead, back, still = match.targets
    assert math.dist((ahead.x, ahead.y), (before[0].x, before[0].y)) == pytest.approx(0.5 * 6 * 0.016)
    assert ahead.theta == before[0].theta
    assert (ahead.v, ahead.w, back.v, back.w) == (0.5, 0.0, -0.25 if reverse else 0.0, 0.5)
    assert still == before[2]


@pytest.mark.rule("R12.3")
def test_r12_3_the_state_at_the_beginning_of_the_step_decides(arena: ArenaFactory) -> None:
    """Prey that drives off at 9 m/s from within reach is caught, and its drive has not happened."""
    match = arena(control="full", prey=1, initial_targets=1, target_speed_mps=9.0)
    stand_by(match, away=0.299)
    match.step(ASK, prey=[FORWARD])
    assert match.alive == []
    assert match.prey == [(0, 1, 0)]
    assert match.caught_by == [0]
    assert match.scores == [1]


@pytest.mark.rule("R12.3")
def test_r12_3_two_that_return_in_one_step_come_by_index(arena: ArenaFactory) -> None:
    """Whoever caught which, they take the next numbers in the order of their index, and appear at the step's end."""
    match = arena(control="full", hunters=2, prey=2, initial_targets=2, prey_returns_s=0.2, **EVERYWHERE)
    one, other = match.targets
    match.place(hunters=[(other.x, other.y, 0.0), (one.x, one.y, 0.0)])
    match.step(ASK, ASK)
    assert match.prey == [(0, 1, 0), (0, 1, 0)]
    assert match.caught_by == [1, 0]
    match.hold()
    assert match.prey == [(3, 1, -1), (4, 1, -1)]
    assert [target.appeared for target in match.targets] == [200, 200]
    assert [(target.v, target.w, target.at_wall) for target in match.targets] == [(0.0, 0.0, 0.0)] * 2
    assert match.spawned == match.used == 4


@pytest.mark.rule("R12.3", "R3.5")
def test_r12_3_prey_waits_while_the_arena_is_full(arena: ArenaFactory) -> None:
    """The firing at 200 ms takes the only room; prey returns in the step in which that target is caught."""
    timer = {"max_targets": 1, "spawn_frequency_hz": 5.0}
    match = arena(control="full", prey=1, initial_targets=1, prey_returns_s=0.2, **timer, **EVERYWHERE)
    match.step(ASK)
    match.hold(3)
    assert match.alive == [2]
    assert match.prey == [(0, 1, 0)]
    assert match.skipped_full == 1
    match.step(ASK)
    assert match.prey == [(3, 1, -1)]
    assert match.targets[0].appeared == 500


@pytest.mark.rule("R12.4", "R12.3")
def test_r12_4_prey_sees_itself_the_hunters_and_the_other_prey(arena: ArenaFactory) -> None:
    """By the C library's sine and cosine; without noise and all round, whatever hunters see. Out, it sees nothing."""
    blind = {"view_noise_m": 1.0, "view_radius_m": 0.5, "view_angle_deg": 90.0}
    match = arena(control="full", hunters=2, prey=2, initial_targets=2, **blind)
    me, other = match.targets
    match.place(hunters=[(me.x, me.y - 0.1, 1.0), (me.x + 2.0, me.y, 2.0)])
    match.step(HOLD, ((0.5, 0.0), 0), prey=[(0.5, 0.5), FORWARD])
    me, other = match.targets
    hunters = [match.hunter(0), match.hunter(1)]
    own, rows = match.prey_observation(0)[:9], match.prey_observation(0)[9:]
    cosine, sine = math.cos(me.theta), math.sin(me.theta)
    assert own == pytest.approx([me.x, me.y, cosine, sine, 0.5, 1.5, 59.9, 0.0, 1.0], abs=1e-5)
    expected = []
    for turtle in (*hunters, other):
        dx, dy, turned = turtle.x - me.x, turtle.y - me.y, turtle.theta - me.theta
        expected += [
            cosine * dx + sine * dy,
            cosine * dy - sine * dx,
            1.0,
            math.cos(turned),
            math.sin(turned),
            turtle.v,
        ]
    assert rows == pytest.approx(expected, abs=1e-6)
    assert hunters[1].v == 1.0
    match.step(ASK, HOLD)
    assert match.prey_observation(0) == pytest.approx([0.0] * 6 + [59.8, 1.0, 0.0] + [0.0] * 18)
    assert match.prey_observation(1)[21:] == [0.0] * 6


@pytest.mark.rule("R12.4", "R7.1")
@pytest.mark.parametrize("order", [(0, 1, 2, 3, 4, 5, 6), (6, 5, 4, 3, 2, 1, 0), (3, 6, 0, 5, 2, 4, 1)])
def test_r12_4_bodies_that_are_equally_far_have_an_order(arena: ArenaFactory, order: tuple[int, ...]) -> None:
    """Six hunters at 0.5 m and one nearer, whatever their seats: by the greater left, then forward, then relative
    cosine.
    """
    match = arena(control="full", hunters=7, prey=1, initial_targets=1)
    me = match.targets[0]
    places = [(0.0, 0.4), (0.5, 0.0), (-0.5, 0.0), (0.0, 0.5), (0.0, -0.5), (0.0, 0.5), (0.0, 0.5)]
    headings = [0.0, 0.0, 0.0, me.theta, 0.0, me.theta + 1.0, me.theta - 2.0]
    poses = [(me.x + dx, me.y + dy, theta) for (dx, dy), theta in zip(places, headings, strict=True)]
    match.place(hunters=[poses[number] for number in order])
    match.look()
    numbers = match.prey_observation(0)[9:]
    rows = [tuple(numbers[at : at + 6]) for at in range(0, len(numbers), 6)]
    assert len(rows) == 7
    assert [round(math.hypot(row[0], row[1]), 6) for row in rows] == [0.4] + [0.5] * 6

    def rank(row: tuple[float, ...]) -> tuple[float, ...]:
        forward, left, _, cosine, sine, speed = row
        return (-round(left, 6), -round(forward, 6), -round(cosine, 6), -round(sine, 6), -speed)

    assert rows[1:] == sorted(rows[1:], key=rank)
    assert len({rank(row) for row in rows}) == 7


@pytest.mark.rule("R12.5")
def test_r12_5_prey_is_paid_for_time_distance_and_catches(arena: ArenaFactory) -> None:
    """The distance is that to where the nearest hunter stood."""
    weights = {"caught": -3.0, "survived": 2.0, "gained": 0.5}
    match = arena(control="full", prey=1, initial_targets=1, prey_rewards=weights, prey_returns_s=0.2)
    stand_by(match, away=0.2)
    was, hunter = match.targets[0], match.hunter()
    match.step(((0.1, 0.0), 0), prey=[(1.0, 0.3)])
    now = match.targets[0]
    gained = math.dist((now.x, now.y), (hunter.x, hunter.y)) - math.dist((was.x, was.y), (hunter.x, hunter.y))
    assert match.prey_parts == [(0.0, 0.1, pytest.approx(gained))]
    assert match.prey_rewards == [pytest.approx(0.2 + 0.5 * gained)]
    match.step(ASK, prey=[FORWARD])
    assert (match.prey_parts, match.prey_rewards) == ([(1.0, 0.0, 0.0)], [-3.0])
    match.hold()
    assert (match.prey_parts, match.prey_rewards) == ([(0.0, 0.0, 0.0)], [0.0])
    match.hold()
    assert match.prey_parts == [(0.0, 0.1, 0.0)]


@pytest.mark.rule("R12.5")
def test_r12_5_it_gains_on_a_hunter_at_its_very_place_and_on_nobody_where_all_are_withdrawn(
    arena: ArenaFactory,
) -> None:
    """A distance of zero is one."""
    match = arena(control="full", prey=1, initial_targets=1, side_m=50.0, prey_rewards={"gained": 1.0})
    stand_by(match, away=0.0)
    was = match.targets[0]
    match.step(HOLD, prey=[FORWARD])
    now = match.targets[0]
    assert match.prey_parts == [(0.0, 0.1, pytest.approx(math.dist((now.x, now.y), (was.x, was.y))))]
    assert match.prey_parts[0][2] > 0.09
    match.withdraw(0)
    match.step(HOLD, prey=[FORWARD])
    assert match.prey_parts == [(0.0, 0.1, 0.0)]


@pytest.mark.rule("R12.5")
def test_r12_5_withdrawn_prey_stands_still_and_is_caught(arena: ArenaFactory) -> None:
    """At once, and whatever it commands; that it is caught counts, and it is paid nothing."""
    match = arena(control="full", prey=1, initial_targets=1, prey_rewards={"survived": 1.0}, **EVERYWHERE)
    match.step(HOLD, prey=[FORWARD])
    match.withdraw_prey(0)
    was = match.targets[0]
    assert was.v == 0.0
    match.step(HOLD, prey=[(1.0, 1.0)])
    assert match.targets[0]._replace(at_wall=was.at_wall) == was
    assert (match.prey_parts, match.prey_rewards) == ([(0.0, 0.0, 0.0)], [0.0])
    match.step(ASK)
    assert match.prey == [(0, 1, 200)]
    assert match.prey_rewards == [0.0]
    assert match.scores == [1]


@pytest.mark.rule("R12.6", "R1.5")
@pytest.mark.parametrize(
    ("returns", "spawning", "ends"), [(None, False, True), (None, True, False), (0.5, False, False)]
)
def test_r12_6_an_episode_ends_when_nothing_is_alive_and_nothing_will_appear(
    arena: ArenaFactory, returns: float | None, spawning: bool, ends: bool
) -> None:
    """The only target is caught."""
    match = arena(control="full", prey=1, initial_targets=1, prey_returns_s=returns, spawning=spawning, **EVERYWHERE)
    match.step(ASK)
    assert match.alive == []
    assert (match.terminated, match.truncated) == (ends, False)
