"""Chapter 12 on the oracle: what must hold of prey, and small cases worked out by hand."""

import math
from random import Random
from typing import Any

import pytest
from oracle.arbiter import GRANTED, KILL_FAILED
from oracle.arena import PREY_PART_NAMES, OracleArena
from oracle.arithmetic import PI, THREAT_LOT, draw, key, wrap
from oracle.quiet import drive, play, quiet, rest
from oracle.turtles import Target

ASK = ((0.0, 0.0), 1)
"""Requests the nearest target, at rest."""
HOLD = ((0.0, 0.0), 0)
FORWARD = (1.0, 0.0)
STEP = 6 * 0.016
"""The seconds of the first step's ticks."""


def one_on_one(away: float = 0.1, **settings: Any) -> OracleArena:
    """A hunter in the middle, and prey to its right that heads away from it."""
    arena = quiet(**{"prey": 1, **settings})
    arena.place([(5.0, 5.0, 0.0)], [], [(5.0 + away, 5.0, 0.0)])
    return arena


def target_of(arena: OracleArena, index: int = 0) -> Target:
    """The target that a prey plays now."""
    target = arena.prey[index].target
    assert target is not None
    return target


def part(arena: OracleArena, name: str) -> list[float]:
    """One part of prey's reward, by index."""
    return [parts[PREY_PART_NAMES.index(name)] for parts in arena.prey_parts]


# ---- R12.1, R12.2: what it is, and how it moves ----


@pytest.mark.rule("R12.1")
def test_r12_1_the_first_numbers_are_preys() -> None:
    """By index, at the places that these numbers have without prey; theta is wrapped, since targets move."""
    arena, still = quiet(prey=3, initial_targets=5), quiet(initial_targets=5)
    assert [target_of(arena, index).number for index in range(3)] == [1, 2, 3]
    assert [target.number for target in arena.alive] == [1, 2, 3, 4, 5]
    for one, other in zip(arena.alive, still.alive, strict=True):
        assert (one.x, one.y, one.theta) == (other.x, other.y, wrap(other.theta))
    assert arena.spawned == arena.used == 5


@pytest.mark.rule("R12.2")
@pytest.mark.parametrize("reverse", [False, True])
def test_r12_2_prey_drives_within_the_targets_limits(reverse: bool) -> None:
    """An action is that share of the limits, backwards only where hunters may reverse; it has no watchdog."""
    arena = quiet(prey=1, reverse=reverse, target_speed_mps=0.5, target_turn_rate_radps=2.0, control_period_ms=1500)
    arena.place([(1.0, 1.0, 0.0)], [], [(5.0, 5.0, 0.0)])
    target = target_of(arena)
    drive(arena, prey=[FORWARD])
    assert (target.x, target.y, target.v) == (pytest.approx(5.0 + 93 * 0.016 * 0.5), 5.0, 0.5)
    drive(arena, prey=[(-0.5, 0.25)])
    assert (target.v, target.w) == (-0.25 if reverse else 0.0, 0.5)


@pytest.mark.rule("R12.2", "R3.7")
@pytest.mark.parametrize("motion", ["still", "wander", "flee"])
def test_r12_2_targets_that_nobody_plays_move_as_target_motion_says(motion: str) -> None:
    """As in a match without prey, bit for bit; under `still` they stand where they are, with no wall flag."""
    plays = quiet(prey=2, initial_targets=6, target_motion=motion, max_targets=8, spawn_frequency_hz=3.0)
    without = quiet(initial_targets=6, target_motion=motion, max_targets=8, spawn_frequency_hz=3.0)
    for _ in range(40):
        drive(plays, prey=[(0.7, 0.2), (0.9, -0.5)])
        rest(without)
        for one, other in zip(plays.alive[2:], without.alive[2:], strict=True):
            pose = (other.x, other.y, wrap(other.theta) if motion == "still" else other.theta)
            assert (one.x, one.y, one.theta, one.v, one.w, one.at_wall) == (*pose, other.v, other.w, other.at_wall)
        for one, other in zip(plays.alive[:2], without.alive[:2], strict=True):
            assert (one.x, one.y) != (other.x, other.y)


