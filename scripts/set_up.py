"""Make a virtual environment and install the project of this folder into it, editable: `make` calls this.

Each step says what it does, and how far it is every few seconds, with or without a terminal. A step that fails leaves
nothing half made behind, says what is missing, and can be tried again: what was downloaded is kept. It needs nothing
but the standard library, as it runs before anything is installed.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from importlib.util import find_spec
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import NamedTuple, NoReturn

INTERRUPTED = 130
TOLD_EVERY_S = 5.0
LOG = "set_up.log"
"""In the environment: all that pip said."""

COMPILER = ("numba", "numpy", "platformdirs")
"""What the engine needs to be compiled: installed first, so that it compiles while pip goes on."""
COMPILE = "from catch_arena import Engine, scenario; Engine(scenario('standard'))"

_NO_NETWORK = (
    "NewConnectionError|NameResolutionError|ConnectTimeout|ReadTimeout|ConnectionReset|ProtocolError|IncompleteRead|"
    "Temporary failure in name resolution|Network is unreachable|Connection refused|ProxyError|SSLError"
)
CAUSES = (
    (r"No space left on device|Errno 28\b", "the disk is full: {space}"),
    (_NO_NETWORK, "the package index cannot be reached; is there a network?"),
    (r"Permission denied|Errno 13\b", "a folder cannot be written: {last}"),
)
"""What pip says, and what it means; the first that fits is told."""

FOUND = re.compile(r"\s*(?:Downloading|Using cached|Processing) (?:\S*/)?([\w.]+)-\S*(?:.*(\([\d.]+ [kM]B\)))?")
"""A package's name, and its size where it is told."""

ENVIRONMENT_HELP = """\
{python} cannot make a virtual environment: {reason}.
On Debian and Ubuntu:  apt-get install python3-venv
Or name another Python:  make PYTHON=/path/to/python3"""


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("environment", type=Path, help="the folder of the environment; made where it is missing")
    parser.add_argument("--extra", action="append", default=[], help="install the package with this extra")
    parser.add_argument("--group", action="append", default=[], help="install this dependency group of pyproject.toml")
    parser.add_argument("--compile", action="store_true", help="also compile the rules, while pip is still at work")
    return parser.parse_args()


def say(line: str) -> None:
    """One line, at once, whoever reads it."""
    print(line, flush=True)


def fail(line: str) -> NoReturn:
    """One line or a few that say what to do; `make` adds its own."""
    print(line, file=sys.stderr, flush=True)
    sys.exit(1)


# ---- the environment ----


def python_of(environment: Path) -> Path:
    """The environment's own Python."""
    return environment / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")


