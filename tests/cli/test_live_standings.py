"""The table that a terminal shows while a tournament runs, and the lines that a file gets instead."""

import io

import pytest
from rich.console import Console
from tournament.seats import hunters

from catch_arena import scenario
from catch_arena.cli import progress
from catch_arena.cli.live_standings import LiveStandings
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.execution.runner import run
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import round_robin

CONFIG = scenario("duel", time_limit_s=3)
ENTRANTS, PLAN = enter(["nearest", "idle"]), round_robin(2, hunters(2), 4, 0)


@pytest.fixture(scope="module")
def played():
    return run(CONFIG, ENTRANTS, PLAN)


def shown_at(console, played, times):
    """Yield after each of these times [s], at which one more match has been played."""
    now = [0.0]
    with LiveStandings(ENTRANTS, Parties.of(CONFIG), len(PLAN), console=console, clock=lambda: now[0]) as live:
        for one, now[0] in zip(played, times, strict=True):
            live.played([one])
            yield now[0]


def test_a_terminal_is_shown_the_standings_and_how_far_it_is(played):
    shown = io.StringIO()
    console = Console(file=shown, force_terminal=True, width=80, height=40)
    for time in shown_at(console, played, [0.0] * 2 + [2.0] * 6):
        assert time or "nearest" not in shown.getvalue()  # the first second shows the bar alone
    assert "nearest" in shown.getvalue()
    assert "8/8" in shown.getvalue()


def test_a_file_is_told_every_five_seconds_how_far_it_is(played, monkeypatch):
    monkeypatch.setattr(progress, "_LINE_EVERY_S", 5.0)
    told = io.StringIO()
    list(shown_at(Console(file=told), played, (1.0, 6.0, 7.0, 10.0, 11.0, 15.0, 20.0, 21.0)))
    assert told.getvalue().splitlines() == [
        f"playing: {line} s left" for line in ("2 of 8, 6 s, some 18", "5 of 8, 11 s, some 7", "7 of 8, 20 s, some 3")
    ]
