"""The store keeps each match once, belongs to one tournament, and can be read while it is written."""

import dataclasses
import re
import sqlite3
import stat

import pytest
from tournament.runs import run
from tournament.seats import blocks_of, hunters

from catch_arena import scenario
from catch_arena.errors import OtherTournamentError, StoreError
from catch_arena.tournament.execution.executors import Executor, Worker
from catch_arena.tournament.execution.runner import play_plan
from catch_arena.tournament.match import Forfeit, MoveTimes, PlayedMatch
from catch_arena.tournament.plans.schedule import plan_of, round_robin
from catch_arena.tournament.players import enter
from catch_arena.tournament.store import STORE, Store, Tournament

SHORT = scenario("duel", time_limit_s=3)
ENTRANTS = enter(["nearest", "idle", "random"])
PLAN = round_robin(3, hunters(2), 2, seed=4)
FACTS = Tournament(SHORT, ENTRANTS, PLAN.parameters, seed="4")


@pytest.fixture(scope="module")
def played():
    return run(SHORT, ENTRANTS, PLAN)


@pytest.fixture
def store(tmp_path):
    with Store.begin(FACTS, tmp_path) as store:
        store.set_planned(PLAN.size)
        yield store


def begin(folder, facts=FACTS, *, resume=False):
    """Begin a tournament that gets no further than its plan."""
    with Store.begin(facts, folder, resume=resume) as store:
        store.set_planned(PLAN.size)


def test_what_was_kept_is_read_back_as_it_was_with_the_times(tmp_path, played):
    strange = dataclasses.replace(
        played[0].result,
        verdicts=({"GRANTED": 3}, {}),
        thinking=(MoveTimes(17, 0.25, 0.125),) * 2,
        forfeits=(None, Forfeit("FORFEIT_CRASH", 17, "it fell")),
    )
    kept = [PlayedMatch(played[0].match, strange, "00ff"), *played[1:]]
    with Store.begin(FACTS, tmp_path) as store:
        for one in kept[::-1]:
            store.add([one])
    with Store.read(tmp_path) as again:
        assert list(again.played()) == kept
        result = next(again.played()).result
        assert (result.thinking, result.forfeits[1].reason) == (strange.thinking, "it fell")
        assert again.tournament == FACTS


class Notes(Executor):
    """Executor that notes the blocks that it plays."""

    def __init__(self):
        super().__init__(Worker(SHORT, ENTRANTS))
        self.blocks = []

    def run(self, work, matches, excluded):
        self.blocks.append(matches)
        return super().run(work, matches, excluded)


def test_what_is_played_is_what_was_not_kept_in_the_order_of_the_plan(store, played):
    store.add(played[:4])
    assert (store.count_played(), store.count_planned()) == (4, 12)
    seen, executor = [], Notes()
    play_plan(store, PLAN, executor, progress=lambda *counts: seen.append(counts))
    assert executor.blocks == blocks_of(PLAN)[2:]
    assert seen == [(count, 12) for count in range(4, 13, 2)]
    assert list(store.played()) == played


@pytest.mark.parametrize(
    ("change", "row"),
    [
        (lambda kept: kept[2:], "r00001-g000001-s00"),
        (lambda kept: kept[:3], "r00001-g000002-s00"),
        (
            lambda kept: [*kept[:3], PlayedMatch(dataclasses.replace(kept[3].match, seed=0), kept[3].result)],
            "r00001-g000002-s00",
        ),
    ],
)
def test_matches_of_another_plan_are_refused_and_none_is_played(store, tmp_path, played, change, row):
    """The store lacks a block, or a match of one, or a seed differs."""
    store.add(change(played[:6]))
    executor = Notes()
    with pytest.raises(StoreError) as raised:
        play_plan(store, PLAN, executor)
    assert str(raised.value) == (
        f"{tmp_path / STORE}: is damaged: table match, row {row}: its block is not that of the plan"
    )
    assert not executor.blocks


def test_keeping_a_match_again_changes_nothing(store, played):
    store.add(played[:1])
    slower = dataclasses.replace(played[0].result, thinking=(MoveTimes(30, 9.0, 8.0),) * 2)
    store.add([PlayedMatch(played[0].match, slower)])
    assert list(store.played()) == played[:1]
    assert next(store.played()).result.thinking[0].total_s < 9.0


