"""Streams whose reader may close the pipe, as `head` does: the process continues, and its own exit code counts.

The command line and worker processes use them for stdout and stderr.
"""

import sys
from contextlib import suppress
from io import BufferedWriter, FileIO, TextIOWrapper
from typing import Any


class _LastingFile(FileIO):
    def write(self, data: Any, /) -> int:
        """Write data, and discard it if the pipe is closed."""
        try:
            return super().write(data)
        except BrokenPipeError:
            return len(data)


def outlive_readers() -> None:
    """Replace stdout and stderr of this process, so that printing to a closed pipe raises nothing, even in an agent."""
    for name in ("stdout", "stderr"):
        with suppress(AttributeError, OSError, ValueError):  # no stream, or one in memory
            stream = getattr(sys, name)
            raw = _LastingFile(stream.fileno(), "w", closefd=False)
            lasting = TextIOWrapper(
                raw if stream.write_through else BufferedWriter(raw),  # as Python makes its own with -u
                stream.encoding,
                "replace",  # a letter that a terminal cannot show becomes a question mark
                line_buffering=stream.line_buffering,
                write_through=stream.write_through,
            )
            setattr(sys, name, lasting)
