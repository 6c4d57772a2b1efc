"""Chapter 3, targets: every clause on every adjudicator; tests/oracle has those of targets that move."""

import math

import pytest
from oracle.arithmetic import PLACE, draw, fraction, key
from rulebook.adjudicators import Adjudicator
from rulebook.conftest import ArenaFactory

from catch_arena.config import TURTLESIM_SIDE_M, ArenaConfig


@pytest.mark.rule("R3.1")
@pytest.mark.parametrize(
    ("frequency", "period"),
    [(1.0, 1000), (3.0, 333), (1.5, 667), (0.16, 6250), (400.0, 3), (3000.0, 1), (0.0, 5000), (-2.0, 5000)],
)
def test_r3_1_the_timer_first_fires_one_period_after_reset(arena: ArenaFactory, frequency: float, period: int) -> None:
    """floor(1000 / f + 0.5) ms, at least 1; 5000 where f is not positive. The second firing is a period later."""
    match = arena(spawn_frequency_hz=frequency, control_period_ms=16, max_targets=64)
    assert match.alive == []
    for firing in (1, 2):
        while match.firings < firing:
            match.hold()
        assert match.time - 16 < firing * period <= match.time
        assert match.targets[firing - 1].appeared == firing * period


@pytest.mark.rule("R3.1")
def test_r3_1_a_period_that_would_round_to_nothing_is_1_ms(arena: ArenaFactory) -> None:
    """Sixteen firings in a step of 16 ms."""
    match = arena(spawn_frequency_hz=400_000.0, control_period_ms=16, max_targets=4)
    match.hold()
    assert match.firings == 16
    assert match.alive == [1, 2, 3, 4]
    assert match.skipped_full == 12


@pytest.mark.rule("R3.1")
def test_r3_1_initial_targets_stand_before_the_first_observation(arena: ArenaFactory) -> None:
    """They have the first numbers and appear at 0 ms; they are no firings."""
    match = arena(initial_targets=5)
    assert match.alive == [1, 2, 3, 4, 5]
    assert [target.appeared for target in match.targets] == [0] * 5
    assert match.firings == 0
    assert match.spawned == match.used == 5
    assert match.mask(0) == [1] * 6 + [0] * 3


def places(match: Adjudicator) -> list[tuple[float, float, float]]:
    return [(target.x, target.y, target.theta) for target in match.targets]


@pytest.mark.rule("R3.2")
@pytest.mark.parametrize(("side", "high"), [(TURTLESIM_SIDE_M, 10.5), (20.0, 20.0 - (TURTLESIM_SIDE_M - 10.5))])
def test_r3_2_places_are_uniform_between_the_bounds(arena: ArenaFactory, side: float, high: float) -> None:
    """64 places in each of 12 seeds: in range, spread over it, and the headings in [0, 2 pi)."""
    found = []
    for seed in range(12):
        match = arena(initial_targets=64, max_targets=64, side_m=side, seed=seed)
        found += places(match)
    for axis, (low, top) in enumerate(((0.5, high), (0.5, high), (0.0, math.tau))):
        values = [place[axis] for place in found]
        assert all(low <= value < top for value in values)
        tenths = [sum(int(10 * (value - low) / (top - low)) == tenth for value in values) for tenth in range(10)]
        assert min(tenths) > 40  # 76.8 are expected
        assert max(tenths) < 120
    assert len(set(found)) == len(found)


@pytest.mark.rule("R3.2")
@pytest.mark.parametrize(("seed", "axis"), [(12915147451021379664, 0), (7572032135351392532, 1)])
def test_r3_2_the_greatest_draw_stays_below_the_bound(arena: ArenaFactory, seed: int, axis: int) -> None:
    """Rounding would give the bound itself; A.5's mix, gone through backwards, gives the seeds that draw it."""
    assert fraction(draw(key(seed, PLACE), axis)) == 1.0 - 2.0**-53
    side = 3.0
    high = side - (TURTLESIM_SIDE_M - 10.5)
    assert 0.5 + (1.0 - 2.0**-53) * (high - 0.5) == high
    (place,) = places(arena(initial_targets=1, side_m=side, seed=seed))
    assert place[axis] == math.nextafter(high, 0.0)


