"""What stands on our command line, and must not stay there: any process of this machine may read it (`ps`)."""

import ctypes
from contextlib import suppress
from pathlib import Path
from typing import Final

_ARG_START, _ARG_END = 45, 46
"""Of the fields of /proc/self/stat, counted from the one behind the name (proc_pid_stat(5): 48 and 49)."""
_BLANK: Final = b"x"


def blank_argument(text: str) -> None:
    """Overwrite an argument where the system shows it. Only Linux says where that is; elsewhere it stays.

    What started us may show it all the same: a shell's history, or `timeout` and its like in their own command lines.
    """
    with suppress(OSError, IndexError, ValueError):
        fields = Path("/proc/self/stat").read_bytes().rpartition(b")")[2].split()
        start, end = int(fields[_ARG_START]), int(fields[_ARG_END])
        sought = text.encode()
        at = ctypes.string_at(start, end - start).find(sought) if 0 < start < end else -1
        if at >= 0:
            ctypes.memmove(start + at, _BLANK * len(sought), len(sought))
