"""Rows of one batch that differ in step, end, withdrawals, controls and order of bodies play as an oracle each."""

from random import Random
from typing import Any

import numpy as np
import pytest
from oracle.arena import OracleArena
from properties.matches import begun, some_actions, some_prey_actions
from properties.test_engine_equals_oracle import compare, with_prey
from rulebook.adjudicators import as_arrays, by_seat

from catch_arena.config import ArenaConfig, Control
from catch_arena.core import rows
from catch_arena.core.controllers import CONTROLS
from catch_arena.engine import Engine
from catch_arena.layout import columns
from catch_arena.verdicts import Verdict

ROWS = 3
MANY_ROWS = 33
"""One more than a chunk has."""
LOTS = 5
"""Rows in which is drawn."""
STEPS = 14
SMALL = {"hunters": 3, "control": ("target", "velocity", "full"), "side_m": 2.5, "reach_m": 0.6, "time_limit_s": 1.1}
WEIGHTS = {
    "catch": 1.0,
    "rival_catch": -0.3,
    "lost_contest": -0.2,
    "rejected_request": -0.1,
    "progress": 0.7,
    "time": -0.05,
    "mate_catch": 0.15,
}
PREY = {
    "prey": 3,
    "initial_targets": 3,
    "target_speed_mps": 2.0,
    "prey_rewards": {"caught": -1.0, "survived": 0.3, "gained": 0.7},
}
CONFIGS = {
    "prey that waits for room": {**PREY, "prey_returns_s": 0.2, "max_targets": 4, "spawn_frequency_hz": 6.0},
    "prey that is gone for good": {
        **PREY,
        "prey_returns_s": None,
        "spawning": False,
        "control": "velocity",
        "reach_m": 1.0,
    },
    "teams": {
        "teams": ((0, 2), (1,)),
        "team_share": 0.4,
        "initial_targets": 9,
        "reach_m": 2.0,
        "spawn_frequency_hz": 9.0,
    },
    "nobody shares": {"teams": ((1, 0), (2,)), "initial_targets": 4, "spawn_frequency_hz": 9.0},
    "no teams": {"team_share": 0.4, "initial_targets": 4, "spawn_frequency_hz": 9.0},
    "narrow views": {"initial_targets": 9, "view_angle_deg": 100.0, "view_radius_m": 1.2, "spawning": False},
    "one rival of many": {
        "hunters": 5,
        "control": "full",
        "observed_hunters": 1,
        "teams": ((0, 2), (1, 3, 4)),
        "view_noise_m": 0.1,
    },
    "dropouts": {"dropout_rate": 0.2, "initial_targets": 9, "reach_m": 1.5, "spawn_frequency_hz": 9.0},
    "targets that turn, and appear within a step": {
        "target_motion": "wander",
        "target_speed_mps": 1.5,
        "initial_targets": 2,
        "spawn_frequency_hz": 9.0,
    },
    "a budget and faults": {
        "target_budget": 5,
        "initial_targets": 2,
        "spawn_frequency_hz": 9.0,
        "faults": {"spawn_down": 0.3, "spawn_refused": 0.2},
    },
    "wide views": {"initial_targets": 9, "view_angle_deg": 350.0, "spawning": False},
}
"""Much happens in each."""
TINY = 2.0**-100
"""A fraction of a velocity."""
CROWDS = [(1, 1, 3), (2, 2, 41), (4, 9, 3), (8, 16, 9), (9, 2, 3), (10, 12, 3)]
"""Numbers of hunters, prey and rows: fewer bodies than prey sees, as many, and more; in one chunk and in two."""


def config_of(name: str) -> ArenaConfig:
    return ArenaConfig().replace(**SMALL | {"rewards": WEIGHTS} | CONFIGS[name])


def actions_of(
    source: Random, config: ArenaConfig, oracles: list[OracleArena]
) -> tuple[list[Any], list[Any], list[Any]]:
    """For each row, as the oracles take them; and all of them as the engine does."""
    hunters = [some_actions(source, config, oracle.masks()) for oracle in oracles]
    prey = [some_prey_actions(source, config) for _ in oracles]
    choices, commands = zip(*(as_arrays(config, own) for own in hunters), strict=True)
    return hunters, prey, [np.stack(choices), np.stack(list(map(with_prey, commands, prey)))]


