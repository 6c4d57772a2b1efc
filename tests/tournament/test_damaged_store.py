"""A store that was damaged, or made by a stranger: each reader says so in one line, or reads what can be read."""

# ruff: noqa: S608 - the tables' names are ours

import json
import shutil
import sqlite3
from contextlib import closing
from random import Random

import pytest

from catch_arena import scenario
from catch_arena.errors import StoreError
from catch_arena.report import watch, write_report
from catch_arena.report.watch import LiveReport
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.execution.executors import SerialExecutor
from catch_arena.tournament.execution.runner import play_plan
from catch_arena.tournament.execution.worker import Worker
from catch_arena.tournament.export import export, rows
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.statistics.standings import standings
from catch_arena.tournament.store import STORE, Store, Tournament

CONFIG = scenario("duel", time_limit_s=1)
ENTRANTS = enter(["nearest", "idle", "random"])
PLAN = round_robin(3, 2, 2, seed=4)
FACTS = Tournament(CONFIG, ENTRANTS, PLAN.parameters, {"recorded": False, "max_forfeits": 10})
QUICK, MANY = 60, 1000


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A store in which a block waits to be played."""
    folder = tmp_path_factory.mktemp("whole")
    with Store.begin(FACTS, folder) as store, SerialExecutor(Worker(CONFIG, ENTRANTS)) as executor:
        play_plan(store, PLAN, executor)
    with closing(sqlite3.connect(folder / STORE)) as db, db:
        db.execute("DELETE FROM result WHERE match > 'r00002-g000002'")
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
            export(store, form, folder / f"matches.{form}")


def resume(folder):
    with (
        Store.begin(FACTS, folder, resume=True) as store,
        SerialExecutor(Worker(CONFIG, ENTRANTS)) as executor,
    ):
        play_plan(store, PLAN, executor, max_forfeits=10, folder=folder)
        standings(ENTRANTS, list(store.played()))


def follow(folder):
    live = LiveReport(folder)
    live.state()
    live.page()


READERS = (report, export_all, follow, resume)


def read_by_all(folder, copy):
    """What each reader says: nothing, or one line. Any other error is the test's failure."""
    said = []
    for reader in READERS:
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(folder, copy)
        try:
            reader(copy)
            said.append(None)
        except StoreError as error:
            said.append(str(error))
    assert all(line.isprintable() and len(line) < 1000 for line in said if line)
    return said


def changed(whole, folder, statement, values=()):
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(whole, folder)
    with closing(sqlite3.connect(folder / STORE)) as db, db:
        db.execute("PRAGMA foreign_keys = OFF")
        db.execute(statement, values)


