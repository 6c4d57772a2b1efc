"""Entries of a league: one file or sub-folder for each person, with an optional name and photo."""

import base64
import hashlib
import shutil
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Literal

from catch_arena.classroom.submissions import SITE, Submission, submission_at
from catch_arena.errors import CatchArenaError, ConfigError
from catch_arena.files import read_text, unwritable
from catch_arena.text import name_fault, one_line, printable
from catch_arena.tournament.agent_spec import IN_FOLDER
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.players import enter

SHIPPED: Final = (
    *("nearest", "random", "intercept", "contested", "first", "corners", "patrol", "tour", "assignment", "voronoi"),
    *("triage", "spoiler", "pure_pursuit", "pid", "contested_by_time"),
)
"""Agents that come with the package, in the order in which they take part. The first one's rating is 0."""
_FEWEST_SHIPPED: Final = 3
_NAME: Final = "name.txt"
_PHOTOS: Final = {"photo.png": "png", "photo.jpg": "jpeg"}
"""Names of photos, with their media types."""
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
    fault: str = ""
    """Reason for which its files cannot be used; empty if they can be."""

    def copy_to(self, versions: Path) -> str:
        """Copy the entry's files, which may change while the agent plays, and return the agent in the copy.

        Raises:
            ConfigError: if the files change meanwhile.
        """
        if self.submission is None or self.fault:
            return self.name
        root, target, unfinished = _root(self.submission), versions / self.digest, versions / "unfinished"
        try:
            if not target.exists():
                shutil.rmtree(unfinished, ignore_errors=True)
                copies = []
                for path in _files(self.submission):
                    copies.append(copy := unfinished / path.relative_to(root))
                    copy.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copyfile(path, copy)
                if _digest(copies, unfinished) != self.digest:
                    raise ConfigError("its files change; the next run takes them")
                unfinished.rename(target)
        except OSError as error:
            raise unwritable(target, error) from None
        return str(target / Path(self.submission.agent).relative_to(root))


def find_entries(folder: Path, kind: Kind, report: Callable[[str], None], without: Path | None = None) -> list[Entry]:
    """Return the entries in a folder, except `without`; `report` gets a warning about each that is left out."""
    found: dict[str, list[Submission]] = {}
    if (folder / SITE / IN_FOLDER).exists():
        raise ConfigError(f"{folder / SITE}: is the folder of the pages; rename this entry")
    try:
        left_out = {(folder / SITE).resolve(), *([] if without is None else [without.resolve()])}
        paths = sorted(path for path in folder.iterdir() if path.resolve() not in left_out)
    except OSError as error:
        raise ConfigError(f"{folder}: cannot be read: {error.strerror}") from None
    for path in paths:
        try:
            submission = submission_at(path)
        except (CatchArenaError, OSError) as error:
            report(f"warning: {printable(path.name)} is left out: {_reason(error)}")
            continue
        if submission is not None:
            found.setdefault(submission.name.casefold(), []).append(submission)
    return [_entry(same, kind, report) for same in found.values()]


def shipped_entries(group: int) -> list[Entry]:
    """Return agents that come with the package, so that one person is enough for blocks of `group` players."""
    names = SHIPPED[: max(_FEWEST_SHIPPED, group - 1)]
    return [Entry(f"shipped/{one.name}", "shipped", one.name, one.digest) for one in enter(names)]


def with_own_names(entries: Sequence[Entry]) -> list[Entry]:
    """Return the entries such that no two have one name: a later one gets a number."""
    names = Counter[str]()
    named = []
    for entry in entries:
        names[entry.name] += 1
        number = names[entry.name]
        named.append(entry if number == 1 else replace(entry, name=f"{entry.name} ({number})"))
    return named


def entrant_name(entry: Entry, number: int, taken: Sequence[Entrant]) -> str:
    """Return the name of a version of an entry, which no other entrant has."""
    name = entry.name if number == 1 else f"{entry.name} v{number}"
    names = {one.name for one in taken}
    return next(one for one in (name, *(f"{name}#{copy}" for copy in range(2, len(names) + 3))) if one not in names)


def _entry(same: Sequence[Submission], kind: Kind, report: Callable[[str], None]) -> Entry:
    """Return the entry of the submissions with one name, which must be one, and report faults of its name and photo."""
    submission = same[0]
    key = submission.name if kind == "person" else f"{kind}/{submission.name}"
    # the name must not change if other opponents come
    name = submission.name if kind == "person" else f"secret opponent {_hash(key)[:4]}"
    try:
        if len(same) > 1:
            names = " and ".join(one.path.name for one in same)
            raise ConfigError(f"{names} have one name; rename one of them")
        files = _files(submission)
        if submission.path.is_symlink() or not files:
            raise ConfigError("it has no file that can be read; links are not followed")
        if len(files) > _MOST_FILES or sum(path.stat().st_size for path in files) > _LARGEST:
            raise ConfigError(f"it must have at most {_MOST_FILES} files and {_LARGEST // 1_000_000} MB")
        entry = Entry(key, kind, name, _digest(files, _root(submission)), submission)
    except (ConfigError, OSError) as error:
        return Entry(key, kind, name, _hash(_reason(error)), submission, fault=_reason(error))
    try:
        if kind == "person":
            entry = replace(entry, name=_shown_name(submission))
            entry = replace(entry, photo=_photo(submission))
    except (ConfigError, OSError) as error:
        report(f"warning: {key}: {_reason(error)}")
    return entry


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or one_line(str(error))


def _hash(text: str) -> str:
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()


def _digest(files: Sequence[Path], root: Path) -> str:
    """Return the digest of the names and contents of files in a folder."""
    digest = hashlib.blake2b(digest_size=16)
    for path in files:
        digest.update(bytes(path.relative_to(root)) + b"\0" + hashlib.blake2b(path.read_bytes()).digest())
    return digest.hexdigest()


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
        raise ConfigError(f"{_NAME}: {fault or f'its name must have no /, got {name!r}'}")
    return name


def _photo(submission: Submission) -> str:
    for name, kind in _PHOTOS.items():
        path = submission.path / name
        if path.is_file() and not path.is_symlink():
            if path.stat().st_size > _LARGEST_PHOTO:
                raise ConfigError(f"{name} must have at most {_LARGEST_PHOTO // 1000} kB")
            return f"data:image/{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"
    return ""
