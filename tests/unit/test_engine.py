"""The engine's rows keep to themselves: places, targets and prey by name, and lanes that are no arenas."""

import dataclasses

import numpy as np
import pytest

from catch_arena.core import rows
from catch_arena.core.arbiter import REQUEST_COLUMNS, REQUEST_SEAT, REQUEST_TARGET
from catch_arena.core.vectors import LANES
from catch_arena.engine import Engine
from catch_arena.errors import ConfigError
from catch_arena.policy import Limits
from catch_arena.scenarios import scenario
from catch_arena.verdicts import Verdict


def actions(engine, value=1):
    hunters, prey = engine.config.hunters, engine.config.prey
    choices = np.full((engine.num_arenas, hunters), value, dtype=np.int64)
    return choices, np.zeros((engine.num_arenas, hunters + prey, 2), dtype=np.float32)


def test_a_request_by_name_after_the_end_is_told_too():
    """R5.2: MATCH_OVER, though no rank in view was chosen."""
    engine = Engine(scenario("duel", max_cycles=1))
    engine.reset([1])
    engine.step(*actions(engine, 0))
    table = np.zeros((3, REQUEST_COLUMNS), np.int64)
    table[2, [REQUEST_SEAT, REQUEST_TARGET]] = 1, rows.NEVER_SPAWNED  # after a row for each hunter
    engine.step(*actions(engine, 0), requests=table)

    assert [(ruling.hunter, ruling.verdict) for ruling in engine.world(0).rulings] == [(1, Verdict.MATCH_OVER)]


def test_a_table_of_requests_without_a_row_for_each_hunter_is_refused():
    engine = Engine(scenario("duel"))
    engine.reset([1])
    with pytest.raises(ConfigError, match="requests must begin with 2 rows, one a hunter, got 1"):
        engine.step(*actions(engine), requests=np.zeros((1, REQUEST_COLUMNS), np.int64))


def test_a_state_in_other_parts_is_refused():
    """As one array of bytes, the form of an earlier version."""
    engine = Engine(scenario("duel"))
    engine.reset([1])
    saved = engine.save(0)
    memory = np.frombuffer(b"".join(part.tobytes() for part in saved.memory), np.uint8)
    for other in (memory, (memory,)):
        with pytest.raises(ConfigError, match="must come from an arena of the same kind"):
            engine.restore(dataclasses.replace(saved, memory=other), 0)