@pytest.mark.rule("R3.3")
def test_r3_3_the_kth_place_depends_on_the_seed_and_k_alone(arena: ArenaFactory) -> None:
    """Placed at reset, spawned one by one, spawned by another timer while a hunter catches: the same places."""
    at_reset = places(arena(initial_targets=6, seed=9))
    by_timer = arena(spawn_frequency_hz=10.0, seed=9)
    by_timer.hold(6)
    assert places(by_timer) == at_reset
    hunted = arena(hunters=3, control="full", spawn_frequency_hz=4.0, max_targets=1, reach_m=50.0, seed=9)
    found = []
    while hunted.spawned < 6:
        hunted.step(((0.5, 0.5), 1 if hunted.alive else 0), ((1.0, 0.2), 0), ((0.1, 0.0), hunted.mask(2)[1]))
        found += places(hunted)
    assert sum(hunted.scores) >= 5
    assert list(dict.fromkeys(found)) == at_reset


@pytest.mark.rule("R3.4")
def test_r3_4_a_spawn_number_is_never_used_again(arena: ArenaFactory) -> None:
    """Twelve targets come and go in a storage of two."""
    match = arena(control="full", spawn_frequency_hz=10.0, max_targets=2, reach_m=50.0)
    seen = []
    for step in range(40):
        seen += match.alive
        match.step(((1.0, 0.5), match.mask(0)[1] if step % 3 else 0))
    distinct = list(dict.fromkeys(seen))
    assert distinct == list(range(1, len(distinct) + 1))
    assert len(distinct) > 12
    assert match.alive == sorted(match.alive)


@pytest.mark.rule("R3.4")
def test_r3_4_a_name_is_the_prefix_and_the_number() -> None:
    """In the world that people see, and in the evidence of a verdict."""
    from catch_arena.engine import Engine

    for prefix in ("target_turtle_", "žel-"):
        config = ArenaConfig(hunters=1, control="full", initial_targets=3, name_prefix=prefix)
        engine = Engine(config)
        engine.reset([1])
        assert [target.name for target in engine.world(0).targets] == [f"{prefix}{number}" for number in (1, 2, 3)]
        engine.place(0, hunters=[(5.0, 5.0, 0.0)], targets=[(5.0, 5.0)])
        import numpy as np

        engine.step(np.ones((1, 1), np.int64), np.zeros((1, 1, 2), np.float32))
        assert [ruling.target for ruling in engine.world(0).rulings] == [f"{prefix}4"]


@pytest.mark.rule("R3.5")
def test_r3_5_a_firing_that_finds_the_arena_full_is_skipped_and_counted(arena: ArenaFactory) -> None:
    """A skipped firing uses up no number: the next target has the next one."""
    match = arena(control="full", spawn_frequency_hz=10.0, max_targets=3, reach_m=50.0)
    match.hold(7)
    assert match.alive == [1, 2, 3]
    assert (match.firings, match.skipped_full, match.used, match.spawned) == (7, 4, 3, 3)
    match.step(((0.0, 0.0), 2))
    assert match.evidence()[0].number not in match.alive
    assert match.alive[-1] == 4
    assert len(match.alive) == 3
    assert (match.firings, match.skipped_full, match.used) == (8, 4, 4)


@pytest.mark.rule("R3.6")
def test_r3_6_a_firing_that_finds_the_service_down_uses_up_no_number(arena: ArenaFactory) -> None:
    """Half of the firings: the places that appear are still the first ones, in order."""
    match = arena(spawn_frequency_hz=10.0, max_targets=64, faults={"spawn_down": 0.5}, seed=3)
    match.hold(60)
    assert match.firings == 60
    assert 15 < match.skipped_down < 45
    assert match.used == match.spawned == 60 - match.skipped_down
    assert match.alive == list(range(1, len(match.alive) + 1))
    assert places(match) == places(arena(initial_targets=len(match.alive), max_targets=64, seed=3))


@pytest.mark.rule("R3.6")
def test_r3_6_a_spawn_that_the_simulator_refuses_uses_up_its_number(arena: ArenaFactory) -> None:
    """Half of the numbers: no target ever bears them, and the others stand at their own places."""
    match = arena(spawn_frequency_hz=10.0, max_targets=64, faults={"spawn_refused": 0.5}, seed=3)
    match.hold(60)
    assert match.used == match.firings == 60
    assert 15 < match.refused < 45
    assert match.spawned == len(match.alive) == 60 - match.refused
    everywhere = places(arena(initial_targets=60, max_targets=64, seed=3))
    assert places(match) == [everywhere[number - 1] for number in match.alive]


@pytest.mark.rule("R3.7")
def test_r3_7_targets_stay_where_they_are(arena: ArenaFactory) -> None:
    """Whatever hunters do around them."""
    match = arena(hunters=2, control="velocity", initial_targets=8, reach_m=0.001)
    before = match.targets
    for _ in range(20):
        match.step((1.0, 0.3), (0.7, -0.4))
    assert match.targets == before
