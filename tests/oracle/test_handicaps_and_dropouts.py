"""R1.7 and R2.7 on the oracle: hunters that are not equal, and hunters that are gone."""

import pytest
from oracle.arbiter import GRANTED, HUNTER_INACTIVE, MALFORMED
from oracle.arena import PART_NAMES, OracleArena
from oracle.arithmetic import DROPOUT, draw, fraction, key
from oracle.quiet import quiet, rest


@pytest.mark.rule("R2.7")
def test_r2_7_each_seat_has_its_own_limits() -> None:
    """An action is a share of the hunter's own limits, which the hosted controller keeps too."""
    arena = quiet(
        hunters=3, control=("velocity", "full", "target"), max_speed_mps=(2.0, 1.0, 0.5), max_turn_rate_radps=(4, 3, 2)
    )
    arena.place([(3.0, 3.0, 0.0), (3.0, 5.0, 0.0), (3.0, 7.0, 3.0)], [(9.0, 7.0)])
    arena.step([(0.5, -1.0), ((0.5, -1.0), 0), 1])
    assert [(hunter.v, hunter.w) for hunter in arena.hunters] == [(1.0, -4.0), (0.5, -3.0), (0.5, -2.0)]


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
def test_r1_7_who_drops_out_in_a_step_counts_as_withdrawn_in_all_of_it() -> None:
    """The hunter's request is refused, it does not move, its reward is zero, and targets do not flee from it."""
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
