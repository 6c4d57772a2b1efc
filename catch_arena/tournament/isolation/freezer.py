"""A process and all that descends from it, stopped and told to go on: whoever stands still does nothing."""

import signal
import time
from typing import Final

from catch_arena.descendants import family, parent_of, send, state

_FREEZE_S: Final = 10.0
"""How long a process may take to stand still: as long as it waits in the system."""
_PAUSE_S: Final = 0.0002


class Freezer:
    """Makes a process stand still, and all that descends from it; and go on.

    Args:
        root: that process.
    """

    def __init__(self, root: int) -> None:
        self._root = root
        self._found = {root}
        self._still: set[int] = set()
        """Those of them who live, and stand still."""
        self._newest = 0
        """The newest process of the system when all stood still the last time: who is newer was started since."""

    def freeze(self) -> bool:
        """Return when nobody runs any more; false where some do not obey."""
        patience = time.monotonic() + _FREEZE_S
        obeyed: set[int] = set()
        while True:
            newest = self._look()
            if obeyed >= self._found:
                self._newest = newest
                return True
            for pid in self._found - obeyed:
                send(pid, signal.SIGSTOP)
            # twice the same: whoever has just ended may have taken another with him
            before, stopped = None, self._stopped()
            while stopped is None or stopped != before:
                if time.monotonic() > patience:
                    return False
                time.sleep(_PAUSE_S)
                before, stopped = stopped, self._stopped()
            self._still = stopped
            obeyed |= self._found

    def lost(self) -> int | None:
        """One who should stand still and does not: it has been killed, from that moment on, or told to go on. The first
        one of all is lost too where it had ended before.
        """
        return next((pid for pid in (self._root, *self._still) if state(pid) != "T"), None)

    def thaw(self) -> None:
        """Let them go on."""
        for pid in self._found:
            send(pid, signal.SIGCONT)

    def _look(self) -> int:
        """Find those who have come since all stood still: looking at all takes longer than most moves. A child
        may have an id and not be seen yet; but its parent stands still only after that.

        Returns:
            the newest process of the system.
        """
        newest, before = _newest_process(), self._newest
        if before == 0 or newest < before:
            self._found = {self._root, *family(self._root)}
        for pid in range(before + 1, newest + 1) if before else ():
            if parent_of(pid) in self._found:
                self._found.add(pid)
        return newest

    def _stopped(self) -> set[int] | None:
        """Those who stand still; None while somebody runs: who is not stopped has ended, or waits for its disk."""
        states = {pid: state(pid) for pid in self._found}
        if not set(states.values()) <= {"", "D", "T", "X", "Z"}:
            return None
        return {pid for pid, one in states.items() if one == "T"}


def _newest_process() -> int:
    """The id that the system gave last, to a process or a thread; 0 where nobody knows."""
    try:
        with open("/proc/loadavg", "rb", buffering=0) as file:  # noqa: PTH123 - read twice in each turn of an agent
            return int(file.read().split()[-1])
    except OSError:
        return 0
