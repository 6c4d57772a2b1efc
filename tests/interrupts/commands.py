"""Commands that a test interrupts as a terminal does, with a signal to the whole process group."""

import os
import re
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

PATIENCE_S = 240.0
"""What takes longer hangs."""
_PLAN = "plan|matches|an agent plays|a pair meets in|time|store|replays"
PROGRESS = re.compile(rf"^((playing|loading agents|isolation): .+\n|({_PLAN})  +.+\n( {{10,}}.+\n)*)", re.MULTILINE)
"""What a command prints on stderr before and while it plays: the level of isolation, the plan, and how far it is."""
LINE = re.compile(
    r"catch-arena: interrupted(?P<kept>: what was played is kept in o; the same command with --resume goes on)?\n"
)
_CATCH_ARENA = (sys.executable, "-c", "from catch_arena.__main__ import main; main()")
WAITS_WHEN_IT_HAS_KEPT = (
    sys.executable,
    "-c",
    """
import time
from pathlib import Path
from catch_arena.__main__ import main
from catch_arena.tournament.store import Store
keep = Store.add
def keep_and_wait(*arguments):
    keep(*arguments)
    Path("kept").touch()
    time.sleep(60)
Store.add = keep_and_wait
main()
""",
)
"""The command `catch-arena`, which waits for an interrupt when the first block of a tournament is in its store."""
_UNMEASURED = {name: value for name, value in os.environ.items() if not name.startswith("COVERAGE_")}
"""Coverage saves what it has before a process ends, and may wait for the very thread that an interrupt has stopped."""


@dataclass(frozen=True)
class Ended:
    """Status, output and remaining processes of a command that has ended."""

    status: int
    output: str
    errors: str
    left: list[str]
    """The processes that it left behind, by their commands."""


class Command:
    """`catch-arena` with these words, or another program, in a process group of its own."""

    def __init__(self, folder: Path, words: Sequence[str], program: Sequence[str] = _CATCH_ARENA):
        self._mark = f"/marked-{uuid.uuid4().hex}"
        self.process = subprocess.Popen(
            [*program, *words],
            cwd=folder,
            env={**_UNMEASURED, "PATH": f"{os.environ['PATH']}{os.pathsep}{self._mark}"},  # agents inherit it too
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    def wait_until_it_listens(self):
        """Before that it is Python which starts; SIGTERM has a handler once we are asked."""
        patience = time.monotonic() + PATIENCE_S
        while self.process.poll() is None and time.monotonic() < patience:
            status = Path(f"/proc/{self.process.pid}/status").read_text()
            if int(re.search(r"SigCgt:\s*(\w+)", status)[1], 16) >> (signal.SIGTERM - 1) & 1:
                return
            time.sleep(0.001)

    def interrupt(self, pauses: Sequence[float] = (), number: int = signal.SIGINT):
        """One signal, and one more after each of these pauses [s]."""
        for pause in (0.0, *pauses):
            time.sleep(pause)
            if self.process.poll() is None:
                os.killpg(self.process.pid, number)

    def ended(self) -> Ended:
        """Wait for the end of the command, and return its result."""
        try:
            self.process.wait(PATIENCE_S)
            patience = time.monotonic() + PATIENCE_S
            while (left := self._left()) and time.monotonic() < patience:  # those that were killed are still ending
                time.sleep(0.01)
            errors = PROGRESS.sub("", self.process.stderr.read())
            return Ended(self.process.returncode, self.process.stdout.read(), errors, left)
        finally:
            if self.process.poll() is None:
                os.killpg(self.process.pid, signal.SIGKILL)
            self.process.stdout.close()
            self.process.stderr.close()

    def _left(self) -> list[str]:
        found = []
        for place in Path("/proc").glob("[0-9]*"):
            try:
                if self._mark.encode() in (place / "environ").read_bytes():
                    found.append((place / "cmdline").read_text().replace("\0", " "))
            except OSError:  # it has ended, or is another user's
                continue
        return found
