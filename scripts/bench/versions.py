"""Versions of this repository: the current one, and an older commit in a temporary folder."""

import shutil
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
    if not shutil.which("git"):
        raise UnmeasurableError("--against needs git, which is not installed here")
    if _git("rev-parse", "--git-dir").returncode:
        raise UnmeasurableError(f"--against needs the repository's history, and {ROOT} is not a git checkout")
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
            raise UnmeasurableError(f"git cannot check {commit[:12]} out: {made.stderr.strip()}")
        if not (folder / "catch_arena" / "__init__.py").is_file():
            raise UnmeasurableError(f"the commit {commit[:12]} has no package catch_arena")
        yield
    finally:
        _git("worktree", "remove", "--force", str(folder))


def _git(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run git without hooks, in its own session, so that Ctrl-C does not interrupt it."""
    command = ["git", "-C", str(ROOT), "-c", "core.hooksPath=/dev/null", *arguments]
    return subprocess.run(command, check=False, capture_output=True, text=True, start_new_session=True)