@pytest.mark.rule("R12.2")
def test_r12_2_an_action_is_rounded_to_float32() -> None:
    """As a hunter's is."""
    arena = quiet(prey=1, target_speed_mps=1.0)
    drive(arena, prey=[(0.1, 0.0)])
    assert target_of(arena).v == 0.10000000149011612


# ---- R12.3: caught, out, and back ----


@pytest.mark.rule("R12.3")
def test_r12_3_the_state_at_the_beginning_of_the_step_decides() -> None:
    """At 0.299999 m it is caught whatever it commands, at 0.3 m it is not though it drives at the hunter."""
    for away, theta, caught in ((0.299999, 0.0, True), (0.3, PI, False)):
        arena = quiet(prey=1, target_speed_mps=5.0)
        arena.place([(5.0, 5.0, 0.0)], [], [(5.0 + away, 5.0, theta)])
        play(arena, ASK, prey=[FORWARD])
        assert arena.rulings[0] is not None
        assert (arena.rulings[0][0] == GRANTED) == caught
        assert (arena.prey[0].target is None) == caught
        assert arena.prey[0].times_caught == caught
        assert arena.caught_by == [0 if caught else None]


@pytest.mark.rule("R12.3")
@pytest.mark.parametrize(
    ("away_s", "steps_out"), [(2.0, 19), (0.0, 0), (0.1, 0), (0.1004, 0), (0.1006, 1), (0.2, 1), (0.95, 9)]
)
def test_r12_3_prey_returns_when_its_time_is_up(away_s: float, steps_out: int) -> None:
    """Caught on the state at 300 ms: it is there again in the first state at 300 ms + prey_returns_s or later, at the
    place of the next number, at rest.
    """
    arena = quiet(prey=1, initial_targets=2, prey_returns_s=away_s)
    rest(arena, 3)
    arena.place([(5.0, 5.0, 0.0)], [], [(5.1, 5.0, 0.0)])
    play(arena, ASK, prey=[FORWARD])
    for _ in range(steps_out - 1):
        assert arena.prey[0].caught_at == 300
        assert arena.alive == []
        rest(arena)
    if steps_out:
        drive(arena, prey=[FORWARD])
    target, place = target_of(arena), quiet(initial_targets=3).alive[2]
    assert (target.number, target.appeared) == (3, arena.time)
    assert arena.time == 300 + 100 * max(1, math.ceil(round(1000 * away_s) / 100))
    assert (target.x, target.y, target.theta) == (place.x, place.y, wrap(place.theta))
    assert (target.v, target.w, target.at_wall) == (0.0, 0.0, False)
    assert (arena.spawned, arena.used, arena.firings) == (3, 3, 0)
    assert (arena.prey[0].times_caught, arena.prey[0].caught_at) == (1, None)
    drive(arena, prey=[FORWARD])
    assert target.v == 1.0
    assert (target.x, target.y) != (place.x, place.y)


def two_caught(**settings: Any) -> OracleArena:
    """Two prey are caught in the first step, prey 1 by seat 0 and prey 0 by seat 1."""
    arena = quiet(hunters=2, prey=2, **{"prey_returns_s": 0.2, **settings})
    arena.place([(5.0, 5.0, 0.0), (8.0, 5.0, 0.0)], [], [(8.1, 5.0, 0.0), (5.1, 5.0, 0.0)])
    play(arena, ASK, ASK)
    assert arena.caught_by == [1, 0]
    return arena


@pytest.mark.rule("R12.3")
def test_r12_3_two_that_return_in_one_step_come_by_index() -> None:
    """The next number is prey_0's, whoever was caught by whom; both appear at the step's end."""
    arena = two_caught()
    rest(arena)
    assert [target_of(arena, index).number for index in range(2)] == [3, 4]
    assert [target.appeared for target in arena.alive] == [200, 200]


