"""`catch-arena export` writes everything about each match, and the same bytes for the same plan."""

import csv
import json
import re
import sys

import pytest
from pyarrow import parquet
from tournament.runs import new_store
from tournament.seats import hunters

from catch_arena import scenario
from catch_arena.errors import ConfigError, OutputError
from catch_arena.tournament.execution.executors import Executor, Worker
from catch_arena.tournament.execution.ray_executor import RayExecutor
from catch_arena.tournament.execution.runner import play_plan
from catch_arena.tournament.export import columns, export
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.players import enter
from catch_arena.tournament.secret import Secret
from catch_arena.tournament.store import Tournament, versions

CONFIG = scenario("duel", time_limit_s=20)
ENTRANTS = enter(["nearest", "first", "random"])
SECRET = Secret.of(1)
PLAN = round_robin(3, hunters(2), 2, SECRET)
FACTS = Tournament(CONFIG, ENTRANTS, PLAN.parameters, seed=SECRET.text)


@pytest.fixture(scope="module")
def store():
    with new_store(FACTS) as store:
        play_plan(store, PLAN, Executor(Worker(CONFIG, ENTRANTS)))
        yield store


def test_a_line_of_json_says_all_that_is_known_of_a_match(store, tmp_path):
    export(store, tmp_path / "m.jsonl")
    lines = [json.loads(line) for line in (tmp_path / "m.jsonl").read_text().splitlines()]
    assert [line["match"] for line in lines] == [match.id for match in PLAN]
    for line, match, played in zip(lines, PLAN, store.played(), strict=True):
        result = played.result
        assert line == {
            "sides": ["hunter", "hunter"],
            "match": match.id,
            "block": match.block,
            "seed": match.seed,
            "agents": [ENTRANTS[place].name for place in match.seating],
            "agent_digests": [ENTRANTS[place].digest for place in match.seating],
            "agent_seeds": list(match.agent_seeds),
            "scores": list(result.scores),
            "ranks": list(result.ranks),
            "forfeits": [None, None],
            "details": [None, None],
            "verdicts": list(result.verdicts),
            "contests_won": list(result.contests_won),
            "contests_lost": list(result.contests_lost),
            "steps": 200,
            "digest": result.digest,
            "replay_digest": None,
            "ruleset": "catch_arena_v1",
            "config_digest": CONFIG.digest,
            "tournament_seed": SECRET.digits,
            "versions": versions(),
            "thinking": [
                {"moves": one.moves, "total_s": one.total_s, "longest_s": one.longest_s} for one in result.thinking
            ],
        }


def test_the_tables_have_a_row_for_each_seat_and_agree(store, tmp_path):
    for form in ("csv", "parquet"):
        export(store, tmp_path / f"m.{form}")
    with (tmp_path / "m.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    table = parquet.read_table(tmp_path / "m.parquet").to_pylist()
    assert [{name: "" if value is None else str(value) for name, value in row.items()} for row in table] == rows
    assert list(rows[0]) == list(columns())
    assert [(row["match"], row["seat"]) for row in table] == [(match.id, seat) for match in PLAN for seat in (0, 1)]
    caught = sum(row["granted"] for row in table)
    assert caught == sum(row["score"] for row in table) > 0


@pytest.mark.parametrize("form", ["jsonl", "csv", "parquet"])
def test_without_timing_another_run_gives_the_same_bytes(store, tmp_path, form):
    with new_store(FACTS) as other:
        play_plan(other, PLAN, Executor(Worker(CONFIG, ENTRANTS)))
        for one, name in ((store, "a"), (other, "b")):
            export(one, tmp_path / f"{name}.{form}", timing=False)
    assert (tmp_path / f"a.{form}").read_bytes() == (tmp_path / f"b.{form}").read_bytes()
    assert b"longest_s" not in (tmp_path / f"a.{form}").read_bytes()


def test_while_it_is_played_it_tells_no_seed_of_what_is_to_come(store, tmp_path):
    with new_store(FACTS) as under_way:
        under_way.set_planned(PLAN.size)
        under_way.add(list(store.played())[:2])
        export(under_way, tmp_path / "m.jsonl")
    lines = [json.loads(line) for line in (tmp_path / "m.jsonl").read_text().splitlines()]
    assert [(line["block"], line["tournament_seed"]) for line in lines] == [(0, None), (0, None)]


def test_what_cannot_be_is_one_line(store, tmp_path):
    with pytest.raises(ConfigError, match="the ending of the file must be one of"):
        export(store, tmp_path / "m.xlsx")
    with pytest.raises(OutputError, match="cannot be written: No such file"):
        export(store, tmp_path / "missing" / "m.csv")
    assert not list(tmp_path.iterdir())


def test_a_missing_extra_is_one_line(store, tmp_path, monkeypatch):
    for name in ("pyarrow", "pyarrow.parquet", "ray"):
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")  # which it would set for this process
    with pytest.raises(
        ConfigError, match=re.escape("format parquet needs PyArrow: pip install '.[parquet]' in the clone")
    ):
        export(store, tmp_path / "m.parquet")
    with pytest.raises(ConfigError, match=re.escape("executor ray needs Ray: pip install '.[ray]' in the clone")):
        RayExecutor(None, 1)
