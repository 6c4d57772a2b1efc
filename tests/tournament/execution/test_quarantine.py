"""Which blocks are put in quarantine, and when; and what a tournament's store remembers of whom it suspects."""

from concurrent.futures import Future

import pytest

from catch_arena import scenario
from catch_arena.errors import NoContest, StoreError, WorkerLost
from catch_arena.tournament import crash_journal
from catch_arena.tournament.crash_journal import CrashJournal
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution import block_queue
from catch_arena.tournament.execution.block_queue import play_blocks
from catch_arena.tournament.execution.forfeit_streaks import ForfeitStreaks
from catch_arena.tournament.match import MatchResult, PlayedMatch, blocks_of
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.store import Store, Tournament

CONFIG = scenario("duel")
ENTRANTS = tuple(Entrant(name, f"{name}.py", "target", "") for name in "abc")
PLAN = round_robin(3, 2, 2, seed=0)
BLOCKS = blocks_of(PLAN)


def outcome(block, code=None):
    result = MatchResult((0, 0), (1, 1), ({}, {}), (0, 0), (0, 0), 1, "", (code, None), ())
    return [(PlayedMatch(match, result), b"") for match in block]


class Hall:
    """An executor, and the quarantine, that note what is asked of them; `fails` says what comes of a block at first."""

    def __init__(self, fails, tolerated_losses=0):
        self.fails, self.tolerated_losses, self.max_pending = fails, tolerated_losses, 4
        self.did, self.under_way = [], set()

    def submit(self, block, excluded):
        del excluded
        self.did.append(("play", block[0].block))
        self.under_way.add(block[0].block)
        future = Future()
        future.block = block
        return future

    def wait(self, futures, return_when=None):
        """The last one ends first."""
        for future in futures[-1:] if return_when else futures:
            self.under_way.discard(future.block[0].block)
            error = self.fails.pop((future.block[0].block, self.did.count(("play", future.block[0].block))), None)
            if not future.done():
                future.set_result(outcome(future.block)) if error is None else future.set_exception(error)
        return type("Done", (), {"done": {future for future in futures if future.done()}})

    def result(self, future):
        return future.result()

    def stop_agents(self):
        self.did.append("rest")

    def has_suspects(self, block, excluded):
        del excluded
        return 0 in block[0].seating

    def is_due(self, block, excluded):
        return (block[0].block, "due") in self.fails and self.has_suspects(block, excluded)

    def note_begun(self, block, excluded): ...

    def note_kept(self, block): ...

    def play(self, block, excluded):
        del excluded
        assert not self.under_way
        self.did.append(("quarantine", block[0].block))
        return outcome(block, "FORFEIT_SABOTAGE")


def played(hall, monkeypatch, keep=None):
    monkeypatch.setattr(block_queue, "wait", hall.wait)
    kept = []
    play_blocks(iter(BLOCKS), hall, ForfeitStreaks(0), hall, keep or kept.append)
    return [recorded[0][0].match.block for recorded in kept]


def test_a_block_that_fails_is_tried_when_nothing_else_is_played_and_kept_in_its_place(monkeypatch):
    hall = Hall({(1, 1): NoContest("it failed")})
    assert played(hall, monkeypatch) == list(range(len(BLOCKS)))
    assert [one for one in hall.did if one[0] == "quarantine"] == [("quarantine", 1)]
    assert hall.did.count(("play", 1)) == 1


def test_a_block_that_was_under_way_when_the_tournament_ended_is_tried_at_once(monkeypatch):
    hall = Hall({(0, "due"): True})
    assert played(hall, monkeypatch) == list(range(len(BLOCKS)))
    assert hall.did[0] == ("quarantine", 0)
    assert ("play", 0) not in hall.did


def test_where_machines_may_be_lost_a_block_is_played_again_before_anybody_is_suspected(monkeypatch):
    hall = Hall(
        {(0, 1): WorkerLost("lost"), (0, 2): WorkerLost("lost"), (0, 3): WorkerLost("lost")}, tolerated_losses=2
    )
    played(hall, monkeypatch)
    assert [one for one in hall.did if one[1] == 0] == [("play", 0)] * 3 + [("quarantine", 0)]


def test_a_block_without_suspects_gets_no_trial(monkeypatch):
    number = next(block[0].block for block in BLOCKS if 0 not in block[0].seating)
    with pytest.raises(NoContest, match="it failed"):
        played(Hall({(number, 1): NoContest("it failed")}), monkeypatch)
    hall = Hall({(number, 1): WorkerLost("lost")})
    played(hall, monkeypatch)
    assert hall.did.count(("play", number)) == 2


def test_what_cannot_be_written_while_agents_play_is_written_when_they_have_ended(monkeypatch):
    """They may have filled the disk; so those blocks go into quarantine, and their results are not taken."""
    hall, kept, refused = Hall({}), [], []

    def keep(matches):
        if hall.under_way & {1, 2, 3} and not refused:
            refused.append(matches)
            raise StoreError("the disk is full")
        kept.append(matches[0][0].match.block)

    hall.wait_all = hall.wait
    monkeypatch.setattr(
        hall, "wait", lambda futures, return_when=None: hall.wait_all(futures[:1] if return_when else futures)
    )
    played(hall, monkeypatch, keep)
    assert refused
    assert kept == list(range(len(BLOCKS)))
    tried = [one[1] for one in hall.did if one[0] == "quarantine"]
    assert tried
    assert all(0 in BLOCKS[number][0].seating for number in tried)

    def never(_):
        raise StoreError("the disk is full")

    with pytest.raises(StoreError, match="the disk is full"):
        played(Hall({}), monkeypatch, never)


@pytest.fixture
def store(tmp_path):
    with Store.begin(Tournament(CONFIG, ENTRANTS, PLAN.parameters), tmp_path) as store:
        store.plan(BLOCKS)
        yield store


def test_what_was_under_way_is_known_the_next_time_until_it_is_kept(store):
    first = CrashJournal(store)
    assert first.begun == set()
    for block in (0, 1, 0):
        first.begin(block)
    first.end(1)
    assert CrashJournal(store).begun == {0}


def test_whoever_had_its_turn_when_the_tournament_was_killed_has_done_that(store):
    first = CrashJournal(store)
    first.begin_turn(4, 0)
    first.begin_turn(4, 2)
    found = CrashJournal(store).culprits(4)
    assert found == {2: "the tournament was killed while no other agent ran"}
    assert CrashJournal(store).culprits(4) == found
    assert CrashJournal(store).culprits(3) == {}


def test_a_turn_that_ended_in_order_leaves_nothing(store):
    first = CrashJournal(store)
    first.begin_turn(4, 2)
    first.end_turns()
    assert CrashJournal(store).culprits(4) == {}


@pytest.mark.parametrize("how", ["interrupted", "started anew"])
def test_what_may_be_a_persons_wish_counts_the_second_time(store, tmp_path, monkeypatch, how):
    for number in range(2):
        assert CrashJournal(store).culprits(4) == {}
        one = CrashJournal(store)
        one.begin_turn(4, 2)
        if how == "interrupted":
            one.break_off()
        else:
            (tmp_path / "boot").write_text(str(number))
            monkeypatch.setattr(crash_journal, "_BOOT", tmp_path / "boot")
    assert CrashJournal(store).culprits(4) == {2: "the tournament ended while no other agent ran, twice"}
