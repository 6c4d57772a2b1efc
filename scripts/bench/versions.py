"""Versions of this repository: the current one, and an older commit in a temporary folder."""

import importlib.metadata
import shutil
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent


class UnmeasurableError(Exception):
    """Error: a version cannot be measured; the message is one line."""


def current() -> str:
    """Return the current commit, with `-dirty` if something is not committed; without git, the version."""
    try:
        return f"commit {_git('describe', '--always', '--dirty', '--abbrev=12', '--exclude=*')}"
    except UnmeasurableError:
        return f"version {importlib.metadata.version('catch-arena')}"


def check_out(ref: str, folder: Path) -> str:
    """Write the files of a commit into a folder, and return the commit's full name.

    Raises:
        UnmeasurableError: there is no such commit, no history or no git.
    """
    try:
        commit = _git("rev-parse", "--verify", "--end-of-options", f"{ref}^{{commit}}")
    except UnmeasurableError as error:
        raise UnmeasurableError(f"--against must name a commit of this repository, got {ref!r}: {error}") from None
    archive = folder.with_suffix(".tar")
    _git("archive", f"--output={archive}", commit)
    shutil.unpack_archive(archive, folder)
    return commit


def _git(*arguments: str) -> str:
    """Return the output of git.

    Raises:
        UnmeasurableError: git fails, or is not installed.
    """
    command = ["git", "-C", str(ROOT), *arguments]
    try:
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()
    except FileNotFoundError:
        raise UnmeasurableError("git is not installed") from None
    except subprocess.CalledProcessError as error:
        raise UnmeasurableError(error.stderr.strip().splitlines()[-1]) from None
