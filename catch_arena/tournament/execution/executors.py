"""Where blocks are played: in this process, or in several on this machine. `ray_executor` has a third place."""

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from queue import Empty, SimpleQueue
from threading import Lock
from types import TracebackType
from typing import Protocol

from catch_arena.descendants import end, family
from catch_arena.engine import Engine
from catch_arena.errors import ConfigError, NoContest, WorkerLost
from catch_arena.tournament.execution.worker import Excluded, RecordedMatch, Worker
from catch_arena.tournament.execution.worker_process import WorkerProcess
from catch_arena.tournament.isolation.newcomers import kill_newcomers, no_newcomers_left
from catch_arena.tournament.match import Match


class Executor(Protocol):
    """Plays blocks side by side; a context, which leaves no process behind."""

    @property
    def worker(self) -> Worker:
        """How each match is played."""

    @property
    def max_pending(self) -> int:
        """How many blocks it takes before the first must be waited for: enough that no worker is ever idle."""

    @property
    def tolerated_losses(self) -> int:
        """How many workers may be lost with a block before agents are suspected: where machines may be lost."""

    def submit(self, matches: Sequence[Match], excluded: Excluded) -> Future[list[RecordedMatch]]:
        """Begin to play these matches, without the entrants that are `excluded`."""

    def result(self, future: Future[list[RecordedMatch]]) -> list[RecordedMatch]:
        """What came of it.

        Raises:
            WorkerLost: where it should be played again.
        """

    def stop_agents(self) -> None:
        """End all that agents run on this machine; nothing of what was begun is waited for. More may be begun then."""

    def process(self) -> AbstractContextManager[WorkerProcess]:
        """A process on this machine that plays nothing, for as long as the context lasts."""

    def __enter__(self) -> "Executor": ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


class SerialExecutor:
    """One block after the other, in this process."""

    max_pending = 1
    tolerated_losses = 0

    def __init__(self, worker: Worker) -> None:
        self.worker = worker

    def use_worker(self, worker: Worker) -> None:
        """From here on play as this worker does."""
        self.worker = worker

    def submit(self, matches: Sequence[Match], excluded: Excluded) -> Future[list[RecordedMatch]]:
        """Play them before it returns."""
        future: Future[list[RecordedMatch]] = Future()
        future.set_result(self.worker.play(matches, excluded))
        return future

    def result(self, future: Future[list[RecordedMatch]]) -> list[RecordedMatch]:
        """What came of it."""
        return future.result()

    def stop_agents(self) -> None:
        """End the agents that wait for their next match."""
        self.worker.close()

    def process(self) -> AbstractContextManager[WorkerProcess]:
        """A process on this machine that plays nothing."""
        return fresh_process(self.worker)

    def __enter__(self) -> "SerialExecutor":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop_agents()


class ProcessExecutor:
    """Several processes on this machine; a thread here waits for each."""

    tolerated_losses = 0

    def __init__(self, worker: Worker, jobs: int) -> None:
        require_jobs(jobs)
        self.max_pending = 4 * jobs
        self.worker = worker
        Engine(worker.config)  # compiled once here, and read from the cache there
        self._threads = ThreadPoolExecutor(jobs, "catch-arena-worker")
        self._lock = Lock()
        self._processes: list[WorkerProcess] | None = []
        """All that were started; None once no more may be."""
        self._idle: SimpleQueue[WorkerProcess] = SimpleQueue()
        self._before: set[int] = set()
        self._context = ExitStack()

    def use_worker(self, worker: Worker) -> None:
        """From here on play as this worker does, in the processes that there are: starting them takes seconds. Nothing
        must be under way, and its limits must be those of the one before.
        """
        self.worker = worker
        Engine(worker.config)
        for process in self._take_idle():
            process.use_worker(worker)
            self._idle.put(process)

    def submit(self, matches: Sequence[Match], excluded: Excluded) -> Future[list[RecordedMatch]]:
        """Begin to play these matches, when one of the processes is idle or can be started."""
        return self._threads.submit(self._play, matches, excluded)

    def result(self, future: Future[list[RecordedMatch]]) -> list[RecordedMatch]:
        """What came of it."""
        return future.result()

    def stop_agents(self) -> None:
        """End the agents that wait for their next match, and what others have left that killed the process above them.

        Processes that still play are ended: what they play is waited for by nobody.
        """
        idle = self._take_idle()
        end([process.pid for process in self._processes or () if process not in idle and process.lives])
        for process in idle:
            with suppress(WorkerLost):
                process.stop_agents()
                self._idle.put(process)
        if self.worker.limits is not None:
            living = [process.pid for process in idle if process.lives]
            kill_newcomers(self._before | {*living} | family(*living))

    @contextmanager
    def process(self) -> Iterator[WorkerProcess]:
        """A process on this machine that plays nothing."""
        process = self._idle_or_new()
        try:
            yield process
        except NoContest:  # after anything else nobody waits for what it plays
            self._idle.put(process)
            raise
        self._idle.put(process)

    def __enter__(self) -> "ProcessExecutor":
        self._before = family(os.getpid())
        if self.worker.limits is not None:
            self._context.enter_context(no_newcomers_left())
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._lock:
            processes, self._processes = self._processes or [], None
        self._threads.shutdown(wait=False, cancel_futures=True)
        idle = self._take_idle()
        # nobody waits any more for what the others play, and an agent may never return
        end([process.pid for process in processes if process not in idle and process.lives])
        self._threads.shutdown()
        for process in processes:
            process.let_go()
        for process in processes:
            process.wait()
        self._context.close()

    def _play(self, matches: Sequence[Match], excluded: Excluded) -> list[RecordedMatch]:
        process = self._idle_or_new()
        try:
            return process.play(matches, excluded)
        finally:
            self._idle.put(process)

    def _take_idle(self) -> list[WorkerProcess]:
        return [self._idle.get() for _ in range(self._idle.qsize())]

    def _idle_or_new(self) -> WorkerProcess:
        try:
            while not (process := self._idle.get_nowait()).lives:
                pass
        except Empty:
            return self._start()
        return process

    def _start(self) -> WorkerProcess:
        with self._lock:
            if self._processes is None:
                raise NoContest("the matches were broken off")
            self._processes.append(process := WorkerProcess(self.worker))
        return process


def local_executor(worker: Worker, jobs: int) -> SerialExecutor | ProcessExecutor:
    """What plays in so many processes on this machine; agents that are not trusted are kept out of this one, which
    would end with what they kill.
    """
    return SerialExecutor(worker) if jobs == 1 and worker.limits is None else ProcessExecutor(worker, jobs)


@contextmanager
def fresh_process(worker: Worker) -> Iterator[WorkerProcess]:
    """One that ends with the context, and all that descends from it."""
    process = WorkerProcess(worker)
    try:
        yield process
    finally:
        if process.lives:
            end([process.pid])
        process.let_go()
        process.wait()


def usable_cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def require_jobs(jobs: int) -> None:
    """Require at least one process.

    Raises:
        ConfigError: for a number of processes that cannot play.
    """
    if jobs < 1:
        raise ConfigError(f"jobs must be at least 1, got {jobs}")
