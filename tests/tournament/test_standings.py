"""The standings against numbers worked out by hand."""

import csv
import io
import json
import math

import pytest

from catch_arena import scenario
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import MatchResult, ranks_of
from catch_arena.tournament.results import results_text, summary_text, table_text
from catch_arena.tournament.runner import Played
from catch_arena.tournament.schedule import Match
from catch_arena.tournament.standings import standings

A, B = (Entrant(name, f"{name}.py", "target", "0" * 16) for name in "ab")


def played(block: int, turn: int, seating: tuple[int, int], scores: tuple[int, int], lost: int = 0) -> Played:
    verdicts = tuple(
        {"GRANTED": score} | ({"LOST_CONTEST": lost, "OUT_OF_REACH": 1} if seat == 0 and lost else {})
        for seat, score in enumerate(scores)
    )
    return Played(
        Match(f"r00001-g{block + 1:06d}-s{turn:02d}", block, 7 + block, seating),
        MatchResult(scores, ranks_of(scores), verdicts, 600, "ab"),
    )


FOUR = [
    played(0, 0, (0, 1), (10, 4), lost=3),
    played(0, 1, (1, 0), (6, 6)),
    played(1, 0, (0, 1), (8, 9)),
    played(1, 1, (1, 0), (5, 12)),
]


def test_means_by_hand():
    first, second = standings([A, B], FOUR)
    assert (first.place, first.name, first.matches) == (1, "a", 4)
    assert first.score.mean == (10 + 6 + 8 + 12) / 4
    assert second.score.mean == (4 + 6 + 9 + 5) / 4
    # a wins two, shares one
    assert (first.win_share.mean, second.win_share.mean) == (2.5 / 4, 1.5 / 4)
    assert (first.mean_rank, second.mean_rank) == (5 / 4, 6 / 4)
    assert (first.contests_lost, first.refused) == (3 / 4, 1 / 4)


def test_intervals_resample_blocks():
    """With two blocks a resample holds the first twice, the second twice, or both: three means, no others."""
    first, _ = standings([A, B], FOUR)
    assert (first.score.low, first.score.high) == (8.0, 10.0)
    assert standings([A, B], FOUR) == standings([A, B], FOUR)


def test_one_block_gives_no_interval():
    first, _ = standings([A, B], FOUR[:2])
    assert math.isnan(first.score.low)
    assert "null" in summary_text(scenario("duel"), 0, [A, B], 2, standings([A, B], FOUR[:2]))


def test_the_interval_shrinks_with_the_root_of_the_blocks():
    def width(blocks: int) -> float:
        many = [played(block, 0, (0, 1), (10 + (-1) ** block * 2, 1)) for block in range(blocks)]
        first, _ = standings([A, B], many)
        return first.score.high - first.score.low

    # each block's mean is 8 or 12: a standard error of 2 / sqrt(n)
    assert width(100) == pytest.approx(2 * 1.96 * 0.2, rel=0.1)
    assert width(400) == pytest.approx(width(100) / 2, rel=0.15)


def test_equal_scores_share_a_place():
    assert [line.place for line in standings([A, B], [played(0, 0, (0, 1), (3, 3))])] == [1, 1]


def test_an_entrant_that_did_not_play_is_not_in_the_table():
    lines = standings([A, B, Entrant("c", "c.py", "target", "1" * 16)], FOUR)
    assert [line.name for line in lines] == ["a", "b"]


def test_the_files_hold_what_the_standings_say():
    table = standings([A, B], FOUR)
    rows = list(csv.DictReader(io.StringIO(table_text(table))))
    assert [(row["agent"], float(row["score"])) for row in rows] == [("a", 9.0), ("b", 6.0)]
    lines = [json.loads(line) for line in results_text([A, B], FOUR[::-1]).splitlines()]
    assert [line["match"] for line in lines] == [one.match.id for one in FOUR]
    assert lines[1] | {"verdicts": 0} == {
        "match": "r00001-g000001-s01",
        "block": 0,
        "seed": 7,
        "agents": ["b", "a"],
        "scores": [6, 6],
        "ranks": [1, 1],
        "verdicts": 0,
        "steps": 600,
        "digest": "ab",
    }
    summary = json.loads(summary_text(scenario("duel"), 3, [A, B], 4, table))
    assert (summary["seed"], summary["matches"], summary["config"]["hunters"]) == (3, 4, 2)
    assert summary["standings"][0]["score_low"] == 8.0
