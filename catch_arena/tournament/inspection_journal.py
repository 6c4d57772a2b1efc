"""Which agent is looked at, in a file beside the store that is written before: one that kills the tournament then is
not looked at again.
"""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Final

from catch_arena.files import prepare_folder, write_whole
from catch_arena.tournament.entrants import Inspection

_FILE: Final = "inspections.json"
_KILLED: Final = 2
"""What an end counts that a person hardly wishes for; from there on an agent cannot begin."""
_INTERRUPTED: Final = 1


class InspectionJournal:
    """How often each of a tournament's agents was inspected, this time and before, without an end.

    Args:
        folder: the tournament's, which is made when it is needed.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / _FILE
        try:
            self._counts: dict[str, int] = dict(json.loads(self._path.read_text()))
        except (OSError, ValueError, TypeError):
            self._counts = {}

    def inspect(self, spec: str, look: Callable[[str], Inspection]) -> Inspection:
        """What comes of a look at an agent that could do harm.

        Raises:
            OutputError: where the file cannot be written.
        """
        before = self._counts.get(spec, 0)
        if before >= _KILLED:
            again = f"to have it looked at again, remove {_FILE} beside the results"
            return Inspection(fault=f"the tournament was killed while it was looked at; {again}")
        self._write(spec, before + _KILLED)
        after = before
        try:
            found = look(spec)
            after = 0
        except KeyboardInterrupt:
            after = before + _INTERRUPTED
            raise
        finally:
            self._write(spec, after)
        return found

    def _write(self, spec: str, count: int) -> None:
        self._counts[spec] = count
        kept = {spec: count for spec, count in self._counts.items() if count}
        if kept:
            prepare_folder(self._path.parent)
            write_whole(self._path, json.dumps(kept).encode())
        else:
            self._path.unlink(missing_ok=True)
