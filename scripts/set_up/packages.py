"""pip at work in the environment: what it installs, how far it is, and why it failed."""

import os
import re
import subprocess
import tempfile
import time
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import NamedTuple

import tomllib
from environment import Environment
from words import AGAIN, TOLD_EVERY_S, cause, counted, fail, last_line, say

from catch_arena import descendants

LOG = "set_up.log"
"""In the environment: all that pip said."""

FOUND = re.compile(
    r"\s*(?:Downloading|Using cached|Processing) (?:\S*/)?([\w.]+)-(?!\S*\.metadata)\S*(?:.*?( \([\d.]+ [kM]B\)))?"
)
"""A package's name, and its size where pip says it. Newer ones fetch what a package needs before the package."""
UNPACKED = re.compile(r"Installing collected packages: (.*)")


class Project(NamedTuple):
    """What pyproject.toml says."""

    dependencies: list[str]
    groups: dict[str, list[str]]
    commands: list[str]

    @classmethod
    def here(cls) -> "Project":
        """That of the folder we are in."""
        read = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))
        project = read["project"]
        return cls(project["dependencies"], read["dependency-groups"], list(project.get("scripts", ())))

    def needs_of(self, names: tuple[str, ...]) -> list[str]:
        """The dependencies with these names, and their versions."""
        return [need for need in self.dependencies if re.split(r"[^\w.-]", need)[0] in names]


class Progress:
    """How far one run of pip is: what it says, what has arrived in its temporary folder, and what is unpacked."""

    def __init__(self, environment: Path, scratch: Path) -> None:
        self._environment = environment
        self._scratch = scratch
        self._found, self._last = 0, ""
        self._to_unpack, self._there_before = 0, 0

    def hear(self, line: str) -> None:
        """Learn from what pip says."""
        if got := FOUND.match(line):
            self._found, self._last = self._found + 1, got[1] + (got[2] or "")
        elif unpacked := UNPACKED.match(line):
            self._to_unpack, self._there_before = len(unpacked[1].split(", ")), self._there()

    def received_mb(self) -> float:
        """What pip has downloaded, or copied from its cache."""
        total = 0
        for path in self._scratch.glob("pip-unpack-*/*"):
            with suppress(FileNotFoundError):  # pip has just ended
                total += path.stat().st_size
        return total / 1e6

    def words(self, megabytes: str) -> str:
        """What pip does. `megabytes` says how much was received by now."""
        if self._to_unpack:
            return f"unpacking: {self._there() - self._there_before} of {counted(self._to_unpack, 'package')}"
        if self._found:
            return f"{counted(self._found, 'package')} so far{megabytes}; now {self._last}"
        return "asking for packages"

    def _there(self) -> int:
        return sum(1 for _ in self._environment.glob("lib/python*/site-packages/*.dist-info"))


class Installer:
    """All calls of pip. `download_mb` is about what they download together, where nothing is kept from before."""

    def __init__(self, environment: Environment, download_mb: int | None) -> None:
        self._environment = environment
        self._of_mb = f" of some {download_mb} MB" if download_mb else " MB"
        self._received_mb = 0.0
        """By the calls that have ended."""
        self._log = environment.folder / LOG
        self._log.unlink(missing_ok=True)

    def install(self, what: list[str], title: str) -> None:
        """Have pip install this; say how far it is."""
        say(f"installing {title}")
        # modules are compiled when they are first imported: most of what is installed never is
        options = ("--disable-pip-version-check", "--no-compile", "--progress-bar", "off", "--retries", "2")
        with tempfile.TemporaryDirectory(prefix="set-up-", ignore_cleanup_errors=True) as scratch:
            pip = subprocess.Popen(
                [self._environment.python, "-m", "pip", "install", *options, *what],
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors="replace",
                env={**os.environ, "TMPDIR": scratch},
                pass_fds=self._environment.lock,
            )
            try:
                said = self._follow(pip, Progress(self._environment.folder, Path(scratch)))
            except BaseException:
                descendants.end((pip.pid,))  # what it runs to build a package too
                pip.wait()
                raise
            if pip.wait():
                reason = cause(said, self._environment.folder, Path(scratch).parent) or last_line(said)
                fail(f"{title} could not be installed: {reason}\nWhat pip said is in {self._log}. {AGAIN}")

    def _follow(self, pip: subprocess.Popen[str], progress: Progress) -> str:
        """Keep what pip says in the log, and tell how far it is. Returns all that it said."""
        lines: SimpleQueue[str | None] = SimpleQueue()
        Thread(target=_forward, args=(pip, lines), daemon=True).start()
        began = next_time = time.monotonic()
        said: list[str] = []
        received_mb = 0.0
        with self._log.open("a", encoding="utf-8") as kept:
            while True:
                now = time.monotonic()
                if now >= next_time + TOLD_EVERY_S:
                    next_time = now
                    received_mb = max(received_mb, progress.received_mb())
                    total_mb = self._received_mb + received_mb
                    megabytes = f", {total_mb:.0f}{self._of_mb}" if total_mb else ""
                    say(f"  {now - began:3.0f} s  {progress.words(megabytes)}")
                try:
                    line = lines.get(timeout=1.0)
                except Empty:
                    continue
                if line is None:
                    self._received_mb += received_mb
                    return "\n".join(said)
                said.append(line)
                print(line, file=kept, flush=True)
                progress.hear(line)


def _forward(pip: subprocess.Popen[str], lines: SimpleQueue[str | None]) -> None:
    """Each line as it comes, then None."""
    for line in pip.stdout or ():
        lines.put(line.rstrip())
    lines.put(None)


def quicken(command: Path) -> None:
    """Take out of a command what older pips write into it: it imports `re` before the command can hear Ctrl-C."""
    lines = command.read_text(encoding="utf-8").splitlines(keepends=True)
    kept = [line for line in lines if line != "import re\n" and "re.sub(" not in line]
    if kept != lines:
        command.write_text("".join(kept), encoding="utf-8")
