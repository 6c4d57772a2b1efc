"""Isolated agents apart from each other: who does harm then has done it alone.

Each has a supervisor of its own, and one at a time has its turn: all others stand still. What is harmed in a turn was
harmed by the agent whose turn it was, whatever it did that with; so this finds culprits, where agents that run all at
once leave only suspects. It is slower, and the results are the same.
"""

import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import MappingProxyType
from typing import Final, NamedTuple, TypeVar

from catch_arena.errors import NoContest, Stalled
from catch_arena.files import is_full
from catch_arena.policy import AnyLimits
from catch_arena.tournament.entrants import Entrant, Inspection
from catch_arena.tournament.isolation.freezer import Freezer
from catch_arena.tournament.isolation.isolated_players import IsolatedPlayers
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.newcomers import no_newcomers_left
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.players import Answer, Fault, Observation

PAUSES_S: Final = (0.0, 1.0, 5.0)
"""How long we wait before a match is begun again that we failed to hold, and how often it is begun."""

_Result = TypeVar("_Result")


class Apart(NamedTuple):
    """How isolated agents are kept apart from each other: the arguments of ApartPlayers."""

    on_turn: Callable[[int], None]
    disks: Mapping[str, Path]


class Sabotage(NoContest):
    """An agent has harmed others, or what holds the match: without it the match may be played again.

    Args:
        seat: its own.
        what: it did.
    """

    def __init__(self, seat: int, what: str) -> None:
        super().__init__(seat, what)
        self.seat, self.what = seat, what


class _Seat:
    """An agent, and all that is there for it alone."""

    def __init__(self, seat: int, entrant: Entrant, limits: AgentLimits) -> None:
        self.name = entrant.name
        self.sandbox = Sandbox(limits)
        self.players = IsolatedPlayers(self.sandbox, {seat: entrant})
        self.freezer: Freezer | None = None
        """None before its first turn."""

    def close(self) -> None:
        self.players.close()
        self.sandbox.close()


class _Disk:
    """How much of a disk each seat has taken."""

    def __init__(self, name: str, folder: Path) -> None:
        self.name = name
        self._folder = folder
        self._free_at_first = self._before = self._free()
        self._was_full = is_full(folder)
        self._taken: Counter[int] = Counter()

    def begin_turn(self) -> None:
        """Somebody may write from here on."""
        self._before = self._free()

    def end_turn(self, seat: int) -> int | None:
        """The seat has written.

        Returns:
            which one has filled the disk: it has taken the most of all, and more than half of the room there was.
        """
        free = self._free()
        self._taken[seat] += max(0, self._before - free)
        if self._was_full or not is_full(self._folder):
            return None
        ((most, taken),) = self._taken.most_common(1)
        return most if 2 * taken > self._free_at_first - free else None

    def _free(self) -> int:
        with suppress(OSError):
            return shutil.disk_usage(self._folder).free
        return 0


