"""R1.7 and R2.7 on the oracle: hunters that are not equal, and hunters that are gone."""

from random import Random

import pytest
from oracle.arbiter import GRANTED, HUNTER_INACTIVE, LOST_CONTEST, MALFORMED, OUT_OF_REACH, judge
from oracle.arena import PART_NAMES, OracleArena
from oracle.arithmetic import DROPOUT, draw, fraction, key
from oracle.quiet import drive, quiet, rest


@pytest.mark.rule("R2.7")
def test_r2_7_each_seat_has_its_own_limits() -> None:
    """The same action is half of one's own; the hosted controller stops at one's own."""
    arena = quiet(
        hunters=3, control=("velocity", "full", "target"), max_speed_mps=(2.0, 1.0, 0.5), max_turn_rate_radps=(4, 3, 2)
    )
    arena.place([(3.0, 3.0, 0.0), (3.0, 5.0, 0.0), (3.0, 7.0, 3.0)], [(9.0, 7.0)])
    arena.step([(0.5, -1.0), ((0.5, -1.0), 0), 1])
    assert [(hunter.v, hunter.w) for hunter in arena.hunters] == [(1.0, -4.0), (0.5, -3.0), (0.5, -2.0)]


@pytest.mark.rule("R2.7")
def test_r2_7_who_may_reverse_does_so_within_its_own_limit() -> None:
    """Not within the others'."""
    arena = quiet(hunters=2, reverse=True, max_speed_mps=(2.0, 0.5))
    drive(arena, (-1.0, 0.0), (-1.0, 0.0))
    assert [hunter.v for hunter in arena.hunters] == [-2.0, -0.5]


@pytest.mark.rule("R2.7")
@pytest.mark.parametrize("control", ["target", "velocity", "full"])
def test_r2_7_the_same_number_for_each_seat_plays_as_one_for_all(control: str) -> None:
    """In every bit of the state and of what is seen."""
    numbers = {"max_speed_mps": 3.1, "max_turn_rate_radps": 2.7, "reach_m": 0.6}
    settings = {"hunters": 4, "control": control, "initial_targets": 12, "spawn_frequency_hz": 5.0}
    one, each = quiet(**settings, **numbers), quiet(**settings, **{name: (it,) * 4 for name, it in numbers.items()})
    source = Random(3)
    for _ in range(60):
        actions: list[object] = []
        for _ in range(4):
            command, rank = (source.uniform(-1, 1), source.uniform(-1, 1)), source.randint(0, 2)
            actions.append({"target": rank, "velocity": command, "full": (command, rank)}[control])
        one.step(actions)
        each.step(actions)
        assert one.digest() == each.digest()
        assert one.observations() == each.observations()
        assert one.rulings == each.rulings
    assert sum(hunter.score for hunter in one.hunters) > 0


@pytest.mark.rule("R2.7")
def test_r2_7_reach_is_that_of_the_hunter_that_asks() -> None:
    """At the same distance, to the micrometre: one is granted, the other is out of reach and contests nothing."""
    arena = quiet(hunters=2, reach_m=(0.3, 0.300001))
    arena.place([(4.7, 5.0, 0.0), (5.0, 5.3, 0.0)], [(5.0, 5.0)])
    arena.step([((0.0, 0.0), 1)] * 2)
    assert arena.rulings == [(OUT_OF_REACH, 1, 300_000, None), (GRANTED, 1, 300_000, 1)]


@pytest.mark.rule("R2.7")
def test_r2_7_a_longer_reach_is_no_shorter_distance() -> None:
    """Of those within their own reach the nearest wins; by name too."""
    arena = quiet(hunters=2, reach_m=(0.3, 0.9))
    arena.place([(4.8, 5.0, 0.0), (5.0, 5.5, 0.0)], [(5.0, 5.0)])
    arena.step([((0.0, 0.0), 1)] * 2)
    assert [found and found[0] for found in arena.rulings] == [GRANTED, LOST_CONTEST]
    named = judge(
        hunters=[(4.8, 5.0), (5.0, 5.5)],
        targets={"a": (5.0, 5.0), "b": (5.7, 5.5)},
        requests=[(0, "b"), (1, "b")],
        reach_m=(0.3, 0.9),
    )
    assert [verdict for verdict, *_ in named] == [OUT_OF_REACH, GRANTED]


@pytest.mark.rule("R2.7")
@pytest.mark.parametrize("control", ["target", "velocity"])
def test_r2_7_the_request_is_made_within_ones_own_reach(control: str) -> None:
    """R4.1 and R4.4: 0.5 m away the long arm asks, and the short one does not."""
    arena = quiet(hunters=2, control=control, reach_m=(0.6, 0.3), policy="first_come")
    arena.place([(4.5, 5.0, 0.0), (5.5, 5.0, 3.0)], [(5.0, 5.0)])
    arena.step([1, 1] if control == "target" else [(0.0, 0.0)] * 2)
    assert arena.rulings == [(GRANTED, 1, 500_000, 0), None]


