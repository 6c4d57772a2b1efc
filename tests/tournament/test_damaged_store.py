"""Every command that reads a store with wrong values prints one line about it."""

import shutil
import sqlite3
from contextlib import closing

import pytest
from tournament.seats import hunters

from catch_arena import scenario
from catch_arena.errors import StoreError
from catch_arena.report import watch, write_report
from catch_arena.report.watch import LiveReport
from catch_arena.tournament.execution.executors import Executor, Worker
from catch_arena.tournament.execution.runner import play_plan
from catch_arena.tournament.export import export
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.players import enter
from catch_arena.tournament.statistics.outcomes import SideResults
from catch_arena.tournament.statistics.standings import standings
from catch_arena.tournament.store import STORE, Store, Tournament

CONFIG = scenario("duel", time_limit_s=1)
ENTRANTS = enter(["nearest", "idle", "random"])
PLAN = round_robin(3, hunters(2), 2, seed=4)
FACTS = Tournament(CONFIG, ENTRANTS, PLAN.parameters, "4", {"recorded": False, "max_forfeits": 10})


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A store in which a block waits to be played."""
    folder = tmp_path_factory.mktemp("whole")
    with Store.begin(FACTS, folder) as store, Executor(Worker(CONFIG, ENTRANTS)) as executor:
        play_plan(store, PLAN, executor)
    with closing(sqlite3.connect(folder / STORE)) as db, db:
        db.execute("DELETE FROM match WHERE id > 'r00002-g000002'")
    return folder


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(watch, "_PAUSE_S", 0.0)
    monkeypatch.setattr(watch, "_PAUSE_FACTOR", 0.0)


def report(folder):
    write_report(folder)


def export_all(folder):
    for form in ("jsonl", "csv"):
        with Store.read(folder) as store:
            export(store, folder / f"matches.{form}")


def resume(folder):
    with (
        Store.begin(FACTS, folder, resume=True) as store,
        Executor(Worker(CONFIG, ENTRANTS)) as executor,
    ):
        play_plan(store, PLAN, executor, max_forfeits=10)
        standings(SideResults.of(ENTRANTS, list(store.played()), hunters(2)))


def follow(folder):
    live = LiveReport(folder)
    live.state()
    live.page()


READERS = (report, export_all, follow, resume)


def read_by_all(folder, copy):
    """Return the error of each reader, one line, or None; any other error fails the test."""
    messages = []
    for reader in READERS:
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(folder, copy)
        try:
            reader(copy)
            messages.append(None)
        except StoreError as error:
            messages.append(str(error))
    assert all(line.isprintable() and len(line) < 1000 for line in messages if line)
    return messages


def changed(whole, folder, statement, values=()):
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(whole, folder)
    with closing(sqlite3.connect(folder / STORE)) as db, db:
        db.execute("PRAGMA foreign_keys = OFF")
        db.execute(statement, values)


FORGED = {
    "no facts": "DELETE FROM fact",
    "no config": "DELETE FROM fact WHERE name = 'config'",
    "a config of another kind": "UPDATE fact SET value = '[1]' WHERE name = 'config'",
    "a config that nests deep": "UPDATE fact SET value = replace(hex(zeroblob(50000)), '0', '[') WHERE name = 'config'",
    "entrants of another kind": "UPDATE fact SET value = '{}' WHERE name = 'entrants'",
    "another ruleset": "UPDATE fact SET value = '\"catch_arena_v9\"' WHERE name = 'ruleset'",
    "no number of matches": "UPDATE fact SET value = 'x' WHERE name = 'planned'",
    "no JSON": "UPDATE match SET played = 'x'",
    "too few scores": "UPDATE match SET played = json_set(played, '$.result.scores', json('[1]'))",
    "wrong seats": "UPDATE match SET played = json_set(played, '$.match.seating', json('[0,7]'))",
    "too few seats": "UPDATE match SET played = json_set(played, '$.match.seating', json('[0]'))",
    "another id": "UPDATE match SET played = json_set(played, '$.match.id', '0000!')",
    "seats that are no numbers": "UPDATE match SET played = json_set(played, '$.match.seating', json('[0,true]'))",
    "a seed that is text": "UPDATE match SET played = json_set(played, '$.match.seed', 'x')",
    "versions of another kind": "UPDATE versions SET value = '[]'",
    "versions that are missing": "DELETE FROM versions",
    "a value that is no text": "UPDATE match SET played = x'22fffe22'",
    "no table": "DROP TABLE match",
    "a seed that is none": "UPDATE fact SET value = '\"-1\"' WHERE name = 'seed'",
}


@pytest.mark.parametrize("name", FORGED)
def test_a_store_with_a_wrong_value_is_one_line_to_every_reader(whole, tmp_path, name):
    changed(whole, tmp_path / "forged", FORGED[name])
    messages = [line for line in read_by_all(tmp_path / "forged", tmp_path / "copy") if line]
    assert messages if name.startswith("versions") else len(messages) == len(READERS)


def test_the_line_names_the_file_the_table_and_the_row(whole, tmp_path):
    folder = tmp_path / "forged"
    for value, why in (("x", "JSON is malformed"), ("[1]", "settings must map names to values")):
        changed(whole, folder, "UPDATE fact SET value = ? WHERE name = 'config'", [value])
        with pytest.raises(StoreError, match=f"is damaged: table fact, row config: {why}"):
            Store.tournament_in(folder)
    statement = "UPDATE match SET played = json_set(played, '$.result.scores', json(?)) WHERE id = 'r00001-g000001-s01'"
    changed(whole, folder, statement, ['[1,"x"]'])
    with Store.read(folder) as store, pytest.raises(StoreError) as raised:
        list(store.played())
    assert str(raised.value) == (
        f"{folder / STORE}: is damaged: table match, row r00001-g000001-s01: "
        "Expected `int`, got `str` - at `$.result.scores[1]`"
    )


@pytest.mark.parametrize("damage", [lambda content: content[:9000], lambda content: content[:4096] + bytes(8192)])
def test_a_store_with_damaged_bytes_is_one_line_to_every_reader(whole, tmp_path, damage):
    """The end is missing, or pages are empty."""
    folder = shutil.copytree(whole, tmp_path / "damaged")
    (folder / STORE).write_bytes(damage((folder / STORE).read_bytes()))
    assert all(read_by_all(folder, tmp_path / "copy"))
