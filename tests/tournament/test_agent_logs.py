"""A log file has the output and the failures of one agent, by match and seat, up to a size."""

import pytest
from tournament.played_matches import made_up

from catch_arena.errors import OutputError
from catch_arena.scenarios import scenario
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution.runner import MOST_BYTES, add_to_logs
from catch_arena.tournament.match import Forfeit
from catch_arena.tournament.parties import Parties

SEATS = Parties.of(scenario("duel"))
ENTRANTS = [Entrant(name, name, "target", "") for name in ("quiet", "loud")]


def played(number, printed, forfeit=None):
    return made_up(number, (0, 1), (1, 0), forfeits=(None, forfeit), logs=("", printed))


def test_each_agent_has_a_file_which_says_in_which_match_and_seat(tmp_path):
    crash = Forfeit("FORFEIT_CRASH", 4, "act raised KeyError: 3")
    late = Forfeit("FORFEIT_INIT", 0, "reset took longer than 10 s")
    add_to_logs(tmp_path / "logs", ENTRANTS, SEATS, played(1, ""))
    assert not (tmp_path / "logs").exists()
    add_to_logs(tmp_path / "logs", ENTRANTS, SEATS, played(2, "hello"))
    add_to_logs(tmp_path / "logs", ENTRANTS, SEATS, played(3, "", crash))
    add_to_logs(
        tmp_path / "logs",
        ENTRANTS,
        SEATS,
        played(4, "bye\n", late),
    )
    assert [path.name for path in (tmp_path / "logs").iterdir()] == ["loud.log"]
    assert (tmp_path / "logs" / "loud.log").read_text().splitlines() == [
        "== match r00001-g000003-s00, seat 1",
        "hello",
        "== match r00001-g000004-s00, seat 1: FORFEIT_CRASH in step 4: act raised KeyError: 3",
        "== match r00001-g000005-s00, seat 1: FORFEIT_INIT before the first step: reset took longer than 10 s",
        "bye",
    ]


@pytest.mark.parametrize(("arena", "first", "last"), [("pairs", "seats 0+1", "seats 2+3"), ("tag", "seat 0", "prey 0")])
def test_a_team_is_told_by_its_seats_and_prey_by_its_number(tmp_path, arena, first, last):
    parties = Parties.of(scenario(arena))
    count = len(parties)
    logs = ("ann", *[""] * (count - 2), "bob")
    one = made_up(0, (0,) * count, (0,) * count, logs=logs)
    add_to_logs(tmp_path, ENTRANTS[1:], parties, one)
    name = one.match.id
    lines = [f"== match {name}, {first}", "ann", f"== match {name}, {last}", "bob"]
    assert (tmp_path / "loud.log").read_text().splitlines() == lines


def test_a_file_does_not_grow_for_ever(tmp_path):
    for number in range(12):
        add_to_logs(tmp_path, ENTRANTS, SEATS, played(number, "x" * (MOST_BYTES // 8)))
    assert MOST_BYTES <= (tmp_path / "loud.log").stat().st_size < MOST_BYTES * 10 / 8


def test_a_folder_that_cannot_be_is_one_line(tmp_path):
    (tmp_path / "logs").touch()
    with pytest.raises(OutputError, match=r"logs/loud\.log: cannot be written: "):
        add_to_logs(tmp_path / "logs", ENTRANTS, SEATS, played(1, "hello"))
