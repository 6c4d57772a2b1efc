"""A tournament with `--until-separated` ends after whole rounds, as soon as the order is clear.

tests/cli/test_commands.py has a budget that is spent before that.
"""

import pytest
from tournament.runs import run
from tournament.seats import hunters

from catch_arena import scenario
from catch_arena.errors import ConfigError
from catch_arena.tournament.plans.schedule import UntilSeparated, round_robin
from catch_arena.tournament.players import enter


def test_it_ends_when_the_order_is_clear_after_whole_rounds():
    entrants = enter(["nearest", "random", "idle"])
    plan = UntilSeparated(round_robin(3, hunters(2), 500, 1), entrants, hunters(2), 0.95)
    played = run(scenario("duel", time_limit_s=10), entrants, plan)
    assert plan.last.clear
    assert len(played) < plan.size == 3000
    assert len(played) % 6 == 0
    assert [one.match for one in played] == list(round_robin(3, hunters(2), len(played) // 6, 1))
    assert len(list(next(plan.stages(list)))) == 9  # blocks before the first look, which needs 8: three rounds


def test_entrants_that_never_meet_cannot_be_separated():
    entrants = enter(["nearest", "idle"])
    with pytest.raises(ConfigError, match="until_separated needs at least 2 hunters or teams in a match, got 1"):
        UntilSeparated(round_robin(2, hunters(1), 9, 1), entrants, hunters(1), 0.9)