@pytest.mark.rule("R12.3")
def test_r12_3_firings_come_before_returns() -> None:
    """The timer's target of the same instant has the lower number, and takes the last room."""
    for room, numbers in ((3, [3, 4, 5]), (2, [3, 4])):
        arena = two_caught(max_targets=room, spawn_frequency_hz=5.0)
        rest(arena)
        assert [target.number for target in arena.alive] == numbers
        assert [prey.target and prey.target.number for prey in arena.prey] == [4, 5 if room == 3 else None]
        assert arena.skipped_full == 0


@pytest.mark.rule("R12.3")
def test_r12_3_prey_waits_while_the_arena_is_full() -> None:
    """The firing at 200 ms has taken its room; when that target is caught, prey_1 comes at the end of that step."""
    arena = two_caught(max_targets=2, spawn_frequency_hz=5.0)
    rest(arena)
    assert arena.prey[1].caught_at == 0
    assert [target.number for target in arena.alive] == [3, 4]
    standing = arena.alive[0]
    arena.hunters[0].x, arena.hunters[0].y = standing.x, standing.y
    play(arena, ASK, HOLD)
    assert target_of(arena, 1).number == 5
    assert target_of(arena, 1).appeared == 300
    assert [target.number for target in arena.alive] == [4, 5]


@pytest.mark.rule("R12.3")
def test_r12_3_a_return_draws_no_faults() -> None:
    """With every spawn refused and the service down all the time, it returns."""
    arena = two_caught(faults={"spawn_refused": 1.0, "spawn_down": 1.0}, spawn_frequency_hz=10.0)
    rest(arena)
    assert [target_of(arena, index).number for index in range(2)] == [3, 4]
    assert (arena.refused, arena.skipped_down, arena.firings) == (0, 2, 2)


@pytest.mark.rule("R12.3")
def test_r12_3_of_a_refused_kill_nothing_happens_to_prey() -> None:
    """It drives on, with its number."""
    arena = one_on_one(faults={"kill_refused": 1.0})
    play(arena, ASK, prey=[FORWARD])
    assert arena.rulings == [(KILL_FAILED, 1, 100_000, None)]
    assert target_of(arena).number == 1
    assert target_of(arena).x == pytest.approx(5.1 + STEP)
    assert arena.prey[0].times_caught == 0
    assert arena.caught_by == [None]


@pytest.mark.rule("R12.3")
def test_r12_3_what_prey_commands_while_it_is_out_is_ignored() -> None:
    """Two matches, with another action in the step in which it returns."""
    arenas = [one_on_one(prey_returns_s=0.2) for _ in range(2)]
    for command, arena in zip((FORWARD, (0.0, 1.0)), arenas, strict=True):
        play(arena, ASK)
        drive(arena, prey=[command])
    assert arenas[0].digest() == arenas[1].digest()
    assert target_of(arenas[0]).v == 0.0


@pytest.mark.rule("R12.3", "R12.6")
def test_r12_3_without_a_return_it_stays_out() -> None:
    """prey_returns_s None: prey_0 is never seen again, and the match goes on for prey_1 until it is caught too."""
    arena = quiet(prey=2, prey_returns_s=None, spawning=False)
    arena.place([(5.0, 5.0, 0.0)], [], [(5.1, 5.0, 0.0), (9.0, 9.0, 0.0)])
    play(arena, ASK)
    rest(arena, 50)
    assert arena.prey[0].target is None
    assert not arena.terminated
    arena.place([(5.0, 5.0, 0.0)], [], [(0.0, 0.0, 0.0), (5.1, 5.0, 0.0)])
    play(arena, ASK)
    assert arena.terminated
    assert not arena.truncated


# ---- R12.4: what it sees ----


