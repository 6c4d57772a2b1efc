"""Contests that agents lost, and what would have won them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from catch_arena.explanation.facts import Contest
from catch_arena.explanation.highlights import Highlight, has_loser
from catch_arena.explanation.match_summary import Explanation
from catch_arena.explanation.sentences import margin_phrase
from catch_arena.explanation.what_if import WhatIf, what_if
from catch_arena.report.data import ReportData

MOST_ANSWERS: Final = 8
"""Greatest number of answers in a report, since each takes up to some seconds to find."""


@dataclass(frozen=True, slots=True)
class LostContest:
    """Contest that an agent lost, and the answer."""

    agent: str
    winner: str
    reason: str
    """Margin of the winner, such as "by 11 mm", or "by lot"."""
    match: str
    answer: WhatIf


def find_lost_contests(data: ReportData, explanations: Mapping[str, Explanation]) -> list[LostContest]:
    """Return for each agent the closest contest that it lost in some matches, the closest of all first."""
    players = {one.match.id: [data.names[entrant] for entrant in one.match.seating] for one in data.played}
    party = data.tournament.config.team_by_seat
    lost = [(match, contest) for match, one in explanations.items() for contest in filter(has_loser, one.contests)]
    closest: dict[str, tuple[str, Contest]] = {}
    for match, contest in sorted(lost, key=lambda one: one[1].margin_um or 0):
        closest.setdefault(players[match][party[contest.claims[1].seat]], (match, contest))
    found = []
    for loser, (match, contest) in list(closest.items())[:MOST_ANSWERS]:
        winner = players[match][party[contest.claims[0].seat]]
        answer = what_if(data.replay(match), contest)
        found.append(LostContest(loser, winner, margin_phrase(contest), match, answer))
    return found


def answer_to(moment: tuple[str, Highlight] | None, lost: Sequence[LostContest]) -> WhatIf | None:
    """Return the answer to the contest that a moment shows; None without one."""
    if moment is None or moment[1].kind != "contest":
        return None
    shown = moment[0], moment[1].decisive_ms
    return next((one.answer for one in lost if (one.match, one.answer.contest.judged_ms) == shown), None)