@pytest.mark.parametrize("control", ["target", "velocity", "full"])
def test_lanes_that_are_no_arenas_get_no_answers(control):
    """They are played with the others of their chunk, by what scratch memory has, and are in a state that is saved."""
    engine = Engine(scenario("standard", control=control), 5)
    engine.reset(range(5))
    rng = np.random.default_rng(3)
    for _ in range(80):
        engine.step(rng.integers(0, 9, (5, 4)), rng.uniform(-1, 1, (5, 4, 2)).astype(np.float32))
    (hunters,) = engine.views.hunters
    for row in (rows.VERDICT, rows.REQUESTED_NUMBER, rows.DISTANCE, rows.WINNER):
        assert not hunters[:, row // LANES, 5:].any()
    tallies = hunters[:, rows.TALLIES // LANES :]
    assert not tallies[:, :, 5:].any()
    assert tallies[:, :, :5].any()


def test_targets_are_put_where_they_have_been_for_some_time():
    """In one arena of the second chunk; prey, which has the first slots, is as old as it was."""
    engine = Engine(scenario("duel", prey=2, target_motion="wander", target_budget=None, initial_targets=2), 34)
    engine.reset(range(34))
    for _ in range(3):
        engine.step(*actions(engine))
    hunters, targets = [(5.0, 5.0, 0.0), (9.0, 9.0, 0.0)], [(5.5, 5.0), (5.0, 6.0)]
    before = [engine.digest(row) for row in range(34)]
    engine.place(33, hunters, targets, ages=[0.2501, 7.0])
    assert [engine.digest(row) == before[row] for row in range(34)] == [True] * 33 + [False]
    view = Limits.of(engine.config).view(engine.observations[33, 0].tolist(), [])
    assert sorted(target.age for target in view.targets) == [0.25, *[np.float32(0.3)] * 2, 7.0]
    engine.place(33, hunters, targets)
    view = Limits.of(engine.config).view(engine.observations[33, 0].tolist(), [])
    assert sorted(target.age for target in view.targets) == [0.0, 0.0, *[np.float32(0.3)] * 2]


def test_prey_that_is_out_is_not_placed_and_targets_are_only_as_far_as_there_is_room():
    engine = Engine(scenario("duel", prey=1, prey_returns_s=None, initial_targets=1, max_targets=2, spawning=False))
    hunters = [(5.0, 5.0, 0.0), (9.0, 9.0, 0.0)]
    engine.reset([1])
    engine.place(0, hunters, [(1.0, 1.0)], [(5.1, 5.0, 0.0)])
    engine.step(*actions(engine))
    engine.place(0, hunters, [(2.0, 2.0), (3.0, 3.0), (4.0, 4.0)], [(7.0, 7.0, 0.0)])
    world = engine.world(0)
    assert world.prey[0].target is None
    assert [(target.x, target.y) for target in world.targets] == [(2.0, 2.0), (3.0, 3.0)]


def test_a_target_comes_and_goes_by_name_in_one_row_alone():
    """R8.1, R3.5, R5.8: also behind the first chunk; a full arena takes none, and prey is never killed."""
    engine = Engine(scenario("duel", prey=1, initial_targets=3, max_targets=4), 34)
    engine.reset(range(34))
    assert engine.kill(33, 2)
    before = [engine.digest(row) for row in range(34)]
    for row in (31, 32):
        assert engine.spawn(row, 1.0, 2.0, 0.0) == 4
        assert engine.spawn(row, 1.0, 2.0, 0.0) == 0
        assert engine.kill(row, 3)
        assert not engine.kill(row, 1)
        assert not engine.kill(row, 99)
    assert engine.spawn(31, 3.0, 2.0, 0.0) == 5
    assert not engine.kill(33, 1)
    assert engine.kill(33, 3)
    changed = [row for row in range(34) if engine.digest(row) != before[row]]
    assert changed == [31, 32, 33]
    alive = {row: [target.number for target in engine.world(row).targets] for row in (30, *changed)}
    assert alive == {30: [1, 2, 3], 31: [1, 2, 4, 5], 32: [1, 2, 4], 33: [1]}
    assert [engine.world(row).spawned for row in (30, *changed)] == [3, 4, 3, 1]


def test_a_target_that_is_spawned_by_name_has_its_own_row_s_time():
    """R8.1: rows that were reset at other steps, in the last lane of a chunk and in the next one."""
    engine = Engine(scenario("duel", initial_targets=1), 34)
    engine.reset(range(34))
    for later in (31, 33):
        engine.step(*actions(engine, 0))
        engine.reset([7], arenas=[later])
    engine.step(*actions(engine, 0))
    for row in (30, 31, 32, 33):
        engine.spawn(row, 1.0, 2.0, 0.0)
    period_ms = engine.config.control_period_ms
    times = [engine.world(row).targets[-1].spawned_ms // period_ms for row in (30, 31, 32, 33)]
    assert times == [3, 2, 3, 1]


@pytest.mark.parametrize("row", [0, 31, 33])
def test_prey_is_never_killed_wherever_it_stands_in_the_list(row):
    """R8.1: it was caught, and has come back behind the others, who may be killed then; its target may not."""
    config = scenario("duel", prey=2, prey_returns_s=0.1, initial_targets=4, spawning=False, reach_m=0.4)
    engine = Engine(config, 34)
    engine.reset(range(34))
    targets = [(1.0, 9.0), (9.0, 1.0)]
    engine.place(row, [(5.0, 5.0, 0.0), (2.0, 2.0, 0.0)], targets, [(5.2, 5.0, 0.0), (8.0, 8.0, 0.0)])
    for _ in range(3):
        engine.step(*actions(engine))
    alive = engine.world(row).targets
    played = [target.prey for target in alive]
    assert sorted(filter(None, played)) == ["prey_0", "prey_1"]
    assert played[-1] == "prey_0"
    assert [engine.kill(row, target.number) for target in alive] == [prey is None for prey in played]


@pytest.mark.parametrize("weight", [1.0, -1.0])
def test_weights_pay_the_same_whether_or_not_the_parts_are_kept(weight):
    """R6.2, R12.5: progress and gained are measured for the reward too, not only for infos."""
    weights = {"rewards": {"progress": weight}, "prey_rewards": {"gained": weight}}
    config = scenario("herd").replace(control="target", **weights)
    kept, unkept = Engine(config), Engine(config, with_infos=False)
    for engine in (kept, unkept):
        engine.reset([1])
    paid = np.zeros(config.hunters + config.prey)
    choices, commands = actions(kept)
    for _ in range(20):
        for engine in (kept, unkept):
            engine.step(choices, commands + 1.0)  # prey drives
        paid += abs(unkept.rewards[0])
        assert (unkept.rewards == kept.rewards).all()
    assert (paid > 0.0).all()
