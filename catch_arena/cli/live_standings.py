"""The standings on a terminal while a tournament runs."""

import time
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Final

from rich.console import Console, Group
from rich.live import Live
from rich.progress import Progress

from catch_arena.cli.progress import bar_columns, progress_lines
from catch_arena.cli.tables import standings_tables
from catch_arena.cli.terminal import own_console
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.statistics.standings import standings_of_sides

_PAUSE_S: Final = 1.0
_PAUSE_FACTOR: Final = 20.0
"""The table is made again after so many times what it took to make: at most a twentieth of one core's time."""


class LiveStandings:
    """A context that shows the same table as there will be in the end, below a bar, on stderr; what a low terminal has
    no room for is the end of the table. Where it is no terminal, a line now and then says how far it is.

    Args:
        entrants: who plays.
        parties: those of the arena.
        total: the matches to be played, at most.
    """

    def __init__(
        self,
        entrants: Sequence[Entrant],
        parties: Parties,
        total: int,
        *,
        console: Console | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._entrants = entrants
        self._parties = parties
        self._console = console or own_console(err=True)
        self._clock = clock
        self._played: list[PlayedMatch] = []
        self._total = total
        self._say = progress_lines("playing", self._console, clock)
        self._say_planned = progress_lines("planning", self._console, clock)
        self._next = clock() + _PAUSE_S
        self._bar = Progress(*bar_columns())
        self._task = self._bar.add_task("playing", total=total)
        self._live = Live(self._bar, console=self._console, transient=True)

    def planned(self, matches: int) -> None:
        """Show how many matches are planned: hundreds of agents take minutes."""
        if self._console.is_terminal:
            self._bar.update(self._task, description="planning", completed=matches)
        else:
            self._say_planned(matches, self._total)

    def update(self, played: Sequence[PlayedMatch]) -> None:
        """More matches have been played, in whatever order."""
        self._played += played
        if not self._console.is_terminal:
            self._say(len(self._played), self._total)
            return
        self._bar.update(self._task, description="playing", completed=len(self._played))
        begin = self._clock()
        if begin < self._next:
            return
        tables = standings_of_sides(self._entrants, self._played, self._parties)
        self._live.update(Group(self._bar, *standings_tables(tables)))
        end = self._clock()
        self._next = end + max(_PAUSE_S, _PAUSE_FACTOR * (end - begin))

    def __enter__(self) -> "LiveStandings":
        if self._console.is_terminal:
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._live.stop()