def out_by(arena: OracleArena) -> list[int | None]:
    """In which step each hunter dropped out, when twenty have been played."""
    out: list[int | None] = [None] * len(arena.hunters)
    for step in range(20):
        rest(arena)
        for hunter in arena.hunters:
            if hunter.withdrawn and out[hunter.seat] is None:
                out[hunter.seat] = step
            assert hunter.withdrawn == (out[hunter.seat] is not None)
    return out


@pytest.mark.rule("R1.7")
def test_r1_7_who_drops_out_is_drawn_for_each_step_and_seat() -> None:
    """The first step in which the hash falls below the rate; nobody comes back; nothing else is drawn by it."""
    for seed in range(10):
        expected: list[int | None] = []
        for seat in range(6):
            drawn = (fraction(draw(draw(key(seed, DROPOUT), step), seat)) for step in range(20))
            expected.append(next((step for step, f in enumerate(drawn) if f < 0.05), None))
        assert out_by(quiet(seed=seed, hunters=6, dropout_rate=0.05)) == expected
        assert out_by(quiet(seed=seed, hunters=6, dropout_rate=0.05, dropouts="fixed", initial_targets=9)) == expected


@pytest.mark.rule("R1.7")
def test_r1_7_the_rate_is_a_probability() -> None:
    """Of a thousand hunters about 1 - 0.9 ** 20, or 878, are gone after twenty steps; at 0 nobody, at 1 everybody."""
    gone = sum(out is not None for seed in range(100) for out in out_by(quiet(seed=seed, hunters=10, dropout_rate=0.1)))
    assert 840 < gone < 915
    assert out_by(quiet(hunters=10)) == [None] * 10
    assert out_by(quiet(hunters=10, dropout_rate=1.0)) == [0] * 10


@pytest.mark.rule("R1.7")
def test_r1_7_who_drops_out_in_a_step_counts_as_withdrawn_in_all_of_it() -> None:
    """Its request is refused, it does not move, its reward is zero, and targets do not flee from it."""
    arena = quiet(
        hunters=2, dropout_rate=1.0, target_motion="flee", rewards={"time": 1.0, "rejected_request": -1.0}, reach_m=1.0
    )
    arena.place([(5.0, 5.0, 0.0), (5.0, 4.0, 0.0)], [(5.5, 5.0)])
    arena.hunters[0].score = 7
    arena.step([((1.0, 1.0), 1), ((1.0, 1.0), 5)])
    assert [found and found[0] for found in arena.rulings] == [HUNTER_INACTIVE, MALFORMED]
    assert [(hunter.x, hunter.y, hunter.v, hunter.w) for hunter in arena.hunters] == [
        (5.0, 5.0, 0, 0),
        (5.0, 4.0, 0, 0),
    ]
    assert arena.rewards == [0.0, 0.0]
    assert arena.parts == [(0.0,) * len(PART_NAMES)] * 2
    assert arena.alive[0].v == 0.5
    assert arena.hunters[0].score == 7
    assert not arena.terminated
    assert not arena.truncated


@pytest.mark.rule("R1.7")
def test_r1_7_a_dropout_is_a_withdrawal_before_the_step() -> None:
    """Bit for bit: the same match with `withdraw` called for those hunters, step by step, and no dropouts."""
    settings = {
        "hunters": 5,
        "control": "target",
        "initial_targets": 12,
        "target_motion": "flee",
        "spawn_frequency_hz": 4.0,
    }
    dropping, told = quiet(**settings, dropout_rate=0.03, seed=4), quiet(**settings, seed=4)
    for step in range(100):
        stream = draw(key(4, DROPOUT), step)
        for hunter in told.hunters:
            if not hunter.withdrawn and fraction(draw(stream, hunter.seat)) < 0.03:
                told.withdraw(hunter.seat)
        for arena in (dropping, told):
            arena.step([1, 1, 2, 1, 1])
        assert dropping.digest() == told.digest()
        assert dropping.observations() == told.observations()
        assert dropping.rewards == told.rewards
    assert sum(hunter.withdrawn for hunter in told.hunters) > 0


@pytest.mark.rule("R1.7")
def test_r1_7_a_reset_brings_everybody_back() -> None:
    """And the same seed drops the same ones again."""
    arena = quiet(hunters=6, dropout_rate=0.05, seed=3)
    first = out_by(arena)
    arena.reset(3)
    assert not any(hunter.withdrawn for hunter in arena.hunters)
    assert out_by(arena) == first


@pytest.mark.rule("R1.7")
def test_r1_7_an_arena_whose_hunters_are_all_out_goes_on_to_its_end() -> None:
    """Its targets go on appearing and moving until the time limit."""
    arena = quiet(hunters=2, dropout_rate=1.0, spawn_frequency_hz=10.0, time_limit_s=2.0, target_motion="wander")
    while not arena.truncated:
        rest(arena)
    assert arena.steps == 20
    assert len(arena.alive) == 16
    assert arena.alive[0].v == 1.0
