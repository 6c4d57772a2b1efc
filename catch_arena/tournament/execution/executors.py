"""Where blocks are played: in this process, or in several on this machine. `ray_executor` has a third place."""

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from queue import Empty, SimpleQueue
from threading import Lock
from types import TracebackType
from typing import Protocol, Self

from catch_arena.descendants import end
from catch_arena.engine import Engine
from catch_arena.errors import ConfigError, NoContest
from catch_arena.tournament.execution.worker import RecordedMatch, Worker
from catch_arena.tournament.execution.worker_process import WorkerProcess
from catch_arena.tournament.match import Match


class Executor(Protocol):
    """Plays blocks side by side; a context, which leaves no process behind."""

    @property
    def lookahead(self) -> int:
        """How many blocks it takes before the first must be waited for: enough that no worker is ever idle."""

    def submit(self, matches: Sequence[Match], excluded: Mapping[int, str]) -> Future[list[RecordedMatch]]:
        """Begin to play these matches, without the entrants that are `excluded`: by index, and why."""

    def result(self, future: Future[list[RecordedMatch]]) -> list[RecordedMatch]:
        """What came of it. Raises: WorkerLost where it should be played again."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


class SerialExecutor:
    """One block after the other, in this process."""

    lookahead = 1

    def __init__(self, worker: Worker) -> None:
        self._worker = worker

    def submit(self, matches: Sequence[Match], excluded: Mapping[int, str]) -> Future[list[RecordedMatch]]:
        """Play them before it returns."""
        future: Future[list[RecordedMatch]] = Future()
        future.set_result(self._worker.play(matches, excluded))
        return future

    def result(self, future: Future[list[RecordedMatch]]) -> list[RecordedMatch]:
        """What came of it."""
        return future.result()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._worker.close()


class ProcessExecutor:
    """Several processes on this machine; a thread here waits for each."""

    def __init__(self, worker: Worker, jobs: int) -> None:
        require_jobs(jobs)
        self.lookahead = 4 * jobs
        self._worker = worker
        Engine(worker.config)  # compiled once here, and read from the cache there
        self._threads = ThreadPoolExecutor(jobs, "catch-arena-worker")
        self._lock = Lock()
        self._processes: list[WorkerProcess] | None = []
        """All that were started; None once no more may be."""
        self._idle: SimpleQueue[WorkerProcess] = SimpleQueue()

    def submit(self, matches: Sequence[Match], excluded: Mapping[int, str]) -> Future[list[RecordedMatch]]:
        """Begin to play these matches, when one of the processes is idle or can be started."""
        return self._threads.submit(self._play, matches, excluded)

    def result(self, future: Future[list[RecordedMatch]]) -> list[RecordedMatch]:
        """What came of it."""
        return future.result()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._lock:
            processes, self._processes = self._processes or [], None
        self._threads.shutdown(wait=False, cancel_futures=True)
        idle = [self._idle.get() for _ in range(self._idle.qsize())]
        # nobody waits any more for what the others play, and an agent may never return
        end([process.pid for process in processes if process not in idle and process.lives])
        self._threads.shutdown()
        for process in processes:
            process.let_go()
        for process in processes:
            process.wait()

    def _play(self, matches: Sequence[Match], excluded: Mapping[int, str]) -> list[RecordedMatch]:
        try:
            process = self._idle.get_nowait()
        except Empty:
            process = self._start()
        played = process.play(matches, excluded)
        self._idle.put(process)
        return played

    def _start(self) -> WorkerProcess:
        with self._lock:
            if self._processes is None:
                raise NoContest("the matches were broken off")
            self._processes.append(process := WorkerProcess(self._worker))
        return process


def usable_cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def require_jobs(jobs: int) -> None:
    """

    Raises:
        ConfigError: for a number of processes that cannot play.
    """
    if jobs < 1:
        raise ConfigError(f"jobs must be at least 1, got {jobs}")
