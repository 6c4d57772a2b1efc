"""Head-to-head wins, ties and shares equal numbers that were worked out by hand."""

import math

import pytest
from tournament.played_matches import made_up
from tournament.seats import hunters

from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.statistics.head_to_head import head_to_head
from catch_arena.tournament.statistics.outcomes import SideResults

FOUR = [Entrant(name, f"{name}.py", "target", "0" * 16) for name in "abcd"]


def encounters(played):
    return head_to_head(SideResults.of(FOUR, played, hunters(2)))


TABLE = encounters([made_up(0, (0, 1), (3, 1)), made_up(1, (1, 0), (4, 4)), made_up(2, (2, 0), (2, 9))])


def test_only_those_who_played_are_there():
    assert set(TABLE) == {(one, other) for one in "abc" for other in "abc" if one != other}


def test_wins_ties_and_shares():
    assert [(TABLE[pair].matches, TABLE[pair].wins, TABLE[pair].ties) for pair in (("a", "b"), ("b", "a"))] == [
        (2, 1, 1),
        (2, 0, 1),
    ]
    assert (TABLE["a", "b"].share.mean, TABLE["b", "a"].share.mean) == (0.75, 0.25)
    assert (TABLE["b", "c"].matches, TABLE["a", "c"].wins) == (0, 1)
    assert math.isnan(TABLE["b", "c"].share.mean)


def test_the_probability_of_improvement_needs_no_meeting():
    """A had 3, 4, 9; b had 1, 4; c had 2: of six pairs of matches a is above b in four, and ties one."""
    assert TABLE["a", "b"].improvement == pytest.approx((1 + 1.5 + 2) / 6)
    assert TABLE["b", "a"].improvement == pytest.approx(1.5 / 6)
    assert TABLE["b", "c"].improvement == 0.5


def test_the_interval_holds_its_share_and_stays_in_bounds():
    many = [made_up(block, (0, 1), (3, 1 if block % 5 else 5)) for block in range(60)]
    first, second = encounters(many).values()
    assert 0.65 < first.share.low < 0.8 < first.share.high < 0.95
    assert second.share.low == pytest.approx(1 - first.share.high)
    (sure, _) = encounters([made_up(block, (0, 1), (3, 1)) for block in range(60)]).values()
    assert (sure.share.mean, sure.share.high) == (1.0, 1.0)
    assert 0.9 < sure.share.low < 0.99
