"""The table that is shown while a tournament runs."""

import io

from rich.console import Console

from catch_arena import scenario
from catch_arena.cli import progress
from catch_arena.cli.live_standings import LiveStandings
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.execution.runner import run
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import round_robin


def test_a_terminal_is_shown_the_standings_and_how_far_it_is():
    entrants, plan, shown, now = enter(["nearest", "idle"]), round_robin(2, 2, 4, 0), io.StringIO(), [0.0]
    console = Console(file=shown, force_terminal=True, width=80, height=40)
    played = run(scenario("duel", time_limit_s=3), entrants, plan)
    with LiveStandings(
        entrants, Parties.of(scenario("duel")), len(plan), console=console, clock=lambda: now[0]
    ) as live:
        live.update(played[:2])
        assert "nearest" not in shown.getvalue()  # not at once: the first second shows the bar alone
        now[0] = 2.0
        live.update(played[2:])
    assert "nearest" in shown.getvalue()
    assert "8/8" in shown.getvalue()


def test_a_file_is_told_every_five_seconds_how_far_it_is(monkeypatch):
    monkeypatch.setattr(progress, "_LINE_EVERY_S", 5.0)
    entrants, plan, told, now = enter(["nearest", "idle"]), round_robin(2, 2, 4, 0), io.StringIO(), [0.0]
    played = run(scenario("duel", time_limit_s=3), entrants, plan)
    with LiveStandings(
        entrants, Parties.of(scenario("duel")), len(plan), console=Console(file=told), clock=lambda: now[0]
    ) as live:
        for one, now[0] in zip(played, (1.0, 6.0, 7.0, 10.0, 11.0, 15.0, 20.0, 21.0), strict=True):
            live.update([one])
    assert told.getvalue().splitlines() == [
        f"playing: {line} s left" for line in ("2 of 8, 6 s, some 18", "5 of 8, 11 s, some 7", "7 of 8, 20 s, some 3")
    ]
