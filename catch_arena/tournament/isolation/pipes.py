"""One isolated agent's lines, from the tournament's side: those to it, those from it, and what it prints.

They go through sockets: a pipe could be opened anew, by any process of the same user, as a file of /proc.
"""

import os
import socket
from contextlib import suppress
from typing import Final

from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.players import Fault

_PART: Final = 65536
_KIB: Final = 1024


class Log:
    """The first and the last of what an agent prints, as much of each."""

    def __init__(self, size: int) -> None:
        self._half = size // 2
        self._first, self._last, self._between = bytearray(), bytearray(), 0

    def add(self, content: bytes) -> None:
        """It has printed that."""
        room = self._half - len(self._first)
        self._first += content[:room]
        self._last += content[room:]
        if (over := len(self._last) - self._half) > 0:
            self._between += over
            del self._last[:over]

    def text(self) -> str:
        """What is kept, with a line where something is left out."""
        gap = f"\n[{self._between} bytes left out]\n".encode() if self._between else b""
        return (self._first + gap + self._last).decode(errors="backslashreplace")


class AgentPipes:
    """Three ways: lines to the agent, its answers, and what it prints. Our ends never wait."""

    def __init__(self, limits: AgentLimits) -> None:
        self._longest = limits.answer_kib * _KIB
        self.log = Log(limits.log_kib * _KIB)
        into, self._into = _one_way()
        self.answers, out = _one_way()
        self.printed, log = _one_way()
        self._theirs: tuple[int, ...] = (into, out, log)
        self._ours = {self._into, self.answers, self.printed}
        for file in self._ours:
            os.set_blocking(file, False)
        self._heard = b""

    def take_theirs(self) -> tuple[int, ...]:
        """The agent's ends, for its process; to be closed here afterwards."""
        theirs, self._theirs = self._theirs, ()
        return theirs

    def files(self) -> tuple[int, ...]:
        """What is worth waiting for."""
        return (self.answers, self.printed) if self.printed in self._ours else (self.answers,)

    def write(self, line: bytes) -> bool:
        """Whether the agent's pipe had room for it; one that is closed shows when it is read."""
        try:
            return os.write(self._into, line) == len(line)
        except BlockingIOError:
            return False
        except (BrokenPipeError, ConnectionResetError):
            return True

    def read(self) -> bytes | Fault | None:
        """What has come: a whole line, a fault, or None while the line is not whole. Its process has ended or closed
        its answers where the fault has no reason.
        """
        try:
            part = os.read(self.answers, _PART)
        except BlockingIOError:
            return None
        if not part:
            return Fault("FORFEIT_CRASH", "")
        self._heard += part
        line, end, rest = self._heard.partition(b"\n")
        if rest:
            return Fault("FORFEIT_ILLEGAL", f"said more than one line: {_shown(self._heard)}")
        if len(self._heard) > self._longest:
            return Fault("FORFEIT_ILLEGAL", f"its line is longer than {self._longest} bytes: {_shown(line)}")
        if not end:
            return None
        self._heard = b""
        return line

    def read_log(self) -> bool:
        """Take what has been printed.

        Returns:
            whether more may come.
        """
        with suppress(BlockingIOError):
            for _ in range(4):  # one that prints for ever is not waited for
                if self.printed not in self._ours:
                    return False
                part = os.read(self.printed, _PART)
                if not part:
                    self._close(self.printed)
                self.log.add(part)
        return True

    def close(self) -> None:
        """Take what was printed, and close all that is open."""
        self.read_log()
        for file in (*self._ours, *self.take_theirs()):
            os.close(file)
        self._ours.clear()

    def _close(self, file: int) -> None:
        os.close(file)
        self._ours.discard(file)


def _one_way() -> tuple[int, int]:
    """A socket's end to read from, and one to write to."""
    reader, writer = socket.socketpair()
    reader.shutdown(socket.SHUT_WR)
    writer.shutdown(socket.SHUT_RD)
    return reader.detach(), writer.detach()


def _shown(content: bytes) -> str:
    return repr(content[:80].decode(errors="replace"))
