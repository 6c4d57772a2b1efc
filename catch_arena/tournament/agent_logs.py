"""Log files of agents: the output and the faults of each agent, added match by match up to a limit."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from catch_arena.files import unwritable
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.match import PlayedMatch
from catch_arena.tournament.parties import Parties

MOST_BYTES: Final = 4 << 20
"""Size of an agent's log file [bytes] from which on no match is added; the last one may exceed it."""
_LONGEST: Final = 240
"""Largest length of a file's name [bytes], without its ending."""


def add_to_logs(folder: Path, entrants: Sequence[Entrant], parties: Parties, one: PlayedMatch) -> None:
    """Add the output and the fault of each party of a match to its log; the folder is made when it is needed.

    Raises:
        OutputError: if a log cannot be written.
    """
    for party, index in enumerate(one.match.seating):
        forfeit, printed = one.result.forfeits[party], one.result.logs[party]
        if forfeit is None and not printed:
            continue
        why = f": {forfeit}" if forfeit is not None else ""
        text = f"== match {one.match.id}, {parties.called(party)}{why}\n{printed}".removesuffix("\n")
        path = log_file(folder, entrants[index].name)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("ab") as file:
                if file.tell() < MOST_BYTES:
                    file.write(f"{text}\n".encode())
        except OSError as error:
            raise unwritable(path, error, len(text)) from None


def log_file(folder: Path, name: str) -> Path:
    """Return the log file of an entrant."""
    *folders, last = name.split("/")  # a name may be ann/agent
    return Path(folder, *folders, f"{last.encode()[:_LONGEST].decode(errors='ignore')}.log")
