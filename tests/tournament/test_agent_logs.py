"""What agents printed, and how they failed."""

import pytest

from catch_arena.errors import OutputError
from catch_arena.scenarios import scenario
from catch_arena.tournament.agent_logs import MOST_BYTES, AgentLogs
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import Forfeit, Match, MatchResult, PlayedMatch
from catch_arena.tournament.parties import Parties

SEATS = Parties.of(scenario("duel"))
ENTRANTS = [Entrant(name, name, "target", "") for name in ("quiet", "loud")]


def played(number, printed, forfeit=None):
    codes = (None, forfeit and forfeit.code)
    result = MatchResult((1, 0), (1, 2), ({}, {}), (0, 0), (0, 0), 9, "", codes, (), (None, forfeit), ("", printed))
    return PlayedMatch(Match(f"m{number}", number, 0, (0, 1)), result)


def test_each_agent_has_a_file_which_says_in_which_match_and_seat(tmp_path):
    logs = AgentLogs(tmp_path / "logs", ENTRANTS, SEATS)
    logs.add(played(1, ""))
    assert not (tmp_path / "logs").exists()
    logs.add(played(2, "hello"))
    logs.add(played(3, "", Forfeit("FORFEIT_CRASH", 4, "act raised KeyError: 3")))
    logs.add(played(4, "bye\n", Forfeit("FORFEIT_INIT", 0, "reset took longer than 10 s")))
    assert [path.name for path in (tmp_path / "logs").iterdir()] == ["loud.log"]
    assert (tmp_path / "logs" / "loud.log").read_text().splitlines() == [
        "== match m2, seat 1",
        "hello",
        "== match m3, seat 1: FORFEIT_CRASH in step 4: act raised KeyError: 3",
        "== match m4, seat 1: FORFEIT_INIT before the first step: reset took longer than 10 s",
        "bye",
    ]


@pytest.mark.parametrize(
    ("arena", "said"),
    [
        ("pairs", ["== match m1, seats 0+1", "ann", "== match m1, seats 2+3", "bob"]),
        ("tag", ["== match m1, seat 0", "ann", "== match m1, prey 0", "prey"]),
    ],
)
def test_a_team_is_told_by_its_seats_and_prey_by_its_number(tmp_path, arena, said):
    parties = Parties.of(scenario(arena))
    count = len(parties)
    entrants = [Entrant("all", "all", "target", "")]
    printed = {0: "ann", count - 1: said[-1]}
    result = MatchResult(
        (0,) * count,
        (1,) * count,
        ({},) * count,
        (0,) * count,
        (0,) * count,
        9,
        "",
        (None,) * count,
        (),
        (None,) * count,
        tuple(printed.get(party, "") for party in range(count)),
    )
    AgentLogs(tmp_path, entrants, parties).add(PlayedMatch(Match("m1", 1, 0, (0,) * count), result))
    assert (tmp_path / "all.log").read_text().splitlines() == said


def test_an_agent_whose_name_has_parts_has_a_file_too(tmp_path):
    logs = AgentLogs(tmp_path / "logs", [ENTRANTS[0], Entrant("ann/agent", "ann/agent", "target", "")], SEATS)
    logs.add(played(1, "hello"))
    assert (tmp_path / "logs" / "ann" / "agent.log").read_text() == "== match m1, seat 1\nhello\n"


def test_a_file_does_not_grow_for_ever(tmp_path):
    logs = AgentLogs(tmp_path, ENTRANTS, SEATS)
    for number in range(12):
        logs.add(played(number, "x" * (MOST_BYTES // 8)))
    assert MOST_BYTES <= (tmp_path / "loud.log").stat().st_size < MOST_BYTES * 10 / 8


def test_a_folder_that_cannot_be_is_one_line(tmp_path):
    (tmp_path / "logs").touch()
    with pytest.raises(OutputError, match=r"logs/loud\.log: cannot be written: "):
        AgentLogs(tmp_path / "logs", ENTRANTS, SEATS).add(played(1, "hello"))