def play_in_place(
    source: Random, config: ArenaConfig, batch: Engine, oracles: list[OracleArena], ranks: int = 0
) -> None:
    """A step in which all stay where they are, as their velocities are too small for a change of place, but not all the
    same; hunters ask for one of the nearest targets, or for none. Batch and oracles agree on what is seen then.
    """
    names = [column.name for column in columns(config)]

    def some_velocity() -> tuple[float, float]:
        return source.choice([0.0, TINY, 2 * TINY]), 0.0

    hunters = [[(some_velocity(), source.randint(0, ranks)) for _ in range(config.hunters)] for _ in oracles]
    prey = [[some_velocity() for _ in range(config.prey)] for _ in oracles]
    choices, commands = zip(*(as_arrays(config, own) for own in hunters), strict=True)
    batch.step(np.stack(choices), np.stack(list(map(with_prey, commands, prey))))
    for row, oracle in enumerate(oracles):
        oracle.step(hunters[row], prey[row])
        compare(batch, oracle, config, names, row)


@pytest.mark.parametrize("name", CONFIGS)
def test_rows_that_begin_and_end_apart_play_as_the_oracle_does(name: str) -> None:
    """Row 1 begins anew after 3 steps; all hunters of row 2 are withdrawn after 7, and in row 0 a prey. Who has ended
    stands still, and is told nothing new; and then all begin anew.
    """
    config, source = config_of(name), Random(20261123)
    batch, oracles = begun(config, range(ROWS))
    names = [column.name for column in columns(config)]
    ended, caught_last = 0, 0
    for step in range(STEPS + 2):
        for row in {3: [1], STEPS: range(ROWS)}.get(step, []):
            batch.reset([9 + row], [row])
            oracles[row].reset(9 + row)
        for seat in range(config.hunters) if step == 7 else ():
            batch.withdraw(2, seat)
            oracles[2].withdraw(seat)
        if step == 7 and config.prey:
            batch.withdraw(0, config.hunters + 1)
            oracles[0].withdraw_prey(1)
        over = [oracle.terminated or oracle.truncated for oracle in oracles]
        digests = [bytes(batch.digest(row)) for row in range(ROWS)]
        hunters, prey, arrays = actions_of(source, config, oracles)
        batch.step(*arrays)
        for row, oracle in enumerate(oracles):
            if over[row]:
                ended += 1
                assert bytes(batch.digest(row)) == digests[row]
                assert not batch.rewards[row].any()
                assert not batch.parts[row].any()
                assert not batch.prey_parts[row].any()
                caught_last += any(catcher is not None for catcher in oracle.caught_by)
                assert all(one.caught_by is None for one in batch.world(row).prey)
                continue
            oracle.step(hunters[row], prey[row])
            compare(batch, oracle, config, names, row)
    assert ended > 0
    assert caught_last > 0 or config.prey_returns_s is not None


