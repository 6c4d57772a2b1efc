"""Executors, which play blocks: in this process, or in several on this machine. `ray_executor` plays on a cluster.

Each process has a copy of the executor's worker, which plays the matches.
"""

import hashlib
import multiprocessing
import os
import signal
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from typing import Any, Final, TypeVar

from catch_arena.config import ArenaConfig
from catch_arena.engine import Engine
from catch_arena.errors import MatchFailedError
from catch_arena.interrupts import LINUX
from catch_arena.streams import outlive_readers
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match import Fault, Match, PlayedMatch
from catch_arena.tournament.match_loop import play_entrants
from catch_arena.tournament.parties import Parties

_Result = TypeVar("_Result")
_DIGEST_BYTES: Final = 16

RecordedMatch = tuple[PlayedMatch, bytes]
"""Played match, and the content of its replay's file; empty if no replay is made."""


@dataclass(frozen=True, slots=True)
class Worker:
    """Player of matches that can be sent to another process, in which it makes new instances of the agents."""

    config: ArenaConfig
    entrants: tuple[Entrant, ...]
    record: bool = False
    """True to make replays."""
    quotas: Quotas | None = None
    """Quotas of isolated agents; None if all are trusted."""

    @property
    def sandbox(self) -> Sandbox | None:
        """Sandbox of its agents, one per process; agents wait in it for the next match. None if all are trusted."""
        return None if self.quotas is None else _sandbox(self.quotas)

    def play_block(self, matches: Iterable[Match], excluded: Mapping[int, Fault]) -> list[RecordedMatch]:
        """Play one match after the other; `excluded` has the reasons for which entrants are not started, by index."""
        parties, played = Parties.of(self.config), []
        for match in matches:
            replay = BytesIO()
            result = play_entrants(
                self.config,
                match.seed,
                [self.entrants[index] for index in match.seating],
                self.sandbox,
                absent={party: excluded[index] for party, index in enumerate(match.seating) if index in excluded},
                agent_seeds=match.agent_seeds,
                title=match.title(parties.block_size),
                record=replay if self.record else None,
                colors=[match.seating[party] for party in parties.by_seat[: self.config.hunters]],
            )
            content = replay.getvalue()
            digest = hashlib.blake2b(content, digest_size=_DIGEST_BYTES).hexdigest() if self.record else None
            played.append((PlayedMatch(match, result, digest), content))
        return played

    def close(self) -> None:
        """End the agents that wait in this process for their next match."""
        if self.sandbox is not None:
            self.sandbox.close()


@cache
def _sandbox(quotas: Quotas) -> Sandbox:
    return Sandbox(quotas)


_NO_MATCHES: Final = Worker(ArenaConfig(), ())  # for an executor of other tasks


class Executor(AbstractContextManager["Executor"]):
    """Executor of one block or other task after the other, in this process; its subclasses do several in parallel.

    Use it as a context manager: its exit ends all processes.
    """

    max_pending = 1
    """Number of blocks that are begun before the first is waited for: enough to keep all workers busy."""

    def __init__(self, worker: Worker = _NO_MATCHES) -> None:
        self.worker = worker
        """Worker that plays each match; it may be replaced while no match is played."""

    def run(self, work: Callable[..., _Result], *arguments: Any) -> Future[_Result]:
        """Call a function, now or when a process is idle; it and its arguments can be sent to another process."""
        future: Future[_Result] = Future()
        try:
            future.set_result(work(*arguments))
        except MatchFailedError as error:
            future.set_exception(error)
        return future

    def result(self, future: Future[_Result]) -> _Result:
        """Return the result of submitted work; raise MatchFailedError if it failed on our side."""
        return future.result()

    def close(self) -> None:
        """End all processes, also while they play."""
        self.worker.close()

    def __exit__(self, *_: object) -> None:
        self.close()


class ProcessExecutor(Executor):
    """Executor with several processes on this machine."""

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
        """Return the result of submitted work; raise MatchFailedError if it failed on our side, or its process died."""
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
        try:
            return ProcessPoolExecutor(self._jobs, multiprocessing.get_context("spawn"), _begin_process)
        except OSError as error:  # the processes share semaphores
            hint = "; -j 1 needs none" if self._jobs > 1 else ""
            raise MatchFailedError(f"processes need a writable /dev/shm: {error.strerror}{hint}") from None


def local_executor(worker: Worker, jobs: int) -> Executor:
    """Return the executor for this number of processes on this machine."""
    return Executor(worker) if jobs == 1 else ProcessExecutor(worker, jobs)


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
    parent = multiprocessing.parent_process()
    if parent is None or not hasattr(signal, "SIGIO"):  # Windows
        return
    import fcntl

    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    # a Python function waits for the end of compiled code; macOS needs one, as it ignores the signal otherwise
    signal.signal(signal.SIGIO, signal.SIG_DFL if LINUX else lambda *_: os._exit(1))
    fcntl.fcntl(parent.sentinel, fcntl.F_SETOWN, os.getpid())  # a pipe that ends with the parent, and raises SIGIO then
    fcntl.fcntl(parent.sentinel, fcntl.F_SETFL, fcntl.fcntl(parent.sentinel, fcntl.F_GETFL) | os.O_ASYNC)
    if not parent.is_alive():
        os._exit(1)
