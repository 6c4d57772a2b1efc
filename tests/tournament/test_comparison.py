"""`catch-arena compare` seats both agents fairly, prints a verdict, and exits with its code."""

import re

import pytest
from command_line import run
from tournament.agents import write_agent
from tournament.played_matches import made_up
from tournament.seats import hunters

from catch_arena import scenario
from catch_arena.tournament.comparison import compare, comparison_block, share_of_a
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.players import enter
from catch_arena.tournament.statistics.sprt import Sprt

QUICK = ["--set", "time_limit_s=5", "--jobs", "1"]


@pytest.mark.parametrize(("seats", "field"), [(2, 0), (4, 0), (4, 2)])
def test_both_sit_in_every_seat_equally_often(seats, field):
    """Against each other, and next to a field."""
    block = comparison_block(round_robin(seats, hunters(seats), 1, 0), seats - field)
    sat = [(place, seat) for match in block for seat, place in enumerate(match.seating)]
    often = {sat.count((place, seat)) for place in (0, 1) for seat in range(seats)}
    assert often == {len(block) * (seats - field) // 2 // seats}
    assert {place for place, _ in sat} == set(range(2 + field))


def test_against_a_full_field_they_take_turns_in_the_same_seats_on_the_same_targets():
    block = comparison_block(round_robin(4, hunters(4), 1, 0), 1)
    assert len(block) == 8
    for mine, theirs in zip(block[::2], block[1::2], strict=True):
        assert mine.seed == theirs.seed
        assert [place or 1 for place in mine.seating] == list(theirs.seating)
        assert sorted(mine.seating) == [0, 2, 3, 4]


def test_a_blocks_outcome_by_hand():
    def block(*matches):
        return [made_up(0, seating, (), turn, ranks=ranks) for turn, (seating, ranks) in enumerate(matches)]

    together = block(((0, 1, 2), (1, 2, 3)), ((2, 0, 1), (1, 2, 2)), ((1, 2, 0), (1, 2, 3)))
    assert share_of_a(together, hunters(3), 2) == (1 + 0.5 + 0) / 3
    in_turn = block(((0, 2, 3), (1, 2, 3)), ((1, 2, 3), (2, 1, 3)), ((2, 0, 3), (1, 2, 3)), ((2, 1, 3), (1, 2, 3)))
    assert share_of_a(in_turn, hunters(3), 1) == (1 + 0.5) / 2


def test_the_decision_does_not_depend_on_the_number_of_processes():
    config = scenario("duel", time_limit_s=5)

    def found(jobs):
        return compare(config, enter(["nearest", "idle"]), Sprt(0.5, 0.7), max_blocks=40, jobs=jobs)

    alone = found(1)
    assert alone == found(2)
    assert alone.decision == "H1"


@pytest.mark.parametrize(
    ("words", "code", "verdict"),
    [
        (["nearest", "idle", "--elo1", "100"], 0, "nearest is stronger than idle \\(H1\\)"),
        (["idle", "nearest", "--elo1", "100"], 1, "idle is not stronger than nearest \\(H0\\)"),
        (["nearest", "contested", "--max-blocks", "2"], 3, "undecided after 2 blocks"),
        (["idle", "nearest", "-s", "standard", "--elo1", "140", *["--against", "patrol"] * 3], 1, "H0"),
    ],
)
def test_the_command_says_what_it_found_and_its_exit_code_does_too(words, code, verdict):
    result = run("compare", *words, *QUICK, "--seed", "0")
    assert result.exit_code == code, result.output
    assert re.search(f"verdict: .*{verdict}", result.output)
    assert max(map(len, result.stdout.splitlines())) <= 120


def test_forfeits_are_told_and_one_that_is_out_does_not_play_on(tmp_path):
    bad = write_agent(tmp_path / "bad.py", "return 99")
    result = run("compare", bad, "nearest", *QUICK)
    assert re.search(r"^bad forfeited: 10 times FORFEIT_ILLEGAL, \d+ times FORFEIT_OUT$", result.output, re.MULTILINE)
    assert result.exit_code == 1
    assert "verdict: bad is not stronger than nearest (H0)" in result.output


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nearest"], "argument 'agents' takes 2 values"),
        (["nearest", "idle", "--elo1", "0"], "--elo1 must be above 0, got 0"),
        (["nearest", "idle", "--elo1", "1e9"], "got 0.5 and 1"),
        (["nearest", "idle", "--max-blocks", "0"], "error: --max-blocks must be at least 1, got 0"),
        (
            ["nearest", "idle", "-s", "standard", "--against", "first"],
            "(--against) must be of 0 or 2 or 3 agents, got 1",
        ),
        (["nearest", "idle", "-s", "capstone"], "for at least 2 agents"),
        (["nearest", "idel"], "did you mean idle"),
    ],
)
def test_what_cannot_be_compared_is_refused_in_one_line(words, message):
    result = run("compare", *words)
    assert result.exit_code == 2
    assert message in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1
