"""The folder of the environment: whose it is, whether it is whole, and who is at work in it."""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path

from words import AGAIN, TOLD_EVERY_S, cause, fail, last_line, say

from catch_arena import descendants

if sys.platform != "win32":  # which has no such locks
    import fcntl

BEGAN = "set_up.began"
"""A file that says: this program made the environment, and may remove what is in it."""
WHOLE = "set_up.whole"
"""A file that is written last: the project and the folder that the environment serves. `make` watches it."""

NOT_A_FOLDER = """\
{folder} is not a folder.
Move it away, or name another one:  make VENV=env"""
NOT_OURS = """\
{folder} {fault}. It was not made by `make`, and is left as it is.
Move it away, or name another folder:  make VENV=env"""
NO_VENV = """\
{python} cannot make a virtual environment: {reason}.
On Debian and Ubuntu:  apt-get install python3-venv
Or name another Python:  make PYTHON=/path/to/python3"""


class Environment:
    """A virtual environment, which nobody else works in meanwhile: see `alone_in`."""

    def __init__(self, folder: Path, lock: int | None) -> None:
        self.folder = folder
        self.python = folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
        self.lock = () if lock is None else (lock,)
        """What processes inherit that work in the folder: should this one be killed, it is theirs until they end."""

    def make(self) -> None:
        """Leave one that is whole as it is, and make anew one that serves no longer, if this program made it."""
        place = f"{self.folder.resolve()} for "
        serves = f"{place}{Path.cwd().resolve()}"
        whole, ours = self.folder / WHOLE, (self.folder / BEGAN).exists()
        served = whole.read_text(encoding="utf-8") if whole.exists() else ""
        broken = self._failure_of(f"looking at {self.folder}", self.python, "-I", "-c", "import pip")
        if broken is None and served == serves:
            return
        if broken is None and not ours and (not served or served.startswith(place)):  # somebody's own, which works
            whole.write_text(serves, encoding="utf-8")
            return
        if any(self.folder.iterdir()):
            if not served and ours:
                fault = "is only half made"
            elif served not in {"", serves}:
                fault = f"was made as {served}"
            else:
                fault = f"has no Python with a pip that works ({last_line(broken or '')})"
            if not ours:
                fail(NOT_OURS.format(folder=self.folder, fault=fault))
            say(f"{self.folder} {fault}; it is made anew")
            self._clear()
        self._create()
        whole.write_text(serves, encoding="utf-8")

    def _failure_of(self, doing: str, *command: str | Path) -> str | None:
        """None where the command ends well, otherwise all that it said. Tells every few seconds what it is doing."""
        began = time.monotonic()
        try:
            process = subprocess.Popen(
                command,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors="replace",
                pass_fds=self.lock,
            )
        except OSError as error:
            return str(error)
        try:
            while True:
                try:
                    said, _ = process.communicate(timeout=TOLD_EVERY_S)
                except subprocess.TimeoutExpired:
                    say(f"  {time.monotonic() - began:3.0f} s  {doing}")
                else:
                    return (said or f"exit code {process.returncode}") if process.returncode else None
        except BaseException:
            descendants.end((process.pid,))  # ensurepip runs in a process of its own
            process.wait()
            raise

    def _create(self) -> None:
        (self.folder / BEGAN).touch()
        say(f"making {self.folder} with Python {sys.version.split()[0]}")
        venv = (sys.executable, "-m", "venv", "--without-pip", self.folder)
        said = self._failure_of("making the folder", *venv) or self._add_pip()
        if said is None:
            return
        reason = cause(said, self.folder)
        self._clear()
        (self.folder / BEGAN).unlink()
        if reason is not None:
            fail(f"{self.folder} cannot be made: {reason}\n{AGAIN}")
        missing = [name for name in ("venv", "ensurepip") if not has(name)]
        reason = f"it lacks {' and '.join(missing)}" if missing else last_line(said)
        fail(NO_VENV.format(python=sys.executable, reason=reason))

    def _add_pip(self) -> str | None:
        """What went wrong."""
        doing = "putting pip into it"
        said = self._failure_of(doing, self.python, "-m", "ensurepip", "--default-pip")
        # Debian without python3-venv lacks ensurepip alone: where it has a pip of its own, that one does it
        if said is None or self._failure_of(doing, sys.executable, "-m", "pip", "--version") is not None:
            return said
        return self._failure_of(doing, sys.executable, "-m", "pip", "--python", self.python, "install", "pip")

    def _clear(self) -> None:
        """Nothing of it stays but what says that it may be removed, so that this can be interrupted."""
        for path in self.folder.iterdir():
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            elif path.name != BEGAN:
                path.unlink()


def has(module: str) -> bool:
    """Whether this Python has a module of the standard library, which distributions may put into another package."""
    try:
        return find_spec(module) is not None
    except ImportError:
        return False


@contextmanager
def alone_in(folder: Path) -> Iterator[Environment]:
    """Wait until no other set-up is at work in the folder, and keep others out; it is made where it is missing."""
    try:
        lock = _wait_for(folder)
    except FileExistsError:
        fail(NOT_A_FOLDER.format(folder=folder))
    try:
        yield Environment(folder, lock)
    finally:
        with suppress(OSError):
            folder.rmdir()  # only an empty one can be removed: what was begun, and came to nothing
        if lock is not None:
            os.close(lock)


def _wait_for(folder: Path) -> int | None:
    """The folder's lock, which ends with the last process that has it; None where there are no locks."""
    began = next_time = time.monotonic()
    while True:
        folder.mkdir(parents=True, exist_ok=True)
        if sys.platform == "win32":
            return None
        lock = os.open(folder, os.O_RDONLY)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            now = time.monotonic()
            if now == began or now >= next_time:
                say(f"  {now - began:3.0f} s  waiting: another set-up is at work in {folder}")
                next_time = now + TOLD_EVERY_S
            time.sleep(0.2)
        except OSError:  # a network's file system without locks
            return lock
        else:
            with suppress(FileNotFoundError):  # the other one may have removed the folder in the end
                if os.path.samestat(os.fstat(lock), folder.stat()):
                    return lock
        os.close(lock)
