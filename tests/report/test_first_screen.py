"""The first screen of a report: its figures agree with the replays, and the best moment is that of `highlights`."""

from report.synthetic import tournament

from catch_arena.explanation import explain
from catch_arena.explanation.formatting import millimetres
from catch_arena.explanation.highlights import best_highlights, find_highlights
from catch_arena.report.charts import figures
from catch_arena.report.data import ReportData


def test_the_figures_are_those_of_the_replays(played):
    data = ReportData.of(played)
    replays = {match: data.replay(match) for match in data.recorded}
    contests = [contest for replay in replays.values() for contest in explain(replay).contests]
    assert contests
    found = figures(data, {match: explain(replay) for match, replay in replays.items()})
    closest = min(contest.margin_um for contest in contests if contest.clause == "R5.4")
    assert [(figure.name, figure.value, figure.note) for figure in found] == [
        ("Matches played", "4", ""),
        ("Contests decided", str(len(contests)), ""),
        ("Closest contest", millimetres(closest), ""),
    ]


def test_the_closest_contest_says_in_how_many_matches_and_gives_way_to_catches_without_replays(played, tmp_path):
    data = ReportData.of(played)
    events = {match: explain(data.replay(match)) for match in data.recorded}
    few = dict(match for match in events.items() if len(match[1].contests))
    few.pop(max(few))
    assert figures(data, few)[2].note == f"in {len(few)} matches"
    tournament(tmp_path, 1, most=8)
    data = ReportData.of(tmp_path)
    catches = sum(sum(one.result.scores) for one in data.played)
    first, _, last = figures(data, {})
    assert (first.value, first.note) == ("8", "of 60")
    assert (last.name, last.value) == ("Catches", str(catches))


def test_the_best_moment_is_the_best_highlight(played):
    data = ReportData.of(played)
    events = {match: explain(data.replay(match)) for match in sorted(data.recorded)}
    ((match, moment),) = best_highlights(events, 1)
    best = max(highlight.score for one in events.values() for highlight in find_highlights(one))
    assert moment.score >= best
    assert moment in find_highlights(events[match])
    assert best_highlights({}, 1) == []
