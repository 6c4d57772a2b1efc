"""A process that plays blocks for the one that started it: both sides of the socket between them."""

import os
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from queue import SimpleQueue
from threading import Thread
from typing import Any, Final, NamedTuple

from catch_arena.descendants import end, start, state
from catch_arena.errors import CatchArenaError, NoContest, WorkerLost
from catch_arena.streams import outlive_readers
from catch_arena.tournament.execution.worker import Excluded, RecordedMatch, Worker
from catch_arena.tournament.isolation.newcomers import kill_newcomers
from catch_arena.tournament.isolation.processes import adopt_orphans
from catch_arena.tournament.match import Match

_GRACE_S: Final = 1.0
"""How long a match may go on that nobody waits for any more."""


_POLL_S: Final = 1.0
"""How often one that says nothing is looked at."""
_GONE: Final = "gone"
"""What stands for the end of requests."""


class _PlayRequest(NamedTuple):
    """A request: these matches."""

    matches: Sequence[Match]
    excluded: Excluded
    rest: bool = False
    """Whether no agent is to live on afterwards."""


class _TrialRequest(NamedTuple):
    """A request: these matches, isolated agents one at a time."""

    matches: Sequence[Match]
    excluded: Excluded
    disks: Mapping[str, Path]


class WorkerProcess:
    """Plays blocks, one at a time. It ends when this process does, however that ends.

    Raises:
        NoContest: where it cannot be started.
    """

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

    def use_worker(self, worker: Worker) -> None:
        """From here on it plays as this worker does, whose limits are those of the one before. It must be idle."""
        with suppress(OSError):  # as above
            self._channel.send(worker)

    def play(self, matches: Sequence[Match], excluded: Excluded) -> list[RecordedMatch]:
        """The matches that were played, without those who are `excluded`.

        What was raised there is raised here.

        Raises:
            WorkerLost: where the process has died.
        """
        return self._answer(_PlayRequest(matches, excluded), None)

    def play_apart(
        self, matches: Sequence[Match], excluded: Excluded, on_turn: Callable[[int], None], disks: Mapping[str, Path]
    ) -> list[RecordedMatch]:
        """The same, as of `Worker.play_apart`: no agent runs before `on_turn` has returned."""
        return self._answer(_TrialRequest(matches, excluded, disks), on_turn)

    def stop_agents(self) -> None:
        """End the agents that wait there for their next match.

        Raises:
            WorkerLost: where the process has died.
        """
        self._answer(_PlayRequest((), {}, rest=True), None)

    def _answer(
        self, request: "_PlayRequest | _TrialRequest", on_turn: Callable[[int], None] | None
    ) -> list[RecordedMatch]:
        try:
            self._channel.send(request)
            while isinstance(answer := self._heard(), int):
                if on_turn is not None:
                    on_turn(answer)
                self._channel.send(None)
        except (EOFError, OSError):
            self.let_go()
            self.wait()
            raise WorkerLost("a worker process died") from None
        if isinstance(answer, Exception):
            raise answer
        return answer

    def _heard(self) -> list[RecordedMatch] | Exception | int:
        """What it says, however long that takes; one that was stopped would never say anything, and is ended."""
        while not self._channel.poll(_POLL_S):
            if state(self.pid) == "T":
                end([self.pid])
                raise EOFError
        heard: list[RecordedMatch] | Exception | int = self._channel.recv()
        return heard

    def let_go(self) -> None:
        """It ends when it has nothing to play."""
        self._channel.close()

    def wait(self) -> None:
        """Return when it has ended."""
        self._process.wait()


def main() -> None:
    """Play what is requests for until the other side goes."""
    outlive_readers()
    channel: Connection = Connection(os.dup(0))
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)  # agents that read from the standard input find it empty
    os.close(nothing)
    requests: SimpleQueue[Any] = SimpleQueue()
    Thread(target=_read_requests, args=(channel, requests), daemon=True).start()
    worker = requests.get()
    if worker is _GONE:
        return
    if worker.limits is not None:
        adopt_orphans()

    def begin_turn(index: int) -> None:
        channel.send(index)
        if requests.get() is _GONE:
            raise NoContest("nobody waits any more")

    while (request := requests.get()) is not _GONE:
        if isinstance(request, Worker):
            worker = request
            continue
        answer: list[RecordedMatch] | Exception
        try:
            if isinstance(request, _TrialRequest):
                answer = worker.play_apart(request.matches, request.excluded, begin_turn, request.disks)
            else:
                answer = worker.play(request.matches, request.excluded)
                if request.rest:
                    worker.close()
        except NoContest as error:
            answer = error
            worker.close()
            if worker.limits is not None:
                kill_newcomers(set())  # those, too, whose supervisor was killed
        except CatchArenaError as error:
            answer = error
        except BaseException:  # noqa: BLE001 - a trusted agent may raise anything
            answer = RuntimeError(f"in a worker process:\n{traceback.format_exc()}")
        with suppress(OSError):  # nobody may be there any more
            channel.send(answer)
    worker.close()


def _read_requests(channel: Connection, requests: SimpleQueue[Any]) -> None:
    """First the worker, then what is to be played, and None for each turn that may begin; _GONE at last."""
    try:
        while True:
            requests.put(channel.recv())
    except (EOFError, OSError):
        requests.put(_GONE)
        time.sleep(_GRACE_S)
        os._exit(1)