@pytest.mark.rule("R12.4")
def test_r12_4_prey_sees_itself_the_hunters_and_the_other_prey() -> None:
    """Worked out by hand: prey_0 at (5, 5) heads up; hunters 2 m in front and 1 m to its left; prey_1 3 m behind."""
    arena = quiet(hunters=2, prey=2, initial_targets=3, view_noise_m=1.0, view_radius_m=0.5, teams=((0, 1),))
    arena.place([(5.0, 7.0, -PI / 2), (4.0, 5.0, PI / 2)], [(5.0, 5.2)], [(5.0, 5.0, PI / 2), (5.0, 2.0, 0.0)])
    arena.hunters[0].v, arena.hunters[1].v, target_of(arena, 1).v = 1.5, 0.5, 0.25
    own, rest_of = arena.prey_observations()[0][:9], arena.prey_observations()[0][9:]
    assert own == pytest.approx([5.0, 5.0, 0.0, 1.0, 0.0, 0.0, 60.0, 0.0, 1.0], abs=1e-6)
    assert rest_of[:6] == pytest.approx([0.0, 1.0, 1.0, 1.0, 0.0, 0.5], abs=1e-6)
    assert rest_of[6:12] == pytest.approx([2.0, 0.0, 1.0, -1.0, 0.0, 1.5], abs=1e-6)
    assert rest_of[12:] == pytest.approx([-3.0, 0.0, 1.0, 0.0, -1.0, 0.25], abs=1e-6)
    arena.withdraw(1)
    arena.withdraw_prey(1)
    rest_of = arena.prey_observations()[0][9:]
    assert rest_of[:6] == pytest.approx([2.0, 0.0, 1.0, -1.0, 0.0, 1.5], abs=1e-6)
    assert rest_of[6:12] == [0.0] * 6
    assert rest_of[12:] == pytest.approx([-3.0, 0.0, 1.0, 0.0, -1.0, 0.0], abs=1e-6)


@pytest.mark.rule("R12.4")
def test_r12_4_it_sees_the_nearest_eight_of_each() -> None:
    """Of twelve hunters and eleven other prey, which stand in two rows, the nearest first."""
    arena = quiet(hunters=12, prey=12)
    arena.place(
        [(1.0 + 0.5 * seat, 2.0, 0.0) for seat in range(12)], [], [(1.0 + 0.7 * i, 1.0, 0.0) for i in range(12)]
    )
    seen = arena.prey_observations()[0][9:]
    assert len(seen) == 6 * 16
    assert seen[0:48:6] == pytest.approx([0.5 * rank for rank in range(8)], abs=1e-6)
    assert seen[48::6] == pytest.approx([0.7 * rank for rank in range(1, 9)], abs=1e-6)


@pytest.mark.rule("R12.4")
def test_r12_4_of_hunters_equally_near_the_one_further_left_comes_first() -> None:
    """Then the one further ahead, and then the other columns: what is the same in all is the same twice."""
    arena = quiet(hunters=4, prey=1)
    arena.place([(4.0, 5.0, 0.0), (5.0, 4.0, 0.0), (6.0, 5.0, 0.0), (5.0, 6.0, 0.0)], [], [(5.0, 5.0, 0.0)])
    seen = arena.prey_observations()[0][9:]
    assert [tuple(seen[at : at + 2]) for at in range(0, 24, 6)] == [(0.0, 1.0), (1.0, 0.0), (-1.0, 0.0), (0.0, -1.0)]


@pytest.mark.rule("R12.4", "R12.3")
def test_r12_4_while_it_is_out_it_sees_nothing_and_is_not_seen() -> None:
    """Only the time left and how often it was caught."""
    arena = quiet(prey=3)
    arena.place([(5.0, 5.0, 0.0)], [], [(5.1, 5.0, 0.0), (7.0, 5.0, 0.0), (8.0, 5.0, 0.0)])
    play(arena, ASK)
    out, other, _ = arena.prey_observations()
    assert out == pytest.approx([0.0] * 6 + [59.9, 1.0, 0.0] + [0.0] * 18)
    assert other[15:21] == [1.0, 0.0, 1.0, 1.0, 0.0, 0.0]
    assert other[21:] == [0.0] * 6


# ---- R12.5: what it is paid ----


