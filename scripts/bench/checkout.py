"""An older version of this repository, as a work tree of its own in a temporary folder."""

import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent


class CheckoutError(Exception):
    """Why there is none, in a line."""


def commit_of(ref: str) -> str:
    """The commit's full name.

    Raises:
        CheckoutError: where the commit cannot be checked out.
    """
    if not shutil.which("git"):
        raise CheckoutError("--against needs git, which is not installed here")
    if _git("rev-parse", "--git-dir").returncode:
        raise CheckoutError(f"--against needs the repository's history, and {ROOT} is no git checkout")
    found = _git("rev-parse", "--verify", "--quiet", "--end-of-options", f"{ref}^{{commit}}")
    if found.returncode:
        raise CheckoutError(f"--against must name a commit of this repository, got {ref!r}")
    return found.stdout.strip()


def current() -> str:
    """What is measured as the current version, in words: changes that are not committed count."""
    changes = _git("status", "--porcelain", "--untracked-files=no", "--", "catch_arena").stdout
    return commit_of("HEAD")[:12] + (" with changes that are not committed" if changes else "")


@contextmanager
def checked_out(commit: str, folder: Path) -> Iterator[None]:
    """That commit's files in that folder, until the block is left, however that is.

    Raises:
        CheckoutError: where the commit cannot be checked out.
    """
    try:
        made = _git("worktree", "add", "--detach", "--quiet", str(folder), commit)
        if made.returncode:
            raise CheckoutError(f"git cannot check {commit[:12]} out: {_last_line(made.stderr)}")
        if not (folder / "catch_arena" / "__init__.py").is_file():
            raise CheckoutError(f"the commit {commit[:12]} has no package catch_arena")
        yield
    finally:
        _git("worktree", "remove", "--force", str(folder))


def _git(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Without hooks, which are made for people's work trees; in a session of its own, so that Ctrl-C does not end it
    half way.
    """
    command = ["git", "-C", str(ROOT), "-c", "core.hooksPath=/dev/null", *arguments]
    return subprocess.run(command, check=False, capture_output=True, text=True, start_new_session=True)


def _last_line(text: str) -> str:
    return (text.strip().splitlines() or ["without a word"])[-1]
