"""Blocks played by several processes: what becomes of them when one dies, hangs, or raises what nobody expects."""

import os
import signal
from contextlib import nullcontext
from multiprocessing import resource_tracker

import pytest

from catch_arena import scenario
from catch_arena.descendants import family
from catch_arena.errors import NoContest
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.execution.executors import ProcessExecutor
from catch_arena.tournament.execution.worker import Worker
from catch_arena.tournament.match import blocks_of
from catch_arena.tournament.plans.schedule import round_robin

SHORT = scenario("duel", time_limit_s=3)
BLOCKS = [list(block) for block in blocks_of(round_robin(3, 2, 1, seed=0))]
"""Of entrants 0 and 1, 0 and 2, 1 and 2."""


def helpers():
    """Processes that Python itself keeps until its end, once any process was started."""
    return {resource_tracker._resource_tracker._pid}


@pytest.fixture
def worker(tmp_path):
    """A worker whose first entrant does this in its first move."""

    def made(*act: str) -> Worker:
        lines = ("import os", "class Agent:", "    def reset(self, seed): pass", "    def act(self, view):")
        source = "\n        ".join(("\n".join(lines), *act))
        (tmp_path / "bad.py").write_text(source)
        return Worker(SHORT, enter([str(tmp_path / "bad.py"), "nearest", "idle"]))

    return made


def test_what_a_process_that_died_has_lost_can_be_played_by_the_next_ones(worker):
    before = family(os.getpid())
    with ProcessExecutor(worker("os._exit(1)"), 2) as processes:
        with pytest.raises(NoContest, match="a worker process died"):
            processes.result(processes.submit(BLOCKS[0], {}))
        assert [one.match for one, _ in processes.result(processes.submit(BLOCKS[2], {}))] == BLOCKS[2]
    assert family(os.getpid()) - before <= helpers()


@pytest.mark.parametrize("broken_off", [True, False])
def test_at_the_end_it_ends_what_never_returns_and_begins_nothing_more(worker, tmp_path, broken_off):
    """Ctrl-C is for the process above them; and an entrant that is excluded leaves blocks that are not needed."""
    before = family(os.getpid())
    futures = []

    def play():
        with ProcessExecutor(worker("open(f'{__file__}.{os.getpid()}', 'w').close()", "while True: pass"), 2) as both:
            futures.extend(both.submit(BLOCKS[0], {}) for _ in range(5))
            while len(began := list(tmp_path.glob("*.py.*"))) < 2:
                assert not futures[0].done()
            for path in began:
                os.kill(int(path.suffix[1:]), signal.SIGINT)
            if broken_off:
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) if broken_off else nullcontext():
        play()
    assert family(os.getpid()) - before <= helpers()
    assert len(list(tmp_path.glob("*.py.*"))) == 2
    assert all(future.done() for future in futures)


def test_what_nobody_expects_is_told_with_where_it_was_raised(worker):
    with ProcessExecutor(worker("raise KeyboardInterrupt"), 1) as processes:
        future = processes.submit(BLOCKS[0], {})
        with pytest.raises(RuntimeError, match=r"(?s)in a worker process:.*bad\.py.*KeyboardInterrupt"):
            processes.result(future)


def test_an_agent_that_reads_finds_nothing(worker):
    with ProcessExecutor(worker("input()"), 1) as processes:
        ((one, _), _) = processes.result(processes.submit(BLOCKS[0], {}))
    assert one.result.details[0].reason == "act raised EOFError: EOF when reading a line"
