"""An agent that forfeits too many matches in a row plays no more, with any number of processes."""

import random
from collections import Counter
from concurrent.futures import ALL_COMPLETED, FIRST_COMPLETED, Future
from contextlib import contextmanager, suppress
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tournament.agents import write_agent
from tournament.runs import new_store, run
from tournament.seats import hunters

from catch_arena import scenario
from catch_arena.errors import MatchFailedError
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution import block_queue
from catch_arena.tournament.execution.block_queue import ForfeitStreaks, do_in_order
from catch_arena.tournament.execution.executors import Worker
from catch_arena.tournament.execution.runner import play_plan
from catch_arena.tournament.match import Fault, Forfeit, Match, MatchResult, MoveTimes, PlayedMatch, ranks_of
from catch_arena.tournament.plans.schedule import FORMATS, plan_of, round_robin
from catch_arena.tournament.players import enter
from catch_arena.tournament.store import Tournament

SEATS = 3
CONFIG = scenario("standard", hunters=SEATS)


class Field:
    """Entrants that forfeit by chance, each as often as it likes; who is out changes what happens to all others."""

    def __init__(self, temper, seed):
        self.temper, self.seed = temper, seed
        self.entrants = tuple(Entrant(f"e{place}", f"e{place}", "target", "") for place in range(len(temper)))

    def play(self, match, out):
        draw = random.Random(f"{match.id} {self.seed} {sorted(out)}")
        codes = [
            "FORFEIT_OUT" if place in out else "FORFEIT_CRASH" if draw.random() < self.temper[place] else None
            for place in match.seating
        ]
        scores = tuple(0 if code else draw.randrange(9) for code in codes)
        ranks = ranks_of(scores, [0 if code else None for code in codes])
        thinking = (MoveTimes(1, 0.0, 0.0),) * SEATS
        forfeits = tuple(code and Forfeit(code, 0, "") for code in codes)
        result = MatchResult(
            scores, ranks, ({},) * SEATS, (0,) * SEATS, (0,) * SEATS, 1, "", forfeits, thinking, ("",) * SEATS
        )
        return PlayedMatch(match, result)


class Shuffled:
    """Ends its blocks in any order, loses some, and may be broken off; `wait` stands for the one of `block_queue`."""

    def __init__(self, field, max_pending, seed, breaks_after=None, loses=0.1):
        self.field, self.max_pending, self.random = field, max_pending, random.Random(seed)
        self.breaks_after, self.loses = breaks_after, loses
        self.begun = {}
        self.lost = Counter()
        self.played = 0
        self.worker = Worker(CONFIG, field.entrants)

    def run(self, _work, block, out):
        future = Future()
        self.begun[future] = block, dict(out)
        return future

    def wait(self, futures, return_when=ALL_COMPLETED):
        futures = [future for future in futures if not future.done()]
        if self.played == self.breaks_after:
            raise KeyboardInterrupt
        self.begun = {future: about for future, about in self.begun.items() if not future.cancelled()}
        most = self.random.randint(1, len(futures)) if return_when == FIRST_COMPLETED else len(futures)
        for future in self.random.sample(futures, most):
            block, out = self.begun.pop(future)
            if self.random.random() < self.loses and self.lost[block] < 2:
                self.lost[block] += 1
                future.set_exception(MatchFailedError("it is gone"))
            else:
                future.set_result([(self.field.play(match, out), b"") for match in block])
                self.played += 1

    def result(self, future):
        return future.result()

    @contextmanager
    def in_charge(self):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(block_queue, "wait", self.wait)
            patch.setattr(block_queue, "_PAUSE_S", 0.0)
            yield


def played_by(executor, field, plan, most):
    with new_store(Tournament(CONFIG, field.entrants, plan.parameters, "0")) as store, executor.in_charge():
        play_plan(store, plan, executor, max_forfeits=most)
        return list(store.played())


@given(
    temper=st.lists(st.sampled_from([0.0, 0.02, 0.5, 0.8, 0.95, 1.0]), min_size=4, max_size=6),
    form=st.sampled_from(FORMATS),
    sampled=st.booleans(),
    most=st.sampled_from([0, 1, 2, 5, 10]),
    max_pending=st.sampled_from([1, 2, 7, 28]),
    seed=st.integers(0, 2**32),
    data=st.data(),
)
def test_whoever_plays_what_when_and_is_broken_off_the_records_are_those_of_one_after_the_other(
    temper, form, sampled, most, max_pending, seed, data
):
    field = Field(temper, seed)
    plan = plan_of(form, len(temper), hunters(SEATS), 2, seed, 1 if sampled else 20_000)
    expected = played_by(Shuffled(field, 1, 0, loses=0.0), field, plan, most)
    with new_store(Tournament(CONFIG, field.entrants, plan.parameters, "0")) as store:
        for life in range(100):
            executor = Shuffled(field, max_pending, seed + life, data.draw(st.integers(0, 40)) if life < 3 else None)
            before = list(store.played())
            assert before == expected[: len(before)]
            with suppress(KeyboardInterrupt), executor.in_charge():
                play_plan(store, plan, executor, max_forfeits=most)
                break
        assert list(store.played()) == expected