def works(*command: str | Path) -> str | None:
    """None where the command ends well, otherwise the last line that it said."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    except OSError as error:
        return str(error)
    if done.returncode == 0:
        return None
    return (done.stderr.strip() or done.stdout.strip() or f"exit code {done.returncode}").splitlines()[-1]


def make_environment(environment: Path) -> None:
    """An environment with a pip that works. One that is whole is left as it is; one that is half made is made anew."""
    python = python_of(environment)
    if environment.exists():
        if works(python, "-m", "pip", "--version") is None:
            return
        say(f"{environment} is only half made; it is made anew")
        remove(environment)
    say(f"making {environment} with Python {sys.version.split()[0]}")
    reason = works(sys.executable, "-m", "venv", environment) or works(python, "-m", "pip", "--version")
    if reason is None:
        return
    remove(environment)
    # Debian without python3-venv lacks ensurepip alone: where it has a pip of its own, that one fills the environment
    if works(sys.executable, "-m", "pip", "--version") is None:
        bare = works(sys.executable, "-m", "venv", "--without-pip", environment)
        filled = bare or works(sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "pip")
        if filled is None:
            return
        remove(environment)
    missing = [name for name in ("venv", "ensurepip") if not has(name)]
    reason = f"it lacks {' and '.join(missing)}" if missing else reason
    fail(ENVIRONMENT_HELP.format(python=sys.executable, reason=reason))


def has(module: str) -> bool:
    """Whether this Python has a module of the standard library, which distributions may put into another package."""
    try:
        return find_spec(module) is not None
    except ImportError:
        return False


def remove(environment: Path) -> None:
    """Nothing of it stays."""
    shutil.rmtree(environment, ignore_errors=True)
    if environment.exists():
        fail(f"{environment} cannot be removed; remove it by hand, and try again")


# ---- the packages ----


class Project(NamedTuple):
    """What pyproject.toml says."""

    dependencies: list[str]
    groups: dict[str, list[str]]

    @classmethod
    def here(cls) -> "Project":
        """That of the folder we are in."""
        read = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))
        return cls(read["project"]["dependencies"], read["dependency-groups"])

    def needs_of(self, names: tuple[str, ...]) -> list[str]:
        """The dependencies with these names, and their versions."""
        return [need for need in self.dependencies if re.match(r"[\w.-]+", need)[0] in names]


def install(environment: Path, what: list[str], title: str) -> None:
    """Have pip install this; say how far it is."""
    say(f"installing {title}")
    # modules are compiled when they are first imported: most of what is installed never is
    options = ("--disable-pip-version-check", "--no-compile", "--progress-bar", "off", "--retries", "2")
    pip = subprocess.Popen(
        [python_of(environment), "-m", "pip", "install", *options, *what],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    )
    lines: SimpleQueue[str | None] = SimpleQueue()
    Thread(target=forward, args=(pip, lines), daemon=True).start()
    follow(lines, environment / LOG)
    if pip.wait():
        fail(failure(environment, title))


def forward(pip: subprocess.Popen[str], lines: SimpleQueue[str | None]) -> None:
    """Each line as it comes, then None."""
    for line in pip.stdout or ():
        lines.put(line.rstrip())
    lines.put(None)


def follow(lines: SimpleQueue[str | None], log: Path) -> None:
    """Keep what pip says in the log, and tell how far it is: how many packages it has found, then that it unpacks."""
    began = next_time = time.monotonic()
    found, doing = 0, "asking for packages"
    with log.open("a", encoding="utf-8") as kept:
        while True:
            now = time.monotonic()
            if now >= next_time + TOLD_EVERY_S:
                say(f"  {now - began:3.0f} s  {doing}")
                next_time = now
            try:
                line = lines.get(timeout=1.0)
            except Empty:
                continue
            if line is None:
                return
            print(line, file=kept, flush=True)
            if got := re.match(
                r"\s*(?:Downloading|Using cached|Processing) (?:\S*/)?([\w.]+)-\S*(?:.*(\(.* [kM]B\)))?", line
            ):
                found += 1
                doing = f"{found} packages so far; now {got[1]} {got[2] or ''}".rstrip()
            elif unpacked := re.match(r"Installing collected packages: (.*)", line):
                doing = f"unpacking {len(unpacked[1].split(', '))} packages"


def failure(environment: Path, title: str) -> str:
    """Why pip failed, in words, and what to do."""
    told = (environment / LOG).read_text(encoding="utf-8", errors="replace")
    last = next((line for line in reversed(told.splitlines()) if line.startswith("ERROR")), "pip gave no reason")
    space = ", ".join(
        f"{folder} has {shutil.disk_usage(folder).free / 1e6:.0f} MB left"
        for folder in (environment, tempfile.gettempdir())
    )
    cause = next((words for pattern, words in CAUSES if re.search(pattern, told)), "{last}")
    return (
        f"{title} could not be installed: {cause.format(space=space, last=last)}\n"
        f"What pip said is in {environment / LOG}. The same command goes on from here."
    )


# ---- the rules ----


class Compilation:
    """The rules, compiled in a process beside us."""

    def __init__(self, environment: Path) -> None:
        self._began = time.monotonic()
        self._process = subprocess.Popen(
            [python_of(environment), "-c", COMPILE],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
        )
        self._said: list[str] = []
        Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        self._said += self._process.stderr or ()

    def finish(self) -> None:
        """Wait for its end, and say so; a failure is told, and stops nothing: the first match compiles again."""
        while True:
            try:
                self._process.wait(timeout=TOLD_EVERY_S)
            except subprocess.TimeoutExpired:
                say(f"  {time.monotonic() - self._began:3.0f} s  compiling the rules for this machine, once")
            else:
                break
        if self._process.returncode:
            say("the rules were not compiled: " + "".join(self._said[-1:]).strip())

    def stop(self) -> None:
        """End it, wherever it is."""
        self._process.kill()
        self._process.wait()


def set_up(args: argparse.Namespace) -> None:
    """All steps."""
    began = time.monotonic()
    environment = args.environment
    make_environment(environment)
    (environment / LOG).unlink(missing_ok=True)
    project = Project.here()
    compilation = None
    try:
        if args.compile:
            install(environment, project.needs_of(COMPILER), "the compiler")
            compilation = Compilation(environment)
        if args.extra or not args.group:
            package = f".[{','.join(args.extra)}]" if args.extra else "."
            install(environment, ["--editable", package], f"Catch Arena{package[1:]}")
        for group in args.group:
            install(environment, project.groups[group], f"what `{group}` needs")
        if compilation is not None:
            compilation.finish()
    except BaseException:
        if compilation is not None:
            compilation.stop()
        raise
    say(f"set up in {time.monotonic() - began:.0f} s")


def main() -> int:
    """The exit code: 0, 1 with lines that say why not, or 130 after Ctrl-C."""
    try:
        set_up(parse())
    except KeyboardInterrupt:
        print("interrupted; the same command goes on from here", file=sys.stderr)
        return INTERRUPTED
    except OSError as error:
        fail(f"{error.filename or 'set-up'}: {error.strerror or error}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