@pytest.mark.parametrize("name", CONFIGS)
def test_figures_are_what_the_oracle_has_been_paid(name: str) -> None:
    """Without parts, as learners have it, through an episode of each row; ranks are R6.1's, R11.1's and R12.5's."""
    config, source = config_of(name).replace(time_limit_s=0.6), Random(7)
    batch, oracles = begun(config, range(MANY_ROWS), with_infos=False, auto_reset=True)
    oracles[2].withdraw(1)
    batch.withdraw(2, 1)
    for row, index in ((1, 0), (2, 1)) if config.prey else ():
        oracles[row].withdraw_prey(index)
        batch.withdraw(row, config.hunters + index)
    paid = np.zeros((MANY_ROWS, config.hunters))
    prey_paid = np.zeros((MANY_ROWS, config.prey))
    won = np.zeros((MANY_ROWS, config.hunters))
    met = np.zeros((MANY_ROWS, config.hunters, len(Verdict)))
    for step in range(1, 7):
        hunters, prey, arrays = actions_of(source, config, oracles)
        batch.step(*arrays)
        for row, oracle in enumerate(oracles):
            if oracle.terminated or oracle.truncated:
                continue
            oracle.step(hunters[row], prey[row])
            paid[row] += oracle.rewards
            prey_paid[row] += oracle.prey_rewards
            contests = set()
            for seat, ruling in enumerate(oracle.rulings):
                if ruling is not None:
                    verdict, number, _, winner = ruling
                    met[row, seat, verdict - 1] += 1
                    if verdict == Verdict.LOST_CONTEST:
                        contests.add((winner, number))
            for winner, _ in contests:
                won[row, winner] += 1
            assert batch.rewards[row].tolist() == [*oracle.rewards, *oracle.prey_rewards]
            if oracle.terminated or oracle.truncated:
                scores = [hunter.score for hunter in oracle.hunters]
                figures, of_prey = np.split(batch.records[row], [config.hunters])
                assert batch.lengths[row] == step
                assert figures[:, rows.FINAL_REWARD_SUM].tolist() == [np.float32(one) for one in paid[row]]
                assert figures[:, rows.FINAL_SCORE].tolist() == scores
                assert figures[:, rows.FINAL_CONTESTS_WON].tolist() == won[row].tolist()
                assert figures[:, rows.FINAL_TALLIES : rows.FINAL_TEAM_SCORE].tolist() == met[row].tolist()
                team_scores = oracle.team_scores()
                for seats, score in zip(config.team_seats, team_scores, strict=True):
                    assert config.teams is None or (figures[list(seats), rows.FINAL_TEAM_SCORE] == score).all()
                    assert (
                        figures[list(seats), rows.FINAL_RANK] == 1 + sum(other > score for other in team_scores)
                    ).all()
                keys = [(one.withdrawn, one.times_caught) for one in oracle.prey]
                expected = [
                    [one.times_caught, 1 + sum(other < own for other in keys), np.float32(earned)]
                    for one, own, earned in zip(oracle.prey, keys, prey_paid[row], strict=True)
                ]
                assert of_prey[:, [rows.FINAL_SCORE, rows.FINAL_RANK, rows.FINAL_REWARD_SUM]].tolist() == expected
    assert all(oracle.terminated or oracle.truncated for oracle in oracles)
    assert won.any() or "reach_m" not in CONFIGS[name]


@pytest.mark.parametrize(("hunters", "prey", "rows"), CROWDS)
def test_what_prey_sees_has_its_order_in_every_row(hunters: int, prey: int, rows: int) -> None:
    """Hunters and prey stand on the nodes of a coarse net, or one on another, and no two rows alike: most distances are
    those of several bodies, some are zero, and some bodies look the same. In the end nobody hunts in row 0.
    """
    settings = {"side_m": 4.0, "prey": prey, "initial_targets": prey, "max_targets": 16, "time_limit_s": 0.201}
    config, source = ArenaConfig(hunters=hunters, control="full").replace(**settings), Random(hunters + 100 * prey)
    batch, oracles = begun(config, range(rows))

    def node() -> tuple[float, float, float]:
        return source.choice([1.0, 2.0, 3.0]), source.choice([1.0, 2.0, 3.0]), source.choice([0.0, 1.5, -1.5, 3.0])

    for leaving in ([(1, source.randrange(hunters))], [(0, seat) for seat in range(hunters)]):
        for row, oracle in enumerate(oracles):
            bodies = [node() for _ in range(hunters)], [], [node() for _ in range(prey)]
            batch.place(row, *bodies)
            oracle.place(*bodies)
        for row, seat in leaving:
            batch.withdraw(row, seat)
            oracles[row].withdraw(seat)
        play_in_place(source, config, batch, oracles)


