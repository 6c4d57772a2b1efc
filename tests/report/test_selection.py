"""A report chooses matches with contests between teams, not within a team."""

from pathlib import Path

from catch_arena import scenario
from catch_arena.report import selection
from catch_arena.report.data import ReportData
from catch_arena.tournament.match import Match, MatchResult, MoveTimes, PlayedMatch
from catch_arena.tournament.players import enter
from catch_arena.tournament.store import Tournament


def test_contests_among_team_mates_make_no_match_interesting(monkeypatch):
    monkeypatch.setattr(selection, "bundle_text", str)
    monkeypatch.setattr(selection, "explain", str)
    monkeypatch.setattr(ReportData, "replay", lambda _, match: match)

    def played(name: str, lost: tuple[int, int], to_mates: tuple[int, int]) -> PlayedMatch:
        verdicts = tuple({"LOST_CONTEST": one + own} for one, own in zip(lost, to_mates, strict=True))
        times = (MoveTimes(9, 0.1, 0.1),) * 2
        result = MatchResult(
            (2, 1), (1, 2), verdicts, lost[::-1], lost, 9, "", (None,) * 2, times, lost_to_mates=to_mates
        )
        return PlayedMatch(Match(name, 0, 0, (0, 1)), result, "00")

    tournament = Tournament(scenario("pairs"), enter(["nearest", "patrol"]), {}, "0")
    matches = [played("among_mates", (0, 1), (9, 9)), played("between_teams", (1, 2), (0, 0))]
    found = selection.select_matches(ReportData(Path(), tournament, 2, matches, [], True), 10**6)
    assert found["between_teams"].why == "contests"
