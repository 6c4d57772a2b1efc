"""Chapter 11, teams: every clause on every adjudicator."""

from typing import Any

import pytest
from oracle.arena import PART_NAMES
from oracle.arithmetic import TIE_LOT, draw, key
from rulebook.adjudicators import Adjudicator
from rulebook.conftest import ArenaFactory

from catch_arena.verdicts import Verdict

ASK = ((0.0, 0.0), 1)
"""Requests the nearest target, at rest."""
HOLD = ((0.0, 0.0), 0)
WEIGHTS = {"catch": 1.0, "rival_catch": -0.5, "lost_contest": -0.1, "mate_catch": 0.25}


def three_catches(arena: ArenaFactory, **settings: Any) -> Adjudicator:
    """After a step in which seats 0 and 3 catch a target each, and seat 1 loses seat 0's; seat 2 holds."""
    match = arena(control="full", hunters=4, rewards=WEIGHTS, **settings)
    ask_for_two(match)
    return match


def ask_for_two(match: Adjudicator, withdraw: int | None = None) -> None:
    match.place(
        hunters=[(2.0, 2.1, 0.0), (2.0, 2.2, 0.0), (8.0, 2.0, 0.0), (5.0, 8.0, 0.0)], targets=[(2.0, 2.0), (5.0, 8.1)]
    )
    if withdraw is not None:
        match.withdraw(withdraw)
    match.step(ASK, ASK, HOLD, ASK)


def part(match: Adjudicator, name: str) -> list[float]:
    """One part of the reward, by seat."""
    return [parts[PART_NAMES.index(name)] for parts in match.parts]


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
def test_r11_2_a_catch_is_a_mates_or_a_rivals(
    arena: ArenaFactory, teams: Any, rival: list[float], mate: list[float]
) -> None:
    """Every grant counts once for everybody: as one's own, a mate's, or a rival's."""
    match = three_catches(arena, teams=teams)
    assert part(match, "catch") == [1, 0, 0, 1]
    assert part(match, "rival_catch") == rival
    assert part(match, "mate_catch") == mate
    own = [1.0, -0.1, 0.0, 1.0]
    weighted = [sum(at) for at in zip(own, (-0.5 * it for it in rival), (0.25 * it for it in mate), strict=True)]
    assert match.rewards == pytest.approx(weighted)


@pytest.mark.rule("R11.2")
@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_r11_2_a_shared_reward_is_mixed_with_the_teams_mean(arena: ArenaFactory, share: float) -> None:
    """Own: 0.5, -0.35, -0.25, 0.5 for ((0, 1), (2, 3)); the means are 0.075 and 0.125. Parts are the hunter's own."""
    match = three_catches(arena, teams=((0, 1), (2, 3)), team_share=share)
    own, means = [0.5, -0.35, -0.25, 0.5], [0.075, 0.075, 0.125, 0.125]
    assert match.rewards == pytest.approx(
        [(1 - share) * one + share * mean for one, mean in zip(own, means, strict=True)]
    )
    assert part(match, "catch") == [1, 0, 0, 1]


@pytest.mark.rule("R11.2", "R1.6")
def test_r11_2_who_is_withdrawn_gets_nothing_and_stays_in_the_mean(arena: ArenaFactory) -> None:
    """Seat 2 is gone: of seat 3's 0.5 its team's mean is a half."""
    match = arena(control="full", hunters=4, teams=((0, 1), (2, 3)), team_share=1.0, rewards=WEIGHTS)
    ask_for_two(match, withdraw=2)
    assert match.rewards == pytest.approx([0.075, 0.075, 0.0, 0.25])
    assert part(match, "mate_catch")[2] == part(match, "rival_catch")[2] == 0


@pytest.mark.rule("R11.1")
def test_r11_1_a_teams_score_is_the_sum_of_its_hunters(arena: ArenaFactory) -> None:
    """Withdrawn ones count too; without teams everybody is a team."""
    match = three_catches(arena, teams=((1, 2), (3, 0)))
    assert match.team_scores == [0, 2]
    match.withdraw(3)
    assert match.team_scores == [0, 2]
    assert three_catches(arena).team_scores == [1, 0, 0, 1]


