"""The standings on a terminal while a tournament runs."""

import time
from collections.abc import Callable, Sequence
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


class LiveStandings(Live):
    """A context that shows on stderr a bar, and below it the same table as there will be in the end. If stderr is no
    terminal, a line now and then says how far it is.

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
        self._bar = Progress(*bar_columns())
        super().__init__(self._bar, console=console or own_console(err=True), transient=True)
        self._entrants, self._parties, self._total = entrants, parties, total
        self._task = self._bar.add_task("planning", total=total)
        self._clock = clock
        self._next = clock() + _PAUSE_S
        self._lines = {what: progress_lines(what, self.console, clock) for what in ("planning", "playing")}
        self._played: list[PlayedMatch] = []

    def planned(self, matches: int) -> None:
        """Show how many matches are planned: hundreds of agents take minutes."""
        self._show("planning", matches)

    def played(self, more: Sequence[PlayedMatch]) -> None:
        """Count matches that have been played, in whatever order."""
        self._played += more
        self._show("playing", len(self._played))
        begin = self._clock()
        if self.console.is_terminal and begin >= self._next:
            tables = standings_of_sides(self._entrants, self._played, self._parties)
            self.update(Group(self._bar, *standings_tables(tables)))
            end = self._clock()
            self._next = end + max(_PAUSE_S, _PAUSE_FACTOR * (end - begin))

    def _show(self, what: str, done: int) -> None:
        if self.console.is_terminal:
            self._bar.update(self._task, description=what, completed=done)
        else:
            self._lines[what](done, self._total)
