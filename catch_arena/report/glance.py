"""First screen of the report: three figures, and the best moment."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from catch_arena.explanation.formatting import exact_length
from catch_arena.explanation.highlights import Highlight, best_highlights
from catch_arena.explanation.match_summary import Explanation
from catch_arena.report.charts import number
from catch_arena.report.data import ReportData


class Figure(NamedTuple):
    """A figure, its name, and a note after it."""

    name: str
    value: str
    note: str = ""


@dataclass(frozen=True, slots=True)
class Moment:
    """Best highlight of a tournament, and its match."""

    match: str
    highlight: Highlight
    end_ms: int
    """Last instant that is shown, which a match has [ms since reset]."""


def figures(data: ReportData, explanations: Mapping[str, Explanation]) -> list[Figure]:
    """Return the figures of the first screen: all matches and contests, and the closest contest explained."""
    played, hunting = len(data.played), data.parties.hunting
    of_plan = f"of {number(data.planned)}" if data.planned > played else ""
    contests = sum(sum(one.result.contests_won[:hunting]) for one in data.played)
    margins = [
        contest.margin_um
        for match in explanations.values()
        for contest in match.contests
        if contest.clause == "R5.4" and contest.margin_um is not None and not contest.claims[1].mate
    ]
    among = "" if len(explanations) == played else f"in {number(len(explanations))} matches"
    catches = sum(sum(one.result.scores[:hunting]) for one in data.played)
    return [
        Figure("Matches played", number(played), of_plan),
        Figure("Contests decided", number(contests)),
        Figure("Closest contest", exact_length(min(margins)), among) if margins else Figure("Catches", number(catches)),
    ]


def best_moment(explanations: Mapping[str, Explanation]) -> Moment | None:
    """Return the best highlight of some matches; None if they have none."""
    for match, highlight in best_highlights(explanations, 1):
        return Moment(match, highlight, min(highlight.end_ms, explanations[match].duration_ms))
    return None
