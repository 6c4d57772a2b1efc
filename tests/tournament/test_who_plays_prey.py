"""All output of a tournament names the shipped prey that plays for an agent without `Prey` (R12.7)."""

import csv
import dataclasses
import json
import re
from pathlib import Path

import pytest
from command_line import run

from catch_arena import Replay
from catch_arena.errors import OtherTournamentError
from catch_arena.report import REPORT
from catch_arena.tournament.players import enter
from catch_arena.tournament.store import Store

AGENTS = ["nearest", "patrol", "first", "corners", "random"]
AS_PREY = ["corners", "first (plays flee)", "nearest (plays flee)", "patrol (plays flee)", "random"]
SHORT = ["--set", "time_limit_s=2", "--seed", "1", "--jobs", "1", "--rounds", "1"]
DIGESTS = {entrant.name: entrant.digest for entrant in enter([*AGENTS, "flee"])}


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    folder = tmp_path_factory.mktemp("played")
    ended = run("tournament", *AGENTS, "-s", "tag", *SHORT, "--record", "--out", str(folder))
    assert ended.exit_code == 0, ended.output
    return folder, ended.stdout


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_line_and_the_table_on_the_terminal(played):
    _, printed = played
    before, hunters, prey = re.split("As hunters|As prey", printed)
    assert "flee plays the prey of agents without a class Prey: nearest, patrol, first\n" in before
    assert "(plays" not in hunters
    assert prey.count("(plays") == 3


def test_the_standings(played):
    folder, _ = played
    assert sorted(row["agent"] for row in rows_of(folder / "standings.csv")) == sorted(AGENTS)
    assert sorted(row["agent"] for row in rows_of(folder / "prey_standings.csv")) == AS_PREY
    found = json.loads((folder / "standings.json").read_text())
    assert sorted(line["agent"] for line in found["prey_standings"]) == AS_PREY
    first, *_, corners, _ = found["entrants"]
    nearest = {"prey": "nearest (plays flee)", "prey_digest": DIGESTS["flee"]}
    assert first == {"name": "nearest", "control": "target", "digest": DIGESTS["nearest"]} | nearest
    assert (corners["prey"], corners["prey_digest"]) == ("corners", DIGESTS["corners"])


def test_the_export(played, tmp_path):
    folder, _ = played
    ended = run("export", str(folder), "-o", str(tmp_path / "m.csv"))
    assert ended.exit_code == 0, ended.output
    found = {(row["side"], row["agent"], row["agent_digest"]) for row in rows_of(tmp_path / "m.csv")}
    assert found == {
        *(("hunter", name, DIGESTS[name]) for name in AGENTS),
        *(("prey", name, DIGESTS["flee" if "flee" in name else name]) for name in AS_PREY),
    }


def test_replays_and_the_report(played):
    folder, _ = played
    names = [Replay.load(path).names for path in (folder / "replays").glob("*.replay")]
    assert {name for *_, name in names} == set(AS_PREY)
    assert {name for *hunters, _ in names for name in hunters} == set(AGENTS)
    page = (folder / REPORT).read_text()
    assert (
        page.count('<th scope="row">nearest (plays flee)</th>') == 4
    )  # the prey's table and its fold, and twice head to head
    assert f"flee, <code>{DIGESTS['flee']}</code>" in page


def test_another_shipped_prey_does_not_go_on_with_a_tournament_that_it_plays_in(played):
    folder, _ = played
    about = Store.tournament_in(folder)
    other = (dataclasses.replace(about.entrants[0], prey_digest="0" * 16), *about.entrants[1:])
    with (
        pytest.raises(OtherTournamentError, match="the prey digest of agent nearest is"),
        Store.begin(dataclasses.replace(about, entrants=other), folder, resume=True),
    ):
        pass
