"""The table of standings has a column for contests lost to team-mates if there are any."""

import pytest
from rich.console import Console
from tournament.played_matches import made_up
from tournament.seats import hunters

from catch_arena.cli.tables import standings_table
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.statistics.outcomes import SideResults
from catch_arena.tournament.statistics.standings import standings

TWO = [Entrant(name, f"{name}.py", "target", "0" * 16) for name in ("nearest", "patrol")]


@pytest.mark.parametrize("to_mates", [(), (5, 0)])
def test_requests_that_team_mates_won_have_a_column_where_there_are_any(capsys, to_mates):
    one = made_up(0, (0, 1), (4, 3), contests_won=(1, 0), contests_lost=(0, 1), lost_to_mates=to_mates)
    table = standings_table(standings(SideResults.of(TWO, [one], hunters(2))))
    Console(width=80, force_terminal=False).print(table)
    shown = capsys.readouterr().out
    head, *lines = (line.split() for line in shown.strip().splitlines())
    assert ("mates" in head) == ("mates: requests per match lost to a team-mate" in shown) == bool(to_mates)
    if to_mates:
        assert [line[-1] for line in lines if line[:1] in (["1"], ["2"])] == ["5.0", "0.0"]
