"""Where blocks are played: in this process, or in several on this machine. `on_ray` has a third place."""

import os
import signal
from collections.abc import Sequence
from concurrent.futures import Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import active_children, get_context, parent_process
from threading import Thread
from types import TracebackType
from typing import Final, Protocol, Self

from catch_arena.engine import Engine
from catch_arena.errors import ConfigError, WorkerLost
from catch_arena.tournament.execution.worker import Outcome, Worker
from catch_arena.tournament.plans.schedule import Match

_GRACE_S: Final = 1.0
"""How long workers may go on when a tournament is broken off, before they are ended."""


class Executor(Protocol):
    """Plays blocks side by side; a context, which leaves no process behind."""

    @property
    def ahead(self) -> int:
        """How many blocks it takes before the first must be waited for: enough that no worker is ever idle."""

    def submit(self, matches: Sequence[Match]) -> Future[list[Outcome]]:
        """Begin to play these matches."""

    def outcome(self, future: Future[list[Outcome]]) -> list[Outcome]:
        """What came of it. Raises: WorkerLost where it should be played again."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


class InThisProcess:
    """One block after the other, here."""

    ahead = 1

    def __init__(self, worker: Worker) -> None:
        self._worker = worker

    def submit(self, matches: Sequence[Match]) -> Future[list[Outcome]]:
        """Play them before it returns."""
        future: Future[list[Outcome]] = Future()
        future.set_result(self._worker.play(matches))
        return future

    def outcome(self, future: Future[list[Outcome]]) -> list[Outcome]:
        """What came of it."""
        return future.result()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._worker.close()


class Processes:
    """Several processes on this machine."""

    def __init__(self, worker: Worker, jobs: int) -> None:
        require_jobs(jobs)
        self.ahead = 4 * jobs
        self._worker, self._jobs = worker, jobs
        self._under_way: set[Future[list[Outcome]]] = set()
        self._others = set(active_children())
        Engine(worker.config)  # compiled once here, and read from the cache there
        self._pool = self._new_pool()

    def _new_pool(self) -> ProcessPoolExecutor:
        # spawned, not forked: the rules may have started threads here
        return ProcessPoolExecutor(self._jobs, mp_context=get_context("spawn"), initializer=_follow_the_parent)

    def submit(self, matches: Sequence[Match]) -> Future[list[Outcome]]:
        """Begin to play these matches, in new processes if one of the old ones has died."""
        try:
            future = self._pool.submit(self._worker.play, matches)
        except BrokenProcessPool:
            self._pool.shutdown()
            self._pool = self._new_pool()
            future = self._pool.submit(self._worker.play, matches)
        self._under_way.add(future)
        return future

    def outcome(self, future: Future[list[Outcome]]) -> list[Outcome]:
        """What came of it."""
        self._under_way.discard(future)
        try:
            return future.result()
        except BrokenProcessPool:
            raise WorkerLost("a worker process died") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        running = [future for future in self._under_way if not future.cancel()]
        if wait(running, timeout=_GRACE_S).not_done:
            for process in set(active_children()) - self._others:
                process.terminate()  # an agent may never return
        self._pool.shutdown(cancel_futures=True)


def usable_cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def require_jobs(jobs: int) -> None:
    """Raises: ConfigError for a number of processes that cannot play."""
    if jobs < 1:
        raise ConfigError(f"jobs must be at least 1, got {jobs}")


def _follow_the_parent() -> None:
    """Leave interrupts to the parent, and end when it has ended, however that was."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_the_parent, daemon=True).start()


def _end_with_the_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
