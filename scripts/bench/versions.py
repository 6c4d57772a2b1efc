"""Versions of this repository: the current one, an older commit in a temporary folder, and a process for each."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

ROOT = Path(__file__).resolve().parent.parent.parent


class UnmeasurableError(Exception):
    """Error: a version cannot be measured; the message is one line."""


def commit_of(ref: str) -> str:
    """Return the full name of a commit.

    Raises:
        UnmeasurableError: there is no such commit, no history or no git.
    """
    if not shutil.which("git"):
        raise UnmeasurableError("--against needs git, which is not installed here")
    if _git("rev-parse", "--git-dir").returncode:
        raise UnmeasurableError(f"--against needs the repository's history, and {ROOT} is no git checkout")
    found = _git("rev-parse", "--verify", "--quiet", "--end-of-options", f"{ref}^{{commit}}")
    if found.returncode:
        raise UnmeasurableError(f"--against must name a commit of this repository, got {ref!r}")
    return found.stdout.strip()


def current() -> str:
    """Return the current commit, and in words whether there are changes that are not committed."""
    commit = commit_of("HEAD")
    changes = _git("status", "--porcelain", "--untracked-files=no", "--", "catch_arena").stdout
    return commit[:12] + (" with changes that are not committed" if changes else "")


@contextmanager
def checked_out(commit: str, folder: Path) -> Iterator[None]:
    """Check out the files of a commit into a folder; remove them when the block is left.

    Raises:
        UnmeasurableError: the commit cannot be checked out, or has no package catch_arena.
    """
    try:
        made = _git("worktree", "add", "--detach", "--quiet", str(folder), commit)
        if made.returncode:
            raise UnmeasurableError(f"git cannot check {commit[:12]} out: {_last_line(made.stderr)}")
        if not (folder / "catch_arena" / "__init__.py").is_file():
            raise UnmeasurableError(f"the commit {commit[:12]} has no package catch_arena")
        yield
    finally:
        _git("worktree", "remove", "--force", str(folder))


def _git(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run git without hooks, in its own session, so that Ctrl-C does not interrupt it."""
    command = ["git", "-C", str(ROOT), "-c", "core.hooksPath=/dev/null", *arguments]
    return subprocess.run(command, check=False, capture_output=True, text=True, start_new_session=True)


def _last_line(text: str) -> str:
    return (text.strip().splitlines() or ["without a word"])[-1]


class Version:
    """Version of the package, or the peers: its process and its results."""

    def __init__(self, title: str, root: Path | None, work: Path) -> None:
        self.title = title
        self.rows: dict[str, dict[str, Any]] = {}
        """Rows by name: agents, envs and floats; "cpu" and "wall" have the times of a step [s], one for each round."""
        self._root = root
        self._words = work / "stderr"
        self._cache = work / "cache"
        self._cache.mkdir(parents=True)
        self._process: Any = None

    @contextmanager
    def running(self, *, quick: bool, pufferlib: Path | None) -> Iterator[None]:
        """Start its process, and end it when the block is left; Ctrl-C does not reach it, since it has its own session.

        The version's package comes first on the path. Bytecode and compiled code are kept, as they are for users.
        """
        threads = dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
        xla = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
        environment = {**os.environ, **threads, "XLA_FLAGS": xla, "JAX_PLATFORMS": "cpu"}
        environment |= {"PYTHONPATH": str(self._root or ""), "NUMBA_CACHE_DIR": str(self._cache)}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        side = Path(__file__).with_name("side.py")
        command = [sys.executable, side, self._root or "", "quick" if quick else "whole", pufferlib or ""]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "start_new_session": True}
        with self._words.open("w") as words:
            folder = self._root or ROOT
            with subprocess.Popen([*map(str, command)], cwd=folder, env=environment, stderr=words, **pipes) as process:
                self._process = process
                try:
                    yield
                finally:
                    process.kill()

    def ask(self, *request: object) -> None:
        """Send a request, without waiting for the answer."""
        try:
            self._process.stdin.write(json.dumps(request) + "\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            self._fail(_last_line(self._words.read_text()))

    def answer(self) -> Any:
        """Return the answer to the last request.

        Raises:
            UnmeasurableError: a row cannot be measured.
        """
        line = self._process.stdout.readline()
        if not line:
            self._fail(_last_line(self._words.read_text()))
        found = json.loads(line)
        if "error" in found:
            self._fail(found["error"])
        return found["answer"]

    def _fail(self, reason: str) -> NoReturn:
        raise UnmeasurableError(f"{self.title} cannot be measured: {reason}")

    def play(self, name: str, seconds: float) -> None:
        """Play one turn of a row, and keep its times."""
        self.ask("turn", name, seconds)
        cpu, wall = self.answer()
        self.rows[name]["cpu"].append(cpu)
        self.rows[name]["wall"].append(wall)
