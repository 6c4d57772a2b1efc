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


def add_to_logs(folder: Path, entrants: Sequence[Entrant], parties: Parties, one: PlayedMatch) -> None:
    """Add what each party of a match printed, and how it failed; the folder is made when there is something to add.

    Raises:
        OutputError: where it cannot be written.
    """
    for party, index in enumerate(one.match.seating):
        forfeit, printed = one.result.details[party], one.result.logs[party]
        if forfeit is not None or printed:
            why = f": {forfeit}" if forfeit is not None else ""
            where = f"match {one.match.id}, {parties.called(party)}"
            _append(folder, entrants[index].name, f"== {where}{why}\n{printed}")


def _append(folder: Path, name: str, text: str) -> None:
    *folders, last = name.split("/")  # as ann/agent has
    path = Path(folder, *folders, f"{last.encode()[:_LONGEST].decode(errors='ignore')}.log")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("ab") as file:
            if file.tell() < MOST_BYTES:
                file.write(text.encode() + (b"" if text.endswith("\n") else b"\n"))
    except OSError as error:
        raise unwritable(path, error, len(text)) from None