DEEP = "[" * 100_000
FORGED = {
    "no facts": ("DELETE FROM fact", ()),
    "no config": ("DELETE FROM fact WHERE name = 'config'", ()),
    "a config of another kind": ("UPDATE fact SET value = '[1]' WHERE name = 'config'", ()),
    "entrants of another kind": ("UPDATE fact SET value = '{}' WHERE name = 'entrants'", ()),
    "no entrants": ("UPDATE fact SET value = '[]' WHERE name = 'entrants'", ()),
    "another ruleset": ("UPDATE fact SET value = '\"catch_arena_v9\"' WHERE name = 'ruleset'", ()),
    "no JSON": ("UPDATE result SET scores = 'x'", ()),
    "deep JSON": ("UPDATE result SET scores = ?", (DEEP,)),
    "a huge number": ("UPDATE result SET scores = ?", (f"[{'9' * 5000},1]",)),
    "a score for which no memory is enough": ("UPDATE result SET scores = '[9000000000000,1]'", ()),
    "NaN": ("UPDATE result SET thinking = '[[1,NaN,1],[1,1,1]]'", ()),
    "infinity": ("UPDATE result SET thinking = '[[1,1e999,1],[1,1,1]]'", ()),
    "wrong seats": ("UPDATE match SET seating = '[0,7]'", ()),
    "too few seats": ("UPDATE match SET seating = '[0]'", ()),
    "seats that are no numbers": ("UPDATE match SET seating = '[0,true]'", ()),
    "a negative block": ("UPDATE match SET block = -1", ()),
    "a seed that is text": ("UPDATE match SET seed = 'x'", ()),
    "a name that leads elsewhere": ("UPDATE match SET id = '../../x' WHERE id = 'r00001-g000001-s00'", ()),
    "a code that is none": ("UPDATE result SET forfeits = '[\"<b>\",null]'", ()),
    "a result without versions": ("UPDATE result SET versions = 9", ()),
    "a result without a match": ("DELETE FROM match WHERE id = 'r00001-g000001-s00'", ()),
    "versions of another kind": ("UPDATE versions SET value = '[]'", ()),
    "a value that is bytes": ("UPDATE result SET digest = x'ff00'", ()),
    "text that is none": ("UPDATE result SET digest = CAST(x'22fffe22' AS TEXT)", ()),
    "no table": ("DROP TABLE result", ()),
    "one more table": ("CREATE TABLE birds (name TEXT)", ()),
    "a trigger": ("CREATE TRIGGER t AFTER INSERT ON result BEGIN DELETE FROM match; END", ()),
    "a column more": ("ALTER TABLE result ADD COLUMN bird TEXT", ()),
}


@pytest.mark.parametrize("name", FORGED)
def test_a_forged_store_is_one_line_to_every_reader(whole, tmp_path, name):
    changed(whole, tmp_path / "forged", *FORGED[name])
    assert None not in read_by_all(tmp_path / "forged", tmp_path / "copy")


def test_a_view_that_never_ends_is_not_looked_at(whole, tmp_path):
    folder = tmp_path / "forged"
    changed(whole, folder, "DROP TABLE result")
    endless = "CREATE VIEW result AS WITH RECURSIVE n(x) AS (VALUES(1) UNION ALL SELECT x + 1 FROM n) SELECT x FROM n"
    with closing(sqlite3.connect(folder / STORE)) as db, db:
        db.execute(endless)
    assert None not in read_by_all(folder, tmp_path / "copy")


def test_a_whole_one_is_read_by_all(whole, tmp_path):
    assert read_by_all(whole, tmp_path / "copy") == [None] * len(READERS)


def test_names_in_a_forged_store_are_names(whole, tmp_path):
    """What `enter` refuses, a store cannot bring in."""
    for name in ("\x1b[31m", "x" * 101, "", "\u202eabc", "\ud800", "a\nb"):
        entrants = [{**one, "name": name} for one in FACTS.facts()["entrants"][:1]] + FACTS.facts()["entrants"][1:]
        changed(whole, tmp_path / "f", "UPDATE fact SET value = ? WHERE name = 'entrants'", (json.dumps(entrants),))
        assert None not in read_by_all(tmp_path / "f", tmp_path / "copy")


NASTY = (
    *(None, True, -1, 0, 1, 10**30, 2**63, 1.5, 1e308, "", "x", [], {}, [[]], [None], {"": ""}, [[[[[]]]]]),
    *("\ud800", "\x1b[2J", "\0", "<script>", "\u202e", "9" * 400, [0] * 1000, {"a": {"b": []}}),
)


