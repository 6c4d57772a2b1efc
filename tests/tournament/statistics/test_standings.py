"""Standings equal numbers that were worked out by hand."""

import csv
import io
import json
import math

import pytest
from tournament.played_matches import made_up
from tournament.seats import hunters

from catch_arena import scenario
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.export import summary_text, table_text
from catch_arena.tournament.match import PlayedMatch
from catch_arena.tournament.secret import Secret
from catch_arena.tournament.statistics.outcomes import SideResults
from catch_arena.tournament.statistics.standings import Standing, standings
from catch_arena.tournament.store import Tournament

A, B = (Entrant(name, f"{name}.py", "target", "0" * 16) for name in "ab")
DUEL = Tournament(scenario("duel"), (A, B), {"format": "round-robin", "rounds": 2}, seed="3")


def played(
    block: int, turn: int, seating: tuple[int, int], scores: tuple[int, int], lost: int = 0, code: str | None = None
) -> PlayedMatch:
    first, second = ({"GRANTED": score} for score in scores)
    if lost:
        first |= {"LOST_CONTEST": lost, "OUT_OF_REACH": 1}
    parts = {"verdicts": (first, second), "contests_won": (1, lost), "contests_lost": (lost, 0)}
    return made_up(block, seating, scores, turn, forfeits=(code, None), **parts)


def table_of(entrants: list[Entrant], matches: list[PlayedMatch]) -> list[Standing]:
    return standings(SideResults.of(entrants, matches, hunters(2)))


FOUR = [
    played(0, 0, (0, 1), (10, 4), lost=3),
    played(0, 1, (1, 0), (6, 6)),
    played(1, 0, (0, 1), (8, 9)),
    played(1, 1, (1, 0), (5, 12)),
]


def test_means_by_hand():
    first, second = table_of([A, B], FOUR)
    assert (first.place, first.name, first.matches) == (1, "a", 4)
    assert first.score.mean == (10 + 6 + 8 + 12) / 4
    assert second.score.mean == (4 + 6 + 9 + 5) / 4
    # a wins two, shares one
    assert (first.win_share.mean, second.win_share.mean) == (2.5 / 4, 1.5 / 4)
    assert (first.mean_rank, second.mean_rank) == (5 / 4, 6 / 4)
    assert (first.contests_lost, first.refused) == (3 / 4, 1 / 4)


def test_contests_refusals_and_forfeits_by_hand():
    first, second = table_of([A, B], [*FOUR, played(2, 0, (0, 1), (1, 2), code="FORFEIT_CRASH")])
    assert (first.name, second.name) == ("a", "b")
    # a sat in seat 0 in three of the five, where it won one contest each, and elsewhere as many as the other lost
    assert first.contest_win_share == (1 + 0 + 1 + 0 + 1) / (3 + 3)
    assert second.contest_win_share == (3 + 1 + 0 + 1 + 0) / (5 + 0)
    assert (first.refusals, second.refusals) == ({"OUT_OF_REACH": 1 / 5}, {})
    assert (first.forfeits, second.forfeits) == ({"FORFEIT_CRASH": 1}, {})


def test_the_middle_half_of_the_matches_by_hand():
    """The two lowest and the two highest of eight scores are cut off."""
    scores = (0, 1, 4, 5, 6, 7, 20, 90)
    first, _ = table_of([A, B], [played(block, 0, (0, 1), (score, 0)) for block, score in enumerate(scores)])
    assert first.iqm.mean == (4 + 5 + 6 + 7) / 4
    assert first.iqm.low < first.iqm.mean < first.iqm.high < first.score.high


def test_nobody_wins_a_match_that_all_have_forfeited():
    """The one that lasted longer is above the other all the same."""
    lost = [made_up(block, (0, 1), (3, 0), forfeits=("FORFEIT_CRASH",) * 2) for block in range(4)]
    first, second = table_of([A, B], lost)
    assert (first.name, first.win_share.mean, second.win_share.mean) == ("a", 0.0, 0.0)
    assert first.rating.mean > second.rating.mean


def test_too_few_blocks_give_no_interval():
    for blocks in (1, 2, 3):
        for step in (1, 0):
            first, _ = table_of([A, B], [played(block, 0, (0, 1), (10 + step * block, 1)) for block in range(blocks)])
            assert math.isnan(first.score.low)
            assert math.isnan(first.win_share.low)
    table = table_of([A, B], FOUR[:2])
    assert "null" in summary_text(DUEL, 2, {"hunter": table})


def test_equal_scores_share_a_place_and_who_did_not_play_is_not_in_the_table():
    lines = table_of([A, B, Entrant("c", "c.py", "target", "1" * 16)], [played(0, 0, (0, 1), (3, 3))])
    assert [(line.place, line.name) for line in lines] == [(1, "a"), (1, "b")]


def test_the_files_hold_what_the_standings_say():
    table = table_of([A, B], FOUR)
    rows = list(csv.DictReader(io.StringIO(table_text(table))))
    assert [(row["agent"], float(row["score"])) for row in rows] == [("a", 9.0), ("b", 6.0)]
    summary = json.loads(summary_text(DUEL, 4, {"hunter": table}))
    assert (summary["seed"], summary["matches"], summary["config"]["hunters"]) == (Secret.of(3).digits, 4, 2)
    first = summary["standings"][0]
    assert (first["group"], first["score"], first["score_low"]) == ("1", 9.0, None)
    assert first["rating"] == pytest.approx(-summary["standings"][1]["rating"])
    assert first["rating"] > 0
    assert first["rating_high"] is None
    assert (first["refusals"], first["forfeits"]) == ({"OUT_OF_REACH": 0.25}, {})
