"""Chapter 12 on the oracle: small cases of prey, worked out by hand."""

import math

import pytest
from oracle.arena import OracleArena
from oracle.arithmetic import THREAT_LOT, draw, key, wrap
from oracle.quiet import drive, play, quiet, rest
from oracle.turtles import Target

ASK = ((0.0, 0.0), 1)
"""Requests the nearest target, at rest."""
FORWARD = (1.0, 0.0)
STEP = 6 * 0.016
"""The seconds of the first step's ticks."""


def target_of(arena: OracleArena, index: int = 0) -> Target:
    """The target that a prey plays now."""
    target = arena.prey[index].target
    assert target is not None
    return target


# ---- R12.1, R12.2: what it is, and how it moves ----


@pytest.mark.rule("R12.2", "R3.7")
@pytest.mark.parametrize("motion", ["still", "wander", "flee"])
def test_r12_2_targets_that_nobody_plays_move_as_target_motion_says(motion: str) -> None:
    """They move as in a match without prey, bit for bit; under `still` they stand where they are, with no wall flag."""
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


# ---- R12.3: caught, out, and back ----


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


# ---- R12.4: what it sees ----


@pytest.mark.rule("R12.4")
def test_r12_4_it_sees_the_nearest_eight_of_each() -> None:
    """Twelve hunters and eleven other prey stand in two rows; the nearest come first."""
    arena = quiet(hunters=12, prey=12)
    arena.place(
        [(1.0 + 0.5 * seat, 2.0, 0.0) for seat in range(12)], [], [(1.0 + 0.7 * i, 1.0, 0.0) for i in range(12)]
    )
    seen = arena.prey_observations()[0][9:]
    assert len(seen) == 6 * 16
    assert seen[0:48:6] == pytest.approx([0.5 * rank for rank in range(8)], abs=1e-6)
    assert seen[48::6] == pytest.approx([0.7 * rank for rank in range(1, 9)], abs=1e-6)


# ---- R12.5: what it is paid ----


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
        assert arena.prey_parts[0][2] == pytest.approx(STEP if nearest == 0 else -STEP)
    assert gains == {0, 1}


# ---- R12.6, R3.1: how it ends ----


# ---- A.8, and over whole matches ----