class ApartPlayers:
    """Entrants in seats of one match, each with a supervisor of its own, of whom one at a time runs.

    Args:
        entrants: by seat.
        limits: of each.
        on_turn: called with a seat before it runs.
        disks: folders whose disks nobody may fill, by what is said of them.
    """

    def __init__(
        self,
        entrants: Mapping[int, Entrant],
        limits: AgentLimits,
        on_turn: Callable[[int], None],
        disks: Mapping[str, Path],
    ) -> None:
        self._seats = {seat: _Seat(seat, entrant, limits) for seat, entrant in entrants.items()}
        self.controls = {seat: entrant.control for seat, entrant in entrants.items()}
        self._in_play = set(entrants)
        self._on_turn = on_turn
        self._disks = [_Disk(name, folder) for name, folder in disks.items()]

    def reset(self, seeds: Sequence[int], limits: Sequence[AnyLimits]) -> dict[int, Fault]:
        """Begin a match."""
        faults: dict[int, Fault] = {}
        for seat, one in self._seats.items():
            with self._turn(seat):
                faults |= one.players.reset(seeds, limits)
        return faults

    def act(self, observations: Mapping[int, Observation]) -> dict[int, Answer]:
        """Ask these seats for their actions, one after the other."""
        answers: dict[int, Answer] = {}
        for seat, observation in observations.items():
            with self._turn(seat):
                answers |= self._seats[seat].players.act({seat: observation})
        return answers

    def inspect(self, seat: int) -> Inspection:
        """What the agent in that seat says of itself."""
        with self._turn(seat):
            return self._seats[seat].players.inspect()

    def drop(self, seat: int) -> None:
        """End that agent, and all that it started."""
        self._in_play.discard(seat)
        self._seats[seat].sandbox.close()

    def logs(self) -> dict[int, str]:
        """What each seat has printed."""
        return {seat: log for one in self._seats.values() for seat, log in one.players.logs().items()}

    def close(self) -> None:
        """End all agents."""
        for one in self._seats.values():
            one.close()

    @contextmanager
    def _turn(self, seat: int) -> Iterator[None]:
        """Let that agent run, and no other.

        Raises:
            Sabotage: where it did harm.
            NoContest: where the match cannot go on, and nobody knows by whose fault.
        """
        if harm := self._harm(None):
            raise NoContest(f"{harm} while no agent ran")
        one = self._seats[seat]
        if one.freezer is None:
            one.freezer = Freezer(one.sandbox.pid)
        for disk in self._disks:
            disk.begin_turn()
        self._on_turn(seat)
        one.freezer.thaw()
        failed: NoContest | None = None
        try:
            yield
        except NoContest as error:
            failed = error
        stopped = one.sandbox.has_stopped()
        if not one.freezer.freeze():
            raise Stalled(f"a process of {one.name} does not stand still")
        if harm := self._harm(seat) or ("its supervisor was stopped" if stopped else ""):
            raise Sabotage(seat, f"{harm} while no other agent ran")
        if failed is not None:
            raise failed
        for disk in self._disks:
            if (writer := disk.end_turn(seat)) is not None:
                raise Sabotage(writer, f"{disk.name} was filled while no other agent ran")

    def _harm(self, ran: int | None) -> str:
        """What was done to those who stand still, in words, as of the seat that ran."""
        for seat in self._in_play:
            one = self._seats[seat]
            lost = None if one.freezer is None else one.freezer.lost()
            if lost is not None:
                what = "supervisor" if lost == one.sandbox.pid else "process"
                whose = f"its {what}" if seat == ran else f"the {what} of {one.name}"
                return f"{whose} was ended, or made to run,"
        return ""


@contextmanager
def players_apart(entrants: Mapping[int, Entrant], limits: AgentLimits, apart: Apart) -> Iterator[ApartPlayers]:
    """Isolated agents by seat, for one match, of whom one at a time thinks."""
    players = ApartPlayers(entrants, limits, apart.on_turn, apart.disks)
    try:
        yield players
    finally:
        players.close()


def attempt_apart(
    attempt: Callable[[Apart], _Result],
    on_turn: Callable[[int], None] | None = None,
    disks: Mapping[str, Path] = MappingProxyType({}),
) -> _Result:
    """What comes of an attempt with agents apart, which is repeated where we failed ourselves.

    An agent in whose turn we stand still each time has done that; no process that it started runs on.
    """
    stalls: Counter[int] = Counter()
    failed, runs = 0, -1

    def begin_turn(seat: int) -> None:
        nonlocal runs
        runs = seat
        if on_turn is not None:
            on_turn(seat)

    apart = Apart(begin_turn, {"the disk of the agents' folders": Path(tempfile.gettempdir()), **disks})
    while True:
        try:
            with no_newcomers_left():
                return attempt(apart)
        except Sabotage:
            raise
        except Stalled as error:
            stalls[runs] += 1
            if stalls[runs] == len(PAUSES_S):
                raise Sabotage(runs, f"{error}, each time, while no other agent ran") from None
            time.sleep(PAUSES_S[stalls[runs]])
        except NoContest:
            failed += 1
            if failed == len(PAUSES_S):
                raise
            time.sleep(PAUSES_S[failed])
