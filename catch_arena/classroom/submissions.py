"""Submissions of a class: a folder with one file or one sub-folder for each student, named by it."""

import re
from collections import Counter
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Final

from catch_arena.errors import ConfigError
from catch_arena.text import composed, name_fault
from catch_arena.tournament.agent_spec import IN_FOLDER, digest_of_files, shipped_names

STATE: Final = ".league"
SITE: Final = "site"
"""Folders that a league makes next to its entries: STATE has its own files, SITE the pages."""
_SUBMITTED: Final = re.compile(r"\.(py|ipynb)$", re.IGNORECASE)
_IGNORED: Final = re.compile(r"\.|__")
"""Beginnings of names that are no submission, such as .git and __MACOSX."""
_NO_FILES: Final = re.compile(r"\.|__pycache__$|__MACOSX$")
"""Pattern of names that are no part of a submission; `__init__.py` is one."""


@dataclass(frozen=True, slots=True)
class Submission:
    """Submission of one student."""

    name: str
    """Name of the student: that of the folder, or of the file without its ending."""
    path: Path
    """File or folder with the student's name."""
    agent: str
    """Agent in it, as on the command line; a folder with only one file of Python has that one."""

    @property
    def files(self) -> list[Path]:
        """Files of the submission, without hidden ones; with a file, those with its stem, such as its weights."""
        if self.path.is_dir():
            inside = (path for path in self.path.rglob("*") if path.is_file())
            return sorted(path for path in inside if not any(map(_NO_FILES.match, path.relative_to(self.path).parts)))
        return sorted(path for path in self.path.parent.glob("*") if path.stem == self.path.stem and path.is_file())

    @property
    def changed(self) -> datetime:
        """Time of the last change of its files."""
        newest = max((path.stat().st_mtime for path in self.files), default=self.path.lstat().st_mtime)
        return datetime.fromtimestamp(newest).astimezone().replace(microsecond=0)

    def digest(self) -> str:
        """Return the digest of the names and contents of its files; the student's name does not count."""
        named = ((path.relative_to(self.path) if self.path.is_dir() else path.suffix, path) for path in self.files)
        return digest_of_files(named, 8).hexdigest()


def is_class(word: str) -> bool:
    """Return whether a word on the command line names a folder of submissions, and no agent."""
    path = Path(word)
    return path.is_dir() and not (path / IN_FOLDER).is_file() and word not in shipped_names()


def submission_at(path: Path) -> Submission | None:
    """Return the submission in a file or folder; None if it is none, such as a README, .git or a league's SITE.

    Raises:
        ConfigError: for a name that cannot be used.
        OSError: for a folder that cannot be read.
    """
    if _IGNORED.match(path.name) or (not path.is_dir() and not _SUBMITTED.search(path.name)):
        return None
    if path.name == SITE and (path.parent / STATE).is_dir():
        return None
    inside = sorted(path.iterdir()) if path.is_dir() else []
    files = [one for one in inside if _SUBMITTED.search(one.name) and not _IGNORED.match(one.name)]
    alone = len(files) == 1 and files[0].name != IN_FOLDER
    name = composed(path.name if path.is_dir() else path.stem)
    if (wrong := name_fault(name)) is not None:
        raise ConfigError(f"{str(path)!a}: {wrong}; rename it")
    return Submission(name, path, str(files[0] if alone else path))


def find_submissions(folder: Path) -> tuple[list[Submission], list[str]]:
    """Return the submissions in a folder by name, and the names of the files that are none."""
    found: list[Submission] = []
    others: list[str] = []
    for path in sorted(folder.iterdir()):
        submission = submission_at(path)
        if submission is not None:
            found.append(submission)
        elif not _IGNORED.match(path.name):
            others.append(path.name)
    if not found:
        raise ConfigError(f"{folder}: has no submission; it needs a .py file or a sub-folder for each student")
    name, times = Counter(one.name.casefold() for one in found).most_common(1)[0]
    if times > 1:
        twice = " and ".join(one.path.name for one in found if one.name.casefold() == name)
        raise ConfigError(f"{folder}: {twice} have one name; rename one of them")
    stems = {one.path.stem for one in found if not one.path.is_dir()}
    return found, [other for other in others if Path(other).stem not in stems]  # weights stand next to their agent