def changed(**facts):
    """Return the entrants, of which the second is changed."""
    return {"entrants": (ENTRANTS[0], dataclasses.replace(ENTRANTS[1], **facts), ENTRANTS[2])}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"plan": plan_of("round-robin", 3, hunters(2), 2, 4, most=1).parameters},
            'format is "round-robin" there, and "balanced" here',
        ),
        ({"terms": {"recorded": True}}, "recorded is not given there, and true here"),
        (changed(fault="it is broken"), "agent idle can begin there, and cannot begin here"),
        (changed(digest="0" * 16), "the digest of agent idle is"),
        (changed(spec="elsewhere.py"), None),
        (changed(prey_digest="0" * 16), None),
    ],
)
def test_another_tournament_does_not_go_on_with_it_and_is_told_why(tmp_path, played, change, message):
    """But the place of an agent's file does not matter, nor who would play prey where there is none.

    tests/cli/test_commands.py has other settings and agents, and test_secret.py has another seed.
    """
    with Store.begin(FACTS, tmp_path) as store:
        store.add(played[:1])
    other = dataclasses.replace(FACTS, **change)
    if message is None:
        begin(tmp_path, other, resume=True)
        return
    with pytest.raises(OtherTournamentError, match="is of another tournament") as raised:
        begin(tmp_path, other, resume=True)
    assert message in str(raised.value)
    assert "\n" not in str(raised.value)


def test_it_keeps_its_secret_from_others_and_until_the_end(store, tmp_path, played):
    """From other people on this machine, that is: an agent without namespaces runs as ourselves."""
    assert stat.S_IMODE((tmp_path / STORE).stat().st_mode) == 0o600
    assert Store.tournament_in(tmp_path) == FACTS
    assert Store.tournament_in(tmp_path / "elsewhere") is None
    store.add(played)
    store.set_planned(PLAN.size + 1)  # a plan may have another stage
    assert not store.ended
    store.end()
    with Store.read(tmp_path) as again:
        assert again.ended
    store.set_planned(PLAN.size)
    assert store.ended
    store.set_planned(round_robin(3, hunters(2), 3, seed=4).size)
    assert not store.ended


def test_one_without_a_match_may_begin_as_another(tmp_path):
    """For example after Ctrl-C in the first match, or if a cluster did not answer."""
    begin(tmp_path)
    other = dataclasses.replace(FACTS, plan=round_robin(3, hunters(2), 3, seed=4).parameters)
    begin(tmp_path, other)
    with Store.read(tmp_path) as store:
        assert store.tournament == other


def test_what_is_not_ours_is_refused_and_left_as_it_was(tmp_path):
    (tmp_path / STORE).write_bytes(b"a shopping list" * 100)
    with pytest.raises(StoreError, match="cannot be used: file is not a database"):
        begin(tmp_path, resume=True)
    (tmp_path / STORE).unlink()
    with sqlite3.connect(tmp_path / STORE) as db:
        db.execute("CREATE TABLE birds (name TEXT)")
    db.close()
    before = (tmp_path / STORE).read_bytes()
    with pytest.raises(StoreError, match="is no store of a tournament"):
        begin(tmp_path, resume=True)
    assert (tmp_path / STORE).read_bytes() == before


def test_a_store_of_another_format_is_refused(tmp_path):
    begin(tmp_path)
    with sqlite3.connect(tmp_path / STORE) as db:
        db.execute("PRAGMA user_version = 99")
    db.close()
    with (
        pytest.raises(
            StoreError,
            match=r"is of a newer version of Catch Arena \(format 99, and this one reads 6\): continue",
        ),
        Store.read(tmp_path),
    ):
        pass


def test_a_finished_one_is_read_where_nothing_can_be_written(tmp_path, played):
    """A folder in the place of the file that SQLite needs next to a log, as it cannot be made on a read-only disk."""
    with Store.begin(FACTS, tmp_path) as store:
        store.add(played)
        store.end()
    assert [path.name for path in tmp_path.iterdir()] == [STORE]
    (tmp_path / f"{STORE}-shm").mkdir()
    with Store.read(tmp_path) as reader:
        assert list(reader.played()) == played
    assert Store.tournament_in(tmp_path) == FACTS
    assert sorted(path.name for path in tmp_path.iterdir()) == [STORE, f"{STORE}-shm"]


def test_one_command_plays_in_a_folder_at_a_time(tmp_path):
    with (
        Store.begin(FACTS, tmp_path),
        pytest.raises(StoreError, match=f"^{re.escape(str(tmp_path))}: another command is playing in this folder$"),
    ):
        begin(tmp_path)
    begin(tmp_path)


def test_a_reader_sees_each_block_that_is_kept_and_changes_nothing(store, tmp_path, played):
    """`export` and `report` read in other processes while a tournament runs."""
    with Store.read(tmp_path) as reader:
        store.add(played[:1])
        assert list(reader.played()) == played[:1]
        store.add(played[1:2])
        assert list(reader.played()) == played[:2]
        with pytest.raises(StoreError, match="readonly database"):
            reader.end()