@pytest.mark.parametrize("rows", [1, 20])
def test_what_hunters_see_has_its_order_in_every_row(rows: int) -> None:
    """Twelve hunters of three teams stand in one place or two, and each sees the first four of the others: who are
    equally far may look the same but for their catches, their team or their seat, which the noise tells.
    """
    settings = {
        "side_m": 4.0,
        "reach_m": 6.0,
        "initial_targets": 8,
        "max_targets": 16,
        "spawn_frequency_hz": 60.0,
        "observed_hunters": 4,
        "teams": ((0, 3, 5, 10), (1, 2, 8, 11), (4, 6, 7, 9)),
        "view_noise_m": 0.1,
    }
    config, source = ArenaConfig(hunters=12, control="full").replace(**settings), Random(11)
    batch, oracles = begun(config, range(rows))
    for ranks in (0, 4):  # nobody has caught anything after the first
        for row, oracle in enumerate(oracles):
            places = source.choice([[1.0], [1.0, 2.0]])
            poses = [(source.choice(places), 1.0, source.choice([1.5, -1.5])) for _ in range(12)]
            targets = [(1.0 + index / 8, 2.0) for index in range(8)]
            batch.place(row, poses, targets)
            oracle.place(poses, targets)
        play_in_place(source, config, batch, oracles, ranks)


@pytest.mark.parametrize("policy", ["nearest", "first_come"])
def test_every_row_draws_its_own_lots(policy: str) -> None:
    """R5.4, R5.9, R8.3: two hunters equally far from two targets each, and a kill service that fails now and then; rows
    have seeds and steps of their own.
    """
    faults = {"kill_refused": 0.3, "kill_down": 0.2}
    config = ArenaConfig().replace(hunters=4, control="full", policy=policy, faults=faults)
    source = Random(20261124)
    seeds = [source.getrandbits(64) for _ in range(LOTS)]
    batch, oracles = begun(config, seeds)
    position = [(x, y, 0.0) for x in (4.3, 4.7) for y in (2.0, 8.0)], [(4.5, 2.0), (4.5, 8.0)]
    standing = [((0.0, 0.0), 1)] * config.hunters
    choices, commands = as_arrays(config, standing)
    met = set()
    for step in range(8):
        for row, oracle in enumerate(oracles):
            if step == 2 and row % 3 == 0:
                batch.reset([seeds[row] + 1 & 2**64 - 1], [row])
                oracle.reset(seeds[row] + 1 & 2**64 - 1)
            batch.place(row, *position)
            oracle.place(*position)
        shape = (LOTS, 1, 1)
        batch.step(np.tile(choices, shape[:2]), np.tile(commands, shape))
        for row, oracle in enumerate(oracles):
            oracle.step(standing)
            assert by_seat(batch.rulings(row), config) == oracle.rulings, f"row {row}, step {step}"
            assert [one.number for one in batch.world(row).targets] == [one.number for one in oracle.alive]
            met |= {(row > 0, found[0]) for found in oracle.rulings if found}
    judged = (Verdict.GRANTED, Verdict.LOST_CONTEST, Verdict.KILL_FAILED, Verdict.SERVICE_DOWN)
    assert {(True, verdict) for verdict in judged} <= met


def test_rows_may_differ_in_how_their_hunters_are_driven() -> None:
    """R4.1, R4.4: each plays as an oracle of its own controls. In one seat all differ, in others two."""
    ways: list[tuple[Control, ...]] = [
        ("target", "velocity", "full", "target"),
        ("target", "full", "velocity", "full"),
        ("velocity", "target", "full", "full"),
    ]
    config, source = config_of("no teams").replace(hunters=4, control="full", time_limit_s=60.0), Random(20261125)
    configs = [config.replace(control=way) for way in ways]
    batch = Engine(config, len(ways), any_control=True)
    batch.controls[:] = [[CONTROLS[word] for word in way] for way in ways]
    oracles = [OracleArena(own.to_dict()) for own in configs]
    batch.reset(range(len(ways)))
    for seed, oracle in enumerate(oracles):
        oracle.reset(seed)
    for _ in range(STEPS):
        given = [some_actions(source, own, oracle.masks()) for own, oracle in zip(configs, oracles, strict=True)]
        choices, commands = zip(*map(as_arrays, configs, given), strict=True)
        batch.step(np.stack(choices), np.stack(commands))
        for row, (own, oracle) in enumerate(zip(configs, oracles, strict=True)):
            oracle.step(given[row])
            compare(batch, oracle, own, [column.name for column in columns(own)], row)
