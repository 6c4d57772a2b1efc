"""Chapter 6, score and reward: every clause on every adjudicator."""

import dataclasses
import math

import pytest
from rulebook.conftest import ArenaFactory

from catch_arena.config import RewardWeights
from catch_arena.tournament.match import ranks_of
from catch_arena.verdicts import Verdict

CATCH, RIVAL_CATCH, LOST_CONTEST, REJECTED, PROGRESS, TIME = range(6)
STILL = (0.0, 0.0)


@pytest.mark.rule("R6.1")
def test_r6_1_the_score_is_the_number_of_granted_catches(arena: ArenaFactory) -> None:
    """Refused requests add nothing, and the score is in the observation."""
    match = arena(control="full", hunters=2)
    match.place(hunters=[(5.0, 5.0, 0.0), (1.0, 1.0, 0.0)], targets=[(5.1, 5.0), (5.0, 5.1), (4.9, 5.0)])
    for catches in range(1, 4):
        match.step((STILL, 1), (STILL, 1))
        assert match.verdicts == [Verdict.GRANTED, Verdict.OUT_OF_REACH]
        assert match.scores == [catches, 0]
        assert match.own(0)["score"] == catches
        assert match.own(1)["score"] == 0.0


@pytest.mark.rule("R6.1")
@pytest.mark.parametrize(
    ("scores", "ranks"),
    [((3,), (1,)), ((5, 7), (2, 1)), ((4, 4, 1), (1, 1, 3)), ((0, 2, 2, 5), (4, 2, 2, 1)), ((0, 0, 0), (1, 1, 1))],
)
def test_r6_1_a_match_is_ranked_by_score_and_equal_scores_share_a_rank(
    scores: tuple[int, ...], ranks: tuple[int, ...]
) -> None:
    """Whatever the seats: one's rank is one more than the number of hunters with more."""
    assert ranks_of(scores) == ranks


@pytest.mark.rule("R6.2")
def test_r6_2_by_default_a_catch_is_worth_one_and_nothing_else_counts(arena: ArenaFactory) -> None:
    """The weights of the book's table."""
    assert dataclasses.astuple(RewardWeights()) == (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    match = arena(control="full", hunters=3)
    match.place(hunters=[(5.0, 5.0, 0.0), (5.2, 5.0, 0.0), (1.0, 1.0, 0.0)], targets=[(5.0, 5.0)])
    match.step((STILL, 1), (STILL, 1), (STILL, 1))
    assert match.rewards == [1.0, 0.0, 0.0]


@pytest.mark.rule("R6.2")
def test_r6_2_every_part_is_reported_unweighted(arena: ArenaFactory) -> None:
    """A winner, a loser, one out of reach, one with a rank that has no target, and one that does not ask."""
    weights = {"catch": 2.0, "rival_catch": -0.25, "lost_contest": -3.0, "rejected_request": -5.0, "time": -0.5}
    match = arena(control="full", hunters=5, rewards=weights)
    match.place(
        hunters=[(5.0, 5.0, 0.0), (5.2, 5.0, 0.0), (1.0, 1.0, 0.0), (2.0, 2.0, 0.0), (3.0, 3.0, 0.0)],
        targets=[(5.0, 5.0)],
    )
    match.step((STILL, 1), (STILL, 1), (STILL, 1), (STILL, 2), (STILL, 0))
    assert match.verdicts == [
        Verdict.GRANTED,
        Verdict.LOST_CONTEST,
        Verdict.OUT_OF_REACH,
        Verdict.MALFORMED,
        None,
    ]
    assert match.parts == [
        (1.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0),
        (0.0, 1.0, 1.0, 0.0, 0.0, 0.1, 0.0),
        (0.0, 1.0, 0.0, 1.0, 0.0, 0.1, 0.0),
        (0.0, 1.0, 0.0, 1.0, 0.0, 0.1, 0.0),
        (0.0, 1.0, 0.0, 0.0, 0.0, 0.1, 0.0),
    ]
    assert match.rewards == pytest.approx([1.95, -3.3, -5.3, -5.3, -0.3], abs=1e-15)


@pytest.mark.rule("R6.2")
def test_r6_2_progress_is_towards_the_target_that_was_nearest_after_the_commit(arena: ArenaFactory) -> None:
    """The caught target does not count, and passing another one on the way does not either."""
    match = arena(control="full", rewards={"catch": 0.0, "progress": 10.0})
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(5.0, 5.0), (5.0, 6.0), (7.0, 5.0)])
    match.step(((1.0, 0.0), 1))
    assert match.verdicts == [Verdict.GRANTED]
    driven = match.hunter().x - 5.0
    expected = 1.0 - math.hypot(driven, 1.0)
    assert expected < 0
    assert match.parts[0][PROGRESS] == pytest.approx(expected, abs=1e-12)
    assert match.rewards[0] == pytest.approx(10 * expected, abs=1e-11)


@pytest.mark.rule("R6.2")
def test_r6_2_who_leaves_the_place_of_a_target_loses_the_way(arena: ArenaFactory) -> None:
    """A distance of zero is one: it is not as if there were no target."""
    match = arena(control="full")
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(5.0, 5.0)])
    match.step(((1.0, 0.0), 0))
    assert match.hunter().x > 5.1
    assert match.parts[0][PROGRESS] == pytest.approx(5.0 - match.hunter().x, abs=1e-12)


@pytest.mark.rule("R6.2")
def test_r6_2_without_a_target_there_is_no_progress(arena: ArenaFactory) -> None:
    """Also when the timer fires in the same step: what appears after the motion was no aim."""
    match = arena(control="full", spawn_frequency_hz=10.0)
    match.step(((1.0, 0.5), 0))
    assert match.alive == [1]
    assert match.parts[0][PROGRESS] == 0.0
    match.step(((1.0, 0.5), 0))
    assert match.parts[0][PROGRESS] != 0.0


@pytest.mark.rule("R6.2")
@pytest.mark.parametrize("hunters", [2, 3, 5])
def test_r6_2_with_rival_catches_at_minus_one_over_the_others_the_game_is_zero_sum(
    arena: ArenaFactory, hunters: int
) -> None:
    """Up to rounding, with one catch and with several in one step."""
    match = arena(control="full", hunters=hunters, rewards={"rival_catch": -1.0 / (hunters - 1)})
    poses = [(1.0 + 2.0 * seat, 5.0, 0.0) for seat in range(hunters)]
    match.place(hunters=poses, targets=[(x, y) for x, y, _ in poses[:2]])
    match.step(*((STILL, 1) for _ in range(hunters)))
    assert sum(part[CATCH] for part in match.parts) == 2.0
    assert sum(match.rewards) == pytest.approx(0.0, abs=1e-12)
    match.reset(1)
    match.place(hunters=poses, targets=[poses[0][:2]])
    match.step(*((STILL, 1) for _ in range(hunters)))
    assert match.rewards[0] == 1.0
    assert sum(match.rewards) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.rule("R6.2")
@pytest.mark.parametrize("period", [16, 250, 1500])
def test_r6_2_the_part_of_time_is_the_seconds_that_passed(arena: ArenaFactory, period: int) -> None:
    """The control period, in seconds."""
    match = arena(control_period_ms=period, rewards={"time": -2.0})
    match.hold()
    assert match.parts[0][TIME] == period / 1000
    assert match.rewards[0] == -2.0 * period / 1000
