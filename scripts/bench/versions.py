"""Versions of this repository: the current one, and an older commit in a temporary folder."""

import importlib.metadata
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent


class UnmeasurableError(Exception):
    """Error: a version cannot be measured; the message is one line."""


def commit_of(ref: str) -> str:
    """Return the full name of a commit.

    Raises:
        UnmeasurableError: there is no such commit, no history or no git.
    """
    try:
        return _git("rev-parse", "--verify", "--end-of-options", f"{ref}^{{commit}}")
    except UnmeasurableError as error:
        raise UnmeasurableError(f"--against must name a commit of this repository, got {ref!r}: {error}") from None


def current() -> str:
    """Return the current commit, or the version without git, and in words whether something is not committed."""
    try:
        changes = _git("status", "--porcelain", "--untracked-files=no", "--", "catch_arena")
        return f"commit {commit_of('HEAD')[:12]}" + (" with changes that are not committed" if changes else "")
    except UnmeasurableError:
        return f"version {importlib.metadata.version('catch-arena')}"


@contextmanager
def checked_out(commit: str, folder: Path) -> Iterator[None]:
    """Check out the files of a commit into a folder; remove them when the block is left.

    Raises:
        UnmeasurableError: the commit cannot be checked out.
    """
    _git("worktree", "add", "--detach", "--quiet", str(folder), commit)
    try:
        yield
    finally:
        _git("worktree", "remove", "--force", str(folder))


def _git(*arguments: str) -> str:
    """Return the output of git, run without hooks and in its own session, so that Ctrl-C does not interrupt it.

    Raises:
        UnmeasurableError: git fails, or is not installed.
    """
    command = ["git", "-C", str(ROOT), "-c", "core.hooksPath=/dev/null", *arguments]
    try:
        done = subprocess.run(command, check=True, capture_output=True, text=True, start_new_session=True)
    except FileNotFoundError:
        raise UnmeasurableError("git is not installed") from None
    except subprocess.CalledProcessError as error:
        raise UnmeasurableError(error.stderr.strip().splitlines()[-1]) from None
    return done.stdout.strip()
