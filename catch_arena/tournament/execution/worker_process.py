"""A process that plays blocks for the one that started it: both sides of the socket between them."""

import os
import time
import traceback
from collections.abc import Mapping, Sequence
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from queue import SimpleQueue
from threading import Thread
from typing import Any, Final

from catch_arena.descendants import start
from catch_arena.errors import CatchArenaError, NoContest, WorkerLost
from catch_arena.tournament.execution.worker import RecordedMatch, Worker
from catch_arena.tournament.match import Match

_GRACE_S: Final = 1.0
"""How long a match may go on that nobody waits for any more."""


class WorkerProcess:
    """Plays blocks, one at a time. It ends when this process does, however that ends. Raises: NoContest."""

    def __init__(self, worker: Worker) -> None:
        self._channel, theirs = Pipe()
        with theirs:
            try:
                self._process = start(__name__, theirs.fileno())
            except OSError as error:
                raise NoContest(f"a worker process cannot be started: {error.strerror}") from None
        with suppress(OSError):  # if it has died already, `play` says so
            self._channel.send(worker)

    @property
    def pid(self) -> int:
        """The process's id."""
        return self._process.pid

    @property
    def lives(self) -> bool:
        """Whether it has not ended yet."""
        return self._process.poll() is None

    def play(self, matches: Sequence[Match], excluded: Mapping[int, str]) -> list[RecordedMatch]:
        """The matches that were played, without those who are `excluded`.

        What was raised there is raised here.

        Raises:
            WorkerLost: where the process has died.
        """
        try:
            self._channel.send((matches, excluded))
            answer: list[RecordedMatch] | Exception = self._channel.recv()
        except (EOFError, OSError):
            self.let_go()
            self.wait()
            raise WorkerLost("a worker process died") from None
        if isinstance(answer, Exception):
            raise answer
        return answer

    def let_go(self) -> None:
        """It ends when it has nothing to play."""
        self._channel.close()

    def wait(self) -> None:
        """Return when it has ended."""
        self._process.wait()


def main() -> None:
    """Play what is requests for until the other side goes."""
    channel: Connection = Connection(os.dup(0))
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)  # agents that read from the standard input find it empty
    os.close(nothing)
    requests: SimpleQueue[Any] = SimpleQueue()
    Thread(target=_read_requests, args=(channel, requests), daemon=True).start()
    worker: Worker | None = requests.get()
    if worker is None:
        return
    while (block := requests.get()) is not None:
        answer: list[RecordedMatch] | Exception
        try:
            answer = worker.play(*block)
        except CatchArenaError as error:
            answer = error
        except BaseException:  # noqa: BLE001 - a trusted agent may raise anything
            answer = RuntimeError(f"in a worker process:\n{traceback.format_exc()}")
        with suppress(OSError):  # nobody may be there any more
            channel.send(answer)
    worker.close()


def _read_requests(channel: Connection, requests: SimpleQueue[Any]) -> None:
    """First the worker, then matches and who is excluded from them; None when the other side has gone."""
    try:
        while True:
            requests.put(channel.recv())
    except (EOFError, OSError):
        requests.put(None)
        time.sleep(_GRACE_S)
        os._exit(1)
