"""Executors, which play blocks: in this process, or in several on this machine. `ray_executor` plays on a cluster."""

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import cache
from threading import Thread
from typing import Any, TypeVar

from catch_arena.config import ArenaConfig
from catch_arena.engine import Engine
from catch_arena.errors import MatchFailedError
from catch_arena.streams import outlive_readers
from catch_arena.tournament.execution.worker import RecordedMatch, Worker
from catch_arena.tournament.match import Fault, Match

_Result = TypeVar("_Result")


class Executor:
    """Executor of one block after the other, in this process; its subclasses play several in parallel.

    Use it as a context manager: its exit ends all processes.
    """

    max_pending = 1
    """Number of blocks that are begun before the first is waited for: enough to keep all workers busy."""

    def __init__(self, worker: Worker) -> None:
        self.worker = worker
        """Worker that plays each match; it may be replaced while no match is played."""

    def submit(self, matches: Sequence[Match], excluded: Mapping[int, Fault]) -> Future[list[RecordedMatch]]:
        """Begin to play these matches, without the entrants that are `excluded`."""
        return self.run(self.worker.play_block, matches, excluded)

    def run(self, work: Callable[..., _Result], *arguments: Any) -> Future[_Result]:
        """Begin to call a function with these arguments; all of them can be sent to another process."""
        future: Future[_Result] = Future()
        try:
            future.set_result(work(*arguments))
        except MatchFailedError as error:
            future.set_exception(error)
        return future

    def result(self, future: Future[_Result]) -> _Result:
        """Return the result of submitted work.

        Raises:
            MatchFailedError: if the work failed on our side.
        """
        return future.result()

    def close(self) -> None:
        """End all processes, also while they play."""
        self.worker.close()

    def __enter__(self) -> "Executor":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class ProcessExecutor(Executor):
    """Executor with several processes on this machine.

    Args:
        worker: plays the matches in each process.
        jobs: number of processes.
    """

    def __init__(self, worker: Worker, jobs: int) -> None:
        super().__init__(worker)
        self.max_pending = 4 * jobs
        self._jobs = jobs
        self._pool = self._new_pool()

    def run(self, work: Callable[..., _Result], *arguments: Any) -> Future[_Result]:
        """Begin to call a function as soon as one of the processes is idle."""
        _compile(self.worker.config)  # once here; worker processes read it from the cache
        with _signals_held():  # new processes hold signals until they have begun
            try:
                return self._pool.submit(work, *arguments)
            except BrokenProcessPool:
                self.close()
                self._pool = self._new_pool()
                return self._pool.submit(work, *arguments)

    def result(self, future: Future[_Result]) -> _Result:
        """Return the result of submitted work.

        Raises:
            MatchFailedError: if the work failed on our side, or a worker process died.
        """
        try:
            return future.result()
        except BrokenProcessPool:
            raise MatchFailedError(
                "a worker process died: a trusted agent may have ended it, or memory ran out"
            ) from None

    def close(self) -> None:
        """End all processes, also while they play; the agents in them end with them."""
        processes = list((self._pool._processes or {}).values())  # noqa: SLF001 - Python 3.14 has terminate_workers()
        for process in processes:
            process.terminate()
        self._pool.shutdown(cancel_futures=True)

    def _new_pool(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(self._jobs, multiprocessing.get_context("spawn"), _begin_process)


def local_executor(worker: Worker, jobs: int) -> Executor:
    """Return the executor for this number of processes on this machine."""
    return Executor(worker) if jobs == 1 else ProcessExecutor(worker, jobs)


def usable_cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def _compile(config: ArenaConfig) -> None:
    Engine(config)


@contextmanager
def _signals_held() -> Iterator[None]:
    """Block Ctrl-C: a process that starts meanwhile blocks it too, until `_begin_process` ignores it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin_process() -> None:
    """Ignore Ctrl-C, which the parent process handles, and end when the parent ends for any reason."""
    outlive_readers()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})

    def end_with_parent() -> None:
        if (parent := multiprocessing.parent_process()) is not None:
            parent.join()
        os._exit(1)

    Thread(target=end_with_parent, daemon=True).start()
