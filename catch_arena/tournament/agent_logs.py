"""What agents printed, and how they failed: a file for each, which grows match by match up to a limit."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from catch_arena.files import unwritable
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import PlayedMatch
from catch_arena.tournament.parties import Parties

MOST_BYTES: Final = 4 << 20
"""Of one agent's file; the next match is the last that is added."""
_LONGEST: Final = 240
"""Bytes of a file's name, its ending left out."""


class AgentLogs:
    """The folder of these files, which is made when there is something to say."""

    def __init__(self, folder: Path, entrants: Sequence[Entrant], parties: Parties) -> None:
        self._folder = folder
        self._entrants = entrants
        self._parties = parties

    def add(self, one: PlayedMatch) -> None:
        """Of each party that forfeited or printed: what.

        Raises:
            OutputError: where it cannot be written.
        """
        for party, index in enumerate(one.match.seating):
            forfeit, printed = one.result.details[party], one.result.logs[party]
            if forfeit is not None or printed:
                why = f": {forfeit}" if forfeit is not None else ""
                where = f"match {one.match.id}, {self._parties.called(party)}"
                self._append(self._entrants[index].name, f"== {where}{why}\n{printed}")

    def _append(self, name: str, text: str) -> None:
        *folders, last = name.split("/")  # as ann/agent has
        path = Path(self._folder, *folders, f"{_cut(last)}.log")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("ab") as file:
                if file.tell() < MOST_BYTES:
                    file.write(text.encode() + (b"" if text.endswith("\n") else b"\n"))
        except OSError as error:
            raise unwritable(path, error, len(text)) from None


def _cut(name: str) -> str:
    return name.encode()[:_LONGEST].decode(errors="ignore")