@pytest.mark.rule("R12.5")
def test_r12_5_prey_is_paid_for_time_and_distance() -> None:
    """It drives straight away from the nearest hunter, which follows and does not count as moved."""
    weights = {"caught": -1.0, "survived": 2.0, "gained": 0.5}
    arena = quiet(hunters=2, prey=1, prey_rewards=weights)
    arena.place([(4.0, 5.0, 0.0), (9.0, 5.0, 0.0)], [], [(5.0, 5.0, 0.0)])
    drive(arena, (1.0, 0.0), prey=[FORWARD])
    assert arena.prey_parts[0] == (0.0, 0.1, pytest.approx(STEP))
    assert arena.prey_rewards == [pytest.approx(0.2 + 0.5 * STEP)]
    arena.withdraw(0)
    drive(arena, prey=[FORWARD])
    assert part(arena, "gained") == [pytest.approx(-STEP)]
    arena.withdraw(1)
    drive(arena, prey=[FORWARD])
    assert arena.prey_parts == [(0.0, 0.1, 0.0)]


@pytest.mark.rule("R12.5")
def test_r12_5_who_is_caught_or_out_neither_survives_nor_gains() -> None:
    """The step of its catch costs, those while it is out pay nothing; nor does one in which it returns at once."""
    weights = {"caught": -2.0, "survived": 1.0, "gained": 1.0}
    arena = one_on_one(prey_returns_s=0.2, prey_rewards=weights)
    play(arena, ASK, prey=[FORWARD])
    assert (arena.prey_parts, arena.prey_rewards) == ([(1.0, 0.0, 0.0)], [-2.0])
    rest(arena)
    assert arena.prey_parts == [(0.0, 0.0, 0.0)]
    assert arena.prey[0].target is not None
    rest(arena)
    assert arena.prey_parts == [(0.0, 0.1, 0.0)]
    arena = one_on_one(prey_returns_s=0.0, prey_rewards=weights)
    play(arena, ASK, prey=[FORWARD])
    assert arena.prey[0].target is not None
    assert arena.prey_parts == [(1.0, 0.0, 0.0)]


@pytest.mark.rule("R12.5")
def test_r12_5_of_hunters_equally_near_a_lot_says_who_counts() -> None:
    """Between two of them prey gains from the one what it loses to the other."""
    gains = set()
    for seed in range(12):
        arena = quiet(seed=seed, hunters=2, prey=1)
        arena.place([(4.0, 5.0, 0.0), (6.0, 5.0, 0.0)], [], [(5.0, 5.0, 0.0)])
        drive(arena, prey=[FORWARD])
        lots = draw(draw(key(seed, THREAT_LOT), 0), 1)
        nearest = min((0, 1), key=lambda seat: draw(lots, seat))
        gains.add(nearest)
        assert part(arena, "gained") == [pytest.approx(STEP if nearest == 0 else -STEP)]
    assert gains == {0, 1}


@pytest.mark.rule("R12.5")
def test_r12_5_withdrawn_prey_stands_still_and_is_caught_and_returns() -> None:
    """In all of that it is paid nothing; its command is ignored, before and after its return."""
    arena = one_on_one(away=1.0, prey_returns_s=0.2, prey_rewards={"caught": -1.0, "survived": 1.0, "gained": 1.0})
    drive(arena, prey=[FORWARD])
    x = target_of(arena).x
    arena.withdraw_prey(0)
    assert target_of(arena).v == 0.0
    drive(arena, prey=[(1.0, 1.0)])
    assert (target_of(arena).x, target_of(arena).theta) == (x, 0.0)
    arena.hunters[0].x = x
    play(arena, ASK)
    assert arena.hunters[0].score == arena.prey[0].times_caught == 1
    assert (arena.prey_rewards, arena.prey_parts) == ([0.0], [(0.0, 0.0, 0.0)])
    rest(arena)
    back = target_of(arena)
    place = (back.x, back.y, back.theta)
    drive(arena, prey=[(1.0, 1.0)])
    assert (back.x, back.y, back.theta) == place
    assert arena.prey_parts == [(0.0, 0.0, 0.0)]


@pytest.mark.rule("R12.5")
def test_r12_5_withdrawn_prey_that_is_out_returns_and_stands_still() -> None:
    """Its withdrawal while it is out changes nothing of its return."""
    arena = one_on_one(prey_returns_s=0.3)
    play(arena, ASK)
    arena.withdraw_prey(0)
    rest(arena, 2)
    back = target_of(arena)
    drive(arena, prey=[FORWARD])
    assert (back.number, back.v) == (2, 0.0)