def damaged_bytes(random, path):
    """Some bytes are others, a piece is missing or doubled, or a page stands in the place of another."""
    content = bytearray(path.read_bytes())
    kind = random.randrange(5)
    if kind == 0:
        for _ in range(random.choice((1, 5, 50, 500))):
            content[random.randrange(len(content))] = random.randrange(256)
    elif kind == 1:
        del content[random.randrange(len(content)) :]
    elif kind == 2:
        at = random.randrange(len(content))
        del content[at : at + random.randrange(1, 5000)]
    elif kind == 3:
        one, other = (4096 * random.randrange(len(content) // 4096) for _ in range(2))
        content[one : one + 4096] = content[other : other + 4096]
    else:
        at, length = random.randrange(100, len(content)), random.randrange(1, 300)
        content[at : at + length] = random.randbytes(length)
    path.write_bytes(content)


def damaged_value(random, value):
    """The same JSON with something else in one place."""
    if isinstance(value, list | dict) and value and random.random() < 0.8:
        keys = list(value) if isinstance(value, dict) else list(range(len(value)))
        key = random.choice(keys)
        changed = dict(value) if isinstance(value, dict) else list(value)
        what = random.random()
        if what < 0.1:
            del changed[key]
        elif what < 0.2 and isinstance(value, dict):
            changed["new"] = changed[key]
        elif what < 0.2:
            changed.append(changed[key])
        else:
            changed[key] = damaged_value(random, changed[key])
        return changed
    return random.choice(NASTY)


def damaged_rows(random, path):
    """Some values are others, rows are missing or doubled; the file itself is sound."""
    with closing(sqlite3.connect(path)) as db, db:
        for _ in range(random.choice((1, 1, 1, 3))):
            table = random.choice(("fact", "versions", "match", "result"))
            columns = [name for _, name, *_ in db.execute(f"PRAGMA table_info({table})")]
            key = columns[0]
            keys = [row[0] for row in db.execute(f"SELECT {key} FROM {table}")]
            if not keys:
                continue
            chosen, column = random.choice(keys), random.choice(columns)
            (value,) = db.execute(f"SELECT {column} FROM {table} WHERE {key} = ?", (chosen,)).fetchone()
            what = random.random()
            if what < 0.08:
                db.execute(f"DELETE FROM {table} WHERE {key} = ?", (chosen,))
                continue
            if what < 0.16:
                row = db.execute(f"SELECT * FROM {table} WHERE {key} = ?", (chosen,)).fetchone()
                new = random.choice((f"{chosen}x", -5, "zz", "../x"))
                statement = f"INSERT OR IGNORE INTO {table} VALUES ({', '.join('?' * len(row))})"
                db.execute(statement, (new if table != "versions" else random.randrange(-9, 99), *row[1:]))
                continue
            try:
                new = json.dumps(damaged_value(random, json.loads(value)))
            except (TypeError, ValueError):
                new = random.choice((*NASTY[:10], b"\xff\x00", 2**62, -(2**62)))
                new = None if new is None or (isinstance(new, int) and abs(new) >= 2**63) else new
            if random.random() < 0.1:
                new = random.choice((None, b"\xff", 5, 1.5, "nothing", '{"a":', DEEP[:5000], "NaN", "1e999"))
            try:
                db.execute(f"UPDATE OR IGNORE {table} SET {column} = ? WHERE {key} = ?", (new, chosen))
            except sqlite3.Error:  # what cannot even be written
                continue


def test_matches_whose_agents_seeds_followed_from_their_own_are_read_and_exported(whole, tmp_path):
    changed(whole, tmp_path / "store", "UPDATE match SET agent_seeds = '[]'")
    with Store.read(tmp_path / "store") as store:
        assert {row["agent_seed"] for row in rows(store)} == {None}
    export_all(tmp_path / "store")


@pytest.mark.parametrize("damage", [damaged_bytes, damaged_rows])
@pytest.mark.parametrize("count", [QUICK, pytest.param(MANY, marks=pytest.mark.nightly)])
def test_whatever_is_wrong_in_it_is_one_line(whole, tmp_path, damage, count):
    """Every other error, a memory that bursts or a reader that never ends is a failure."""
    told = 0
    for number in range(count):
        folder = tmp_path / "damaged"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(whole, folder)
        damage(Random(f"{damage.__name__} {number}"), folder / STORE)
        try:
            told += any(read_by_all(folder, tmp_path / "copy"))
        except Exception as error:
            error.add_note(f"damage {number}")
            raise
    assert told > count / 3
