"""Chapter 11 on the oracle: what must hold of teams, and small cases worked out by hand."""

from random import Random
from typing import Any

import pytest
from oracle.arbiter import GRANTED, LOST_CONTEST
from oracle.arena import PART_NAMES, OracleArena
from oracle.quiet import quiet

ASK = ((0.0, 0.0), 1)
"""Requests the nearest target, at rest."""
HOLD = ((0.0, 0.0), 0)
SHARED = {"rewards": {"catch": 1.0, "rival_catch": -0.5, "lost_contest": -0.1, "time": 0.0, "mate_catch": 0.25}}


def three_catches(**settings: Any) -> OracleArena:
    """After a step in which seats 0 and 3 catch a target each, and seat 1 loses seat 0's; seat 2 holds."""
    arena = quiet(hunters=4, **SHARED, **settings)
    arena.place([(2.0, 2.1, 0.0), (2.0, 2.2, 0.0), (8.0, 2.0, 0.0), (5.0, 8.0, 0.0)], [(2.0, 2.0), (5.0, 8.1)])
    arena.step([ASK, ASK, HOLD, ASK])
    return arena


def part(arena: OracleArena, name: str) -> list[float]:
    """One part of the reward, by seat."""
    return [parts[PART_NAMES.index(name)] for parts in arena.parts]


@pytest.mark.rule("R11.2")
@pytest.mark.parametrize(
    ("teams", "rival", "mate"),
    [
        (None, [1, 2, 2, 1], [0, 0, 0, 0]),
        (((0,), (1,), (2,), (3,)), [1, 2, 2, 1], [0, 0, 0, 0]),
        (((0, 1), (2, 3)), [1, 1, 1, 1], [0, 1, 1, 0]),
        (((3, 0), (2, 1)), [0, 2, 2, 0], [1, 0, 0, 1]),
        (((0, 1, 2, 3),), [0, 0, 0, 0], [1, 2, 2, 1]),
        (((1,), (0, 2, 3)), [0, 2, 0, 0], [1, 0, 2, 1]),
    ],
)
def test_r11_2_a_catch_is_a_mates_or_a_rivals(teams: Any, rival: list[float], mate: list[float]) -> None:
    """Every grant counts once for everybody: as one's own, a mate's, or a rival's."""
    arena = three_catches(teams=teams)
    assert part(arena, "catch") == [1, 0, 0, 1]
    assert part(arena, "rival_catch") == rival
    assert part(arena, "mate_catch") == mate
    own = [1.0, -0.1, 0.0, 1.0]
    weighted = [sum(at) for at in zip(own, (-0.5 * it for it in rival), (0.25 * it for it in mate), strict=True)]
    assert arena.rewards == pytest.approx(weighted)


@pytest.mark.rule("R11.2")
def test_r11_2_a_shared_reward_is_mixed_with_the_teams_mean() -> None:
    """Own: 0.5, -0.35, -0.25, 0.5 for ((0, 1), (2, 3)); the means are 0.075 and 0.125."""
    for share in (0.0, 0.4, 1.0):
        arena = three_catches(teams=((0, 1), (2, 3)), team_share=share)
        own, means = [0.5, -0.35, -0.25, 0.5], [0.075, 0.075, 0.125, 0.125]
        mixed = [(1 - share) * one + share * mean for one, mean in zip(own, means, strict=True)]
        assert arena.rewards == pytest.approx(mixed)
        assert part(arena, "catch") == [1, 0, 0, 1]


@pytest.mark.rule("R11.2")
def test_r11_2_without_teams_nothing_is_shared() -> None:
    """Whatever team_share says; nor is mate_catch paid."""
    assert three_catches(team_share=1.0).rewards == three_catches().rewards == pytest.approx([0.5, -1.1, -1.0, 0.5])


