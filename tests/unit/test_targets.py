"""Targets that move draw their threats by lot in every row, where random matches seldom come."""

import numpy as np
import pytest
from oracle.arena import OracleArena

from catch_arena.config import ArenaConfig
from catch_arena.core.math import wrap
from catch_arena.engine import Engine

ROWS = 5
CROSS = ((6.0, 5.0, 0.0), (5.0, 6.0, 1.0), (4.0, 5.0, 2.0), (5.0, 4.0, 3.0))
"""Four hunters a metre from a target at (5, 5), one in each direction; every distance is the same double."""


def rows_with_oracles(**settings):
    """Row by row the same arenas: a batch, and an oracle for each row; each with steps and withdrawals of its own."""
    config = ArenaConfig(control="full", initial_targets=0, spawn_frequency_hz=0.001, max_targets=8, **settings)
    batch, oracles = Engine(config, ROWS), [OracleArena(config.to_dict()) for _ in range(ROWS)]
    seeds = [(2**62 + 12345678901 * row**3) % 2**64 for row in range(ROWS)]
    batch.reset(seeds)
    for row, oracle in enumerate(oracles):
        oracle.reset(seeds[row])
        for _ in range(row):  # a row more has been played a step more
            oracle.step([((0.0, 0.0), 0)] * config.hunters)
    hold, rest = np.zeros((ROWS, config.hunters), np.int64), np.zeros((ROWS, config.hunters, 2), np.float32)
    for step in range(ROWS - 1):
        batch.step(hold, rest)
        late = [row for row in range(ROWS) if row < ROWS - 1 - step]
        batch.reset([seeds[row] for row in late], late)
    return batch, oracles


def play_on(batch, oracles, steps):
    """Everybody stands; the states are the same after each step."""
    hunters = len(oracles[0].hunters)
    for step in range(steps):
        batch.step(np.zeros((ROWS, hunters), np.int64), np.zeros((ROWS, hunters, 2), np.float32))
        for row, oracle in enumerate(oracles):
            oracle.step([((0.0, 0.0), 0)] * hunters)
            assert bytes(batch.digest(row)) == oracle.digest(), f"row {row}, step {step}"


def place(batch, oracles, hunters, targets):
    for row, oracle in enumerate(oracles):
        batch.place(row, hunters, targets)
        oracle.place(hunters, targets)


@pytest.mark.parametrize("withdrawn", [None, 0, 1, 3])
def test_each_target_of_each_row_draws_its_threat(withdrawn):
    """R3.10: among four equally near, of whom one may have left; every seat is drawn by some target."""
    batch, oracles = rows_with_oracles(hunters=4, target_motion="flee")
    if withdrawn is not None:
        for row, oracle in enumerate(oracles):
            batch.withdraw(row, withdrawn)
            oracle.withdraw(withdrawn)
    drawn = set()
    for _ in range(3):
        place(batch, oracles, CROSS, [(5.0, 5.0)] * 8)
        drawn |= {threat.seat for oracle in oracles for target in oracle.alive if (threat := oracle._threat(target))}
        play_on(batch, oracles, 1)
    assert drawn == {0, 1, 2, 3} - {withdrawn}


def test_who_is_farther_has_no_lot():
    """R3.10: two of four are equally near, and seats 0 and 3 are a micrometre farther or right beside."""
    farther = ((6.000001, 5.0, 0.0), CROSS[1], CROSS[2], (9.0, 9.0, 0.0))
    for hunters in (farther, farther[::-1]):
        batch, oracles = rows_with_oracles(hunters=4, target_motion="flee")
        place(batch, oracles, hunters, [(5.0, 5.0)] * 8)
        play_on(batch, oracles, 2)


def test_a_lot_is_drawn_only_within_the_alarm_and_for_the_target_that_needs_it():
    """R3.10: beside targets with one threat, with several that are too far away, and with none."""
    for alarm in (1.0, 1.000001):
        batch, oracles = rows_with_oracles(hunters=4, target_motion="flee", alarm_m=alarm)
        place(batch, oracles, CROSS, [(5.0, 5.0), (6.5, 5.0), (9.0, 9.0), (5.0, 5.0), (6.0, 6.0), (5.0, 5.0)])
        play_on(batch, oracles, 3)


@pytest.mark.parametrize("motion", ["wander", "flee"])
def test_each_row_keeps_its_draws_and_its_walls(motion):
    """R3.9: rows whose clocks differ draw anew at other times, and meet walls at others."""
    batch, oracles = rows_with_oracles(
        hunters=1, target_motion=motion, target_speed_mps=9.0, wander_period_ms=170, alarm_m=0.5
    )
    place(batch, oracles, [(1.0, 1.0, 0.0)], [(10.5, 5.0), (10.9, 1.0), (5.0, 10.9), (1.2, 1.1), (0.1, 6.0)])
    play_on(batch, oracles, 9)
    assert len({oracle.time for oracle in oracles}) == ROWS


def test_those_whose_distances_round_to_the_same_micrometre_draw_lots_however_far_they_are():
    """R3.10: 0.9 micrometres apart at 7 m, in directions that differ: the squares of the distances do so by 13 mm2."""
    hunters = tuple(
        (0.5 + (7.0 + um * 1e-6) * np.cos(angle), 0.5 + (7.0 + um * 1e-6) * np.sin(angle), 0.0)
        for um, angle in ((-0.45, 0.1), (0.45, 1.4))
    )
    drawn = set()
    for order in (hunters, hunters[::-1]):
        batch, oracles = rows_with_oracles(hunters=2, target_motion="flee", alarm_m=20.0)
        place(batch, oracles, order, [(0.5, 0.5)] * 8)
        drawn |= {threat.seat for oracle in oracles for one in oracle.alive if (threat := oracle._threat(one))}
        play_on(batch, oracles, 1)
    assert drawn == {0, 1}


def test_a_threat_at_the_very_alarm_is_none():
    """R3.10: half a micrometre less rounds to the alarm too."""
    for dx, share in ((1.2, 0.5), (1.1999996, 0.5), (1.1999994, 1.0)):
        batch, oracles = rows_with_oracles(hunters=1, target_motion="flee", alarm_m=1.2)
        place(batch, oracles, [(5.0 - dx, 5.0, 0.0)], [(5.0, 5.0)])
        play_on(batch, oracles, 1)
        assert [oracle.alive[0].v for oracle in oracles] == [oracles[0].target_speed * share] * ROWS


def test_a_threat_in_the_very_place_of_a_target_is_behind_it():
    """R3.10: whatever way the target looks."""
    batch, oracles = rows_with_oracles(hunters=1, target_motion="flee")
    for row, oracle in enumerate(oracles):
        batch.place(row, [(5.0, 5.0, 0.0)], [])
        batch.spawn(row, 5.0, 5.0, 1.0 + row)
        oracle.place([(5.0, 5.0, 0.0)], [(5.0, 5.0)])
        oracle.alive[0].theta = wrap(1.0 + row)
    play_on(batch, oracles, 1)
    assert {oracle.alive[0].w for oracle in oracles} == {0.0}