# ---- R12.6, R3.1: how it ends ----


@pytest.mark.rule("R12.6", "R1.5")
@pytest.mark.parametrize(
    ("prey", "returns", "spawning", "ends"),
    [
        (1, None, False, True),
        (1, None, True, False),
        (1, 0.3, False, False),
        (0, 0.3, False, True),
        (0, 2.0, True, False),
    ],
)
def test_r12_6_an_episode_ends_when_nothing_is_alive_and_nothing_will_appear(
    prey: int, returns: float | None, spawning: bool, ends: bool
) -> None:
    """The only target is caught."""
    arena = quiet(prey=prey, initial_targets=1, prey_returns_s=returns, spawning=spawning)
    standing = arena.alive[0]
    arena.hunters[0].x, arena.hunters[0].y = standing.x, standing.y
    play(arena, ASK)
    assert arena.alive == []
    assert (arena.terminated, arena.truncated) == (ends, False)


@pytest.mark.rule("R3.1")
def test_r3_1_with_the_timer_off_no_firing_happens_or_is_counted() -> None:
    """At whatever frequency."""
    arena = quiet(spawning=False, spawn_frequency_hz=30.0, initial_targets=2)
    rest(arena, 20)
    assert (arena.firings, arena.spawned, arena.skipped_full, len(arena.alive)) == (0, 2, 0, 2)


# ---- A.8, and over whole matches ----


@pytest.mark.rule("R12.3")
def test_r12_3_the_state_ends_with_each_preys_numbers() -> None:
    """Its target's number or 0, times caught, and the time of its catch while it is out, else -1."""
    arena = quiet(prey=2, prey_returns_s=0.2)
    arena.place([(5.0, 5.0, 0.0)], [], [(5.1, 5.0, 0.0), (9.0, 5.0, 0.0)])
    rest(arena)
    assert arena.numbers()[-6:] == [1, 0, -1, 2, 0, -1]
    play(arena, ASK)
    assert arena.numbers()[-6:] == [0, 1, 100, 2, 0, -1]
    rest(arena)
    assert arena.numbers()[-6:] == [3, 1, -1, 2, 0, -1]


@pytest.mark.rule("R12.1", "R5.8")
def test_r12_1_nobody_is_lost_over_whole_matches() -> None:
    """Every prey plays an alive target of its own or is out; catches and the alive add up to what was spawned; a
    target that prey played and that is gone was caught, and counts for the prey that played it.
    """
    returned = waited = 0
    for match in range(20):
        source = Random(match)
        arena = quiet(
            seed=match,
            hunters=3,
            control="target",
            side_m=4.0,
            reach_m=0.6,
            prey=4,
            initial_targets=source.choice([4, 6]),
            max_targets=source.choice([6, 8]),
            spawn_frequency_hz=source.choice([1.0, 9.0]),
            prey_returns_s=source.choice([0.0, 0.35, 2.0, None]),
            target_motion=source.choice(["still", "flee"]),
        )
        caught_of_prey = 0
        for _ in range(60):
            numbers = [prey.target and prey.target.number for prey in arena.prey]
            play(arena, *[source.randint(0, 2)] * 3, prey=[(source.uniform(-1, 1), source.uniform(-1, 1))] * 4)
            played = [prey.target for prey in arena.prey if prey.target is not None]
            assert len({target.number for target in played}) == len(played)
            assert all(target in arena.alive for target in played)
            assert len(arena.alive) <= arena.settings["max_targets"]
            assert sum(hunter.score for hunter in arena.hunters) + len(arena.alive) == arena.spawned
            taken = [found[1] for found in arena.rulings if found and found[0] == GRANTED]
            caught_of_prey += sum(number in taken for number in numbers if number)
            assert sum(prey.times_caught for prey in arena.prey) == caught_of_prey
            for number, prey in zip(numbers, arena.prey, strict=True):
                returned += number is None and prey.target is not None
                away = arena.settings["prey_returns_s"]
                if prey.caught_at is not None and away is not None:
                    waited += arena.time >= prey.caught_at + 1000 * away
    assert returned > 20
    assert waited > 0