@pytest.mark.rule("R11.2", "R1.6")
def test_r11_2_who_is_withdrawn_gets_nothing_and_stays_in_the_mean() -> None:
    """Seat 2 is gone: of seat 3's 0.5 its team's mean is a half."""
    arena = quiet(hunters=4, teams=((0, 1), (2, 3)), team_share=1.0, **SHARED)
    arena.withdraw(2)
    arena.place([(2.0, 2.1, 0.0), (2.0, 2.2, 0.0), (8.0, 2.0, 0.0), (5.0, 8.0, 0.0)], [(2.0, 2.0), (5.0, 8.1)])
    arena.step([ASK, ASK, ASK, ASK])
    assert arena.rewards == pytest.approx([0.075, 0.075, 0.0, 0.25])
    assert part(arena, "mate_catch")[2] == part(arena, "rival_catch")[2] == 0


@pytest.mark.rule("R11.1")
def test_r11_1_a_teams_score_is_the_sum_of_its_hunters() -> None:
    """Withdrawn ones count too."""
    arena = three_catches(teams=((1, 2), (3, 0)))
    assert arena.team_scores() == [0, 2]
    arena.withdraw(3)
    assert arena.team_scores() == [0, 2]
    assert three_catches().team_scores() == [1, 0, 0, 1]


@pytest.mark.rule("R11.3")
def test_r11_3_team_mates_contest_a_target_like_anybody() -> None:
    """The rulings are the same, whoever is whose mate."""
    for teams in (None, ((0, 1), (2, 3)), ((0, 2), (1, 3))):
        arena = three_catches(teams=teams)
        assert arena.rulings == [
            (GRANTED, 1, 100_000, 0),
            (LOST_CONTEST, 1, 200_000, 0),
            None,
            (GRANTED, 2, 100_000, 3),
        ]


@pytest.mark.rule("R7.4")
def test_r7_4_the_last_column_of_a_rival_says_whether_it_is_a_mate() -> None:
    """Seat 0 sees 1, 2 and 3 in the order of their distance; without teams there is no such column."""
    poses = [(2.0, 2.0, 0.0), (5.0, 2.0, 0.0), (3.0, 2.0, 0.0), (4.0, 2.0, 0.0)]
    arena, plain = quiet(hunters=4, teams=((0, 3), (1, 2))), quiet(hunters=4)
    for one in (arena, plain):
        one.place(poses, [])
    rows, without = (one.observations()[0][10 + 5 * 8 :] for one in (arena, plain))
    ranked = [rows[at : at + 8] for at in (0, 8, 16)]
    assert [row[0] for row in ranked] == [1.0, 2.0, 3.0]
    assert [row[7] for row in ranked] == [0.0, 1.0, 0.0]
    assert [row[:7] for row in ranked] == [without[at : at + 7] for at in (0, 7, 14)]
    arena.withdraw(3)
    assert arena.observations()[0][10 + 5 * 8 + 16 :] == [0.0] * 8


@pytest.mark.rule("R7.4", "R7.1")
def test_r7_4_of_rivals_that_are_the_same_otherwise_the_mate_comes_first() -> None:
    """At one place, with one heading."""
    arena = quiet(hunters=3, teams=((0, 2), (1,)))
    arena.place([(2.0, 2.0, 0.0), (3.0, 2.0, 0.0), (3.0, 2.0, 0.0)], [])
    rows = arena.observations()[0][10 + 5 * 8 :]
    assert [rows[7], rows[15]] == [1.0, 0.0]


@pytest.mark.rule("R11.1", "R11.2")
@pytest.mark.parametrize("share", [0.0, 0.3])
def test_r11_1_the_order_of_seats_and_teams_changes_nothing(share: float) -> None:
    """In every bit of the state, of what is seen and of what is paid."""
    settings = {"hunters": 5, "initial_targets": 12, "spawn_frequency_hz": 5.0, "team_share": share, "reach_m": 1.0}
    orders = [((0, 3), (1, 4, 2)), ((4, 1, 2), (3, 0)), ((2, 4, 1), (0, 3))]
    arenas = [quiet(teams=teams, control="target", **SHARED, **settings) for teams in orders]
    source, mates = Random(5), 0.0
    for _ in range(60):
        actions = [source.randint(0, 3) for _ in range(5)]
        for arena in arenas:
            arena.step(actions)
            assert arena.digest() == arenas[0].digest()
            assert arena.observations() == arenas[0].observations()
            assert (arena.rewards, arena.parts) == (arenas[0].rewards, arenas[0].parts)
        mates += sum(part(arenas[0], "mate_catch"))
    assert mates > 0