@pytest.mark.rule("R11.3")
@pytest.mark.parametrize("teams", [None, ((0, 1), (2, 3)), ((0, 2), (1, 3))])
def test_r11_3_team_mates_contest_a_target_like_anybody(arena: ArenaFactory, teams: Any) -> None:
    """The rulings are the same, whoever is whose mate."""
    match = three_catches(arena, teams=teams)
    assert match.evidence() == [
        (Verdict.GRANTED, 1, 100_000, 0),
        (Verdict.LOST_CONTEST, 1, 200_000, 0),
        None,
        (Verdict.GRANTED, 2, 100_000, 3),
    ]


@pytest.mark.rule("R11.3", "R5.5")
@pytest.mark.parametrize("tied", [(0, 1), (0, 1, 2)], ids=["two mates", "two mates and a rival"])
def test_r11_3_a_tie_of_team_mates_is_drawn_by_lot(arena: ArenaFactory, tied: tuple[int, ...]) -> None:
    """The lowest lot of a seat wins, as between rivals. Its mate has lost like a rival, and is paid for
    a mate's catch.
    """
    third = (4.9 if 2 in tied else 4.8, 5.0, 0.0)
    winners = set()
    for seed in range(10):
        match = arena(control="full", hunters=3, teams=((1, 0), (2,)), rewards=WEIGHTS, seed=seed)
        match.place(hunters=[(5.1, 5.0, 0.0), (5.0, 5.1, 0.0), third], targets=[(5.0, 5.0)])
        match.step(ASK, ASK, ASK)
        lots = {seat: draw(draw(draw(key(seed, TIE_LOT), 0), 1), seat) for seat in tied}
        winner = min(lots, key=lots.__getitem__)
        for seat, found in enumerate(match.evidence()):
            verdict = Verdict.GRANTED if seat == winner else Verdict.LOST_CONTEST
            assert found == (verdict, 1, 100_000 if seat in tied else 200_000, winner)
        assert match.team_scores == [int(winner != 2), int(winner == 2)]
        assert part(match, "mate_catch") == [int((seat, winner) in {(0, 1), (1, 0)}) for seat in range(3)]
        winners.add(winner)
    assert winners == set(tied)


@pytest.mark.rule("R7.4")
def test_r7_4_the_last_column_of_a_rival_says_whether_it_is_a_mate(arena: ArenaFactory) -> None:
    """Seat 0 sees 1, 2 and 3 in the order of their distance; without teams there is no such column."""
    seen = []
    for teams in (((0, 3), (1, 2)), None):
        match = arena(control="full", hunters=4, teams=teams)
        match.place(hunters=[(2.0, 2.0, 0.0), (5.0, 2.0, 0.0), (3.0, 2.0, 0.0), (4.0, 2.0, 0.0)])
        match.look()
        width = 7 if teams is None else 8
        rows = match.observation(0)[10 + 5 * 8 :]
        assert len(rows) == 3 * width
        seen.append([rows[at : at + width] for at in range(0, len(rows), width)])
    assert [row[0] for row in seen[0]] == [1.0, 2.0, 3.0]
    assert [row[7] for row in seen[0]] == [0.0, 1.0, 0.0]
    assert [row[:7] for row in seen[0]] == seen[1]


@pytest.mark.rule("R7.4", "R7.1")
def test_r7_4_of_rivals_that_are_the_same_otherwise_the_mate_comes_first(arena: ArenaFactory) -> None:
    """At one place, with one heading."""
    match = arena(control="full", hunters=3, teams=((0, 2), (1,)))
    match.place(hunters=[(2.0, 2.0, 0.0), (3.0, 2.0, 0.0), (3.0, 2.0, 0.0)])
    match.look()
    rows = match.observation(0)[10 + 5 * 8 :]
    assert [rows[7], rows[15]] == [1.0, 0.0]