@pytest.mark.parametrize(
    ("codes", "most", "out"),
    [
        ("CCC", 3, True),
        ("CC.CC.C", 3, False),
        ("CC.CCC..", 3, True),
        ("CT", 2, True),
        ("." * 9, 1, False),
        ("C" * 99, 0, False),
    ],
)
def test_a_streak_is_of_forfeits_of_any_kind_and_ends_with_a_match_that_was_played(codes, most, out):
    streaks = ForfeitStreaks(most)
    kinds = {"C": "FORFEIT_CRASH", "T": "FORFEIT_TIMEOUT", ".": None}
    played = [
        SimpleNamespace(match=Match("m", 0, 0, (0, 1)), result=SimpleNamespace(forfeits=(kinds[code], None)))
        for code in codes
    ]
    streaks.add(played)
    assert bool(streaks.excluded) is out
    expected = Fault("FORFEIT_OUT", f"it had forfeited {most} matches in a row")
    assert streaks.excluded_from([Match("m", 0, 0, (0, 1))]) == ({0: expected} if out else {})


@pytest.mark.parametrize("jobs", [1, 2])
def test_who_is_out_is_not_started_and_the_others_play_on(tmp_path, jobs):
    """For real: it notes each of its starts."""
    starts = "with Path(__file__).with_name('starts').open('a') as file: file.write('x')"
    bad = write_agent(tmp_path / "bad.py", "1 / 0", starts, "from pathlib import Path\n")
    config, entrants = scenario("duel", time_limit_s=6), enter([bad, "nearest", "idle"])
    found = run(config, entrants, round_robin(3, hunters(2), 4, seed=0), jobs=jobs, max_forfeits=3)
    theirs = [(one.result, one.match.seating.index(0)) for one in found if 0 in one.match.seating]
    codes = [result.forfeit_codes[seat] for result, seat in theirs]
    assert codes == ["FORFEIT_CRASH"] * 4 + ["FORFEIT_OUT"] * 12
    assert jobs > 1 or (tmp_path / "starts").read_text() == "x" * 4
    result, seat = theirs[-1]
    assert str(result.forfeits[seat]) == "FORFEIT_OUT before the first step: it had forfeited 3 matches in a row"
    assert result.ranks[seat] == 2
    assert (result.steps, result.thinking[1 - seat].moves) == (60, 60)


def test_a_task_that_failed_twice_is_done_alone_and_its_result_is_the_error(monkeypatch):
    monkeypatch.setattr(block_queue, "_PAUSE_S", 0.0)
    log: list[str] = []
    running: dict[str, Future] = {}

    def begin(task):
        log.append(task)
        running[task] = Future()
        return running[task]

    def wait(futures, return_when=ALL_COMPLETED):
        del return_when
        ended = [task for task, future in running.items() if future in futures]
        log.append(f"end {' '.join(ended)}")
        for task in ended:
            future = running.pop(task)
            future.set_exception(MatchFailedError("no")) if task == "bad" else future.set_result(None)

    monkeypatch.setattr(block_queue, "wait", wait)
    executor = SimpleNamespace(max_pending=2, result=lambda future: future.result())
    results = list(do_in_order(["bad", *"abcde"], executor, begin))
    assert [(task, str(result)) for task, result in results] == [("bad", "no"), *((task, "None") for task in "abcde")]
    first, again = ["bad", "a", "end bad a", "b", "c"], ["bad", "end b c bad", "d", "e"]
    assert log == [*first, *again, "end d e", "bad", "end bad"]


def test_one_pause_serves_all_tasks_that_fail_together(monkeypatch):
    """As when a worker dies: the pool is broken for every task that was begun."""
    pauses: list[float] = []
    monkeypatch.setattr(block_queue, "time", SimpleNamespace(sleep=pauses.append))
    tries: Counter[str] = Counter()

    def begin(task):
        tries[task] += 1
        future: Future[str] = Future()
        future.set_exception(MatchFailedError("no")) if tries[task] == 1 else future.set_result(task.upper())
        return future

    executor = SimpleNamespace(max_pending=3, result=lambda future: future.result())
    assert list(do_in_order("abc", executor, begin)) == [("a", "A"), ("b", "B"), ("c", "C")]
    assert len(pauses) == 1


def test_a_slow_block_holds_the_rest_back_before_they_fill_the_memory():
    """While one block lasts, at most 256 later ones are played and held."""
    most: list[int] = []
    field, begun = Field([0.0] * SEATS, 1), []
    blocks = [(Match(str(number), number, 1, (0, 1, 2)),) for number in range(400)]

    class OneIsSlow(Shuffled):
        def run(self, work, block, out):
            begun.append(block)
            return super().run(work, block, out)

        def wait(self, futures, return_when=ALL_COMPLETED):
            first, *others = futures
            if others:
                return super().wait(others, return_when)
            most.append(len(begun))
            return super().wait([first], return_when)

    executor = OneIsSlow(field, 2, 1, loses=0.0)
    with executor.in_charge():
        list(block_queue.play_blocks(blocks, executor, ForfeitStreaks(0)))
    assert most[0] == 2 + 256
