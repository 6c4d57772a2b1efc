"""Entries of a league: one file or sub-folder for each person, with an optional name and photo."""

import base64
import hashlib
import shutil
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

from catch_arena.classroom.submissions import Submission, submission_at
from catch_arena.errors import CatchArenaError, ConfigError
from catch_arena.files import read_text, unwritable
from catch_arena.text import name_fault, one_line
from catch_arena.tournament.entrants import Entrant, enter

SITE: Final = "site"
"""Folder of the pages, in the league's folder."""
SHIPPED: Final = (
    *("nearest", "random", "intercept", "contested", "first", "corners", "patrol", "tour", "assignment", "voronoi"),
    *("triage", "spoiler", "pure_pursuit", "pid", "contested_by_time"),
)
"""Agents that come with the package, in the order in which they take part. The first one's rating is 0."""
_FEWEST_SHIPPED: Final = 3
_NAME: Final = "name.txt"
_PHOTOS: Final = {"photo.png": b"\x89PNG", "photo.jpg": b"\xff\xd8\xff"}
"""Names of photos, with the first bytes of such a file."""
_LARGEST_PHOTO: Final = 200_000
_LARGEST: Final = 64_000_000
"""Largest size of an entry's files together [bytes]."""
_MOST_FILES: Final = 1000

Kind = Literal["person", "secret", "shipped"]


@dataclass(frozen=True, slots=True)
class Entry:
    """Agent that takes part in a league, in its present version."""

    key: str
    """Name of its file or folder; with `secret/` or `shipped/` before it for other kinds."""
    kind: Kind
    name: str
    """Name on the pages and in replays."""
    digest: str
    """Digest of its files, without name and photo."""
    submission: Submission | None = None
    """Files of the entry; None for an agent that comes with the package."""
    photo: str = ""
    """Photo as an address of the scheme `data`; empty for none."""

    def copy_to(self, versions: Path) -> str:
        """Copy its files, so that a person can change them while they play, and return the agent in the copy.

        Raises:
            OutputError: if they cannot be written.
        """
        if self.submission is None:
            return self.name
        target, unfinished = versions / self.digest, versions / "unfinished"
        try:
            if not target.exists():
                shutil.rmtree(unfinished, ignore_errors=True)
                for path in _files(self.submission):
                    copy = unfinished / path.relative_to(_root(self.submission))
                    copy.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copyfile(path, copy)
                unfinished.rename(target)
        except OSError as error:
            raise unwritable(target, error) from None
        return str(target / Path(self.submission.agent).relative_to(_root(self.submission)))


def find_entries(folder: Path, kind: Kind) -> tuple[list[Entry], list[str]]:
    """Return the entries in a folder, and for each file or folder that is left out the reason.

    Raises:
        ConfigError: if the folder cannot be read.
    """
    found: list[Entry] = []
    faults: list[str] = []
    try:
        paths = sorted(path for path in folder.iterdir() if path.name != SITE)
    except OSError as error:
        raise ConfigError(f"{folder}: cannot be read: {error.strerror}") from None
    for path in paths:
        try:
            submission = submission_at(path)
            if submission is not None:
                found.append(_entry(submission, kind, len(found) + 1))
        except (CatchArenaError, OSError) as error:
            faults.append(f"{path.name} is left out: {getattr(error, 'strerror', None) or one_line(str(error))}")
    times = Counter(one.key.casefold() for one in found)
    for key in [key for key, count in times.items() if count > 1]:
        twice = [one for one in found if one.key.casefold() == key]
        names = " and ".join(one.submission.path.name for one in twice if one.submission is not None)
        faults.append(f"{names} are left out: they have one name; rename one of them")
    return [one for one in found if times[one.key.casefold()] == 1], faults


def shipped_entries(group: int) -> list[Entry]:
    """Return the agents that come with the package and take part, so that one person is enough for a league.

    Args:
        group: number of players in a block.
    """
    names = SHIPPED[: max(_FEWEST_SHIPPED, group - 1)]
    return [Entry(f"shipped/{one.name}", "shipped", one.name, one.digest) for one in enter(names)]


def entrant_name(entry: Entry, number: int, taken: Sequence[Entrant]) -> str:
    """Return the name of a version of an entry, which no other entrant has."""
    name = entry.name if number == 1 else f"{entry.name} v{number}"
    names = {one.name for one in taken}
    return next(one for one in (name, *(f"{name}#{copy}" for copy in range(2, len(names) + 3))) if one not in names)


def _entry(submission: Submission, kind: Kind, number: int) -> Entry:
    digest, size, files = hashlib.blake2b(digest_size=16), 0, _files(submission)
    if not files:
        raise ConfigError("it has no file that can be read; links are not followed")
    for path in files:
        size += path.stat().st_size
        if size > _LARGEST or len(files) > _MOST_FILES:
            raise ConfigError(f"it must have at most {_MOST_FILES} files and {_LARGEST // 1_000_000} MB")
        digest.update(bytes(path.relative_to(_root(submission))) + b"\0" + path.read_bytes() + b"\0")
    name = f"secret opponent {number}" if kind == "secret" else _shown_name(submission)
    key = submission.name if kind == "person" else f"{kind}/{submission.name}"
    return Entry(key, kind, name, digest.hexdigest(), submission, _photo(submission))


def _files(submission: Submission) -> list[Path]:
    """Return the files of its agent. Links are left out: they could lead to files of others."""
    profile = {_NAME, *_PHOTOS} if submission.path.is_dir() else set()
    return [path for path in submission.files if not path.is_symlink() and path.name not in profile]


def _root(submission: Submission) -> Path:
    return submission.path if submission.path.is_dir() else submission.path.parent


def _shown_name(submission: Submission) -> str:
    path = submission.path / _NAME
    if not path.is_file() or path.is_symlink():
        return submission.name
    name = one_line(read_text(path))
    if (fault := name_fault(name)) is not None or "/" in name:
        raise ConfigError(f"{_NAME}: {fault or 'its name must have no /'}")
    return name


def _photo(submission: Submission) -> str:
    for name, beginning in _PHOTOS.items():
        path = submission.path / name
        if not path.is_file() or path.is_symlink():
            continue
        content = path.read_bytes()
        if not content.startswith(beginning) or len(content) > _LARGEST_PHOTO:
            raise ConfigError(f"{name} must be such a picture, of at most {_LARGEST_PHOTO // 1000} kB")
        kind = "png" if name.endswith("png") else "jpeg"
        return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"
    return ""
