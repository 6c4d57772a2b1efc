"""A tournament with `--until-separated` ends after whole rounds, when the order is clear or the budget is spent."""

import pytest
from tournament.runs import run
from tournament.seats import hunters

from catch_arena import scenario
from catch_arena.errors import ConfigError
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.plans.schedule import UntilSeparated, round_robin

SHORT = scenario("duel", time_limit_s=4)
CLEAR = enter(["nearest", "random", "idle"])
EQUAL = enter(["nearest", "nearest", "idle"])


def plan(entrants, budget, seed=1):
    return UntilSeparated(round_robin(3, hunters(2), budget // 6, seed), entrants, hunters(2), 0.95)


def test_it_ends_when_the_order_is_clear_after_whole_rounds():
    plays = plan(CLEAR, 3000)
    played = run(scenario("duel", time_limit_s=10), CLEAR, plays)
    assert plays.last.clear
    assert len(played) < plays.size == 3000
    assert len(played) % 6 == 0
    assert [one.match for one in played] == list(round_robin(3, hunters(2), len(played) // 6, 1))


def test_it_ends_when_the_budget_is_spent_and_says_who_is_not_apart():
    plays = plan(EQUAL, 65)
    assert len(run(SHORT, EQUAL, plays)) == plays.size == 60
    assert not plays.last.clear
    assert set(plays.last.pair) == {"nearest", "nearest#2"}
    assert "are not yet significantly different (p = " in str(plays.last)


def test_what_cannot_be_is_refused():
    with pytest.raises(ConfigError, match="confidence must lie in"):
        UntilSeparated(round_robin(3, hunters(2), 9, 1), EQUAL, hunters(2), 1.0)
