"""Store of a tournament's planned and played matches: one SQLite file, which survives the end of any process.

Each block is a separate transaction, in write-ahead mode: a killed process loses the matches under way, and no stored
match. Storing a match twice changes nothing.
"""

import os
import platform
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field, fields
from importlib.metadata import version
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import msgspec

from catch_arena.config import RULESET, ArenaConfig
from catch_arena.errors import OtherTournamentError, StoreError
from catch_arena.files import LEAST_FREE, is_full, is_loop, room
from catch_arena.text import one_line
from catch_arena.tournament import store_rows
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.match import Block, Match, PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.secret import Secret

if TYPE_CHECKING:
    from typing_extensions import Self

STORE: Final = "tournament.sqlite"
_APPLICATION_ID: Final = 0x43417231  # SQLite's application_id: the kind of the file
_FORMAT: Final = 5
_PAGE: Final = 1000
"""Number of waiting matches that are read at a time."""
_PATIENCE_S: Final = 60.0
"""Longest time that another process may lock the file [s]."""
_FULL: Final = "SQLITE_FULL"
_FAILED: Final = "SQLITE_IOERR"
"""Names of SQLite's errors if it cannot write. A full disk may give _FAILED too, if a helper file is written."""
_TABLES: Final = """
CREATE TABLE fact (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE versions (id INTEGER PRIMARY KEY, value TEXT NOT NULL UNIQUE);
CREATE TABLE match (
    id TEXT PRIMARY KEY,
    block INTEGER NOT NULL,
    seed INTEGER NOT NULL,
    seating TEXT NOT NULL,
    agent_seeds TEXT NOT NULL
) WITHOUT ROWID;
CREATE TABLE result (
    match TEXT PRIMARY KEY REFERENCES match (id),
    versions INTEGER NOT NULL REFERENCES versions (id),
    replay TEXT,
    {results}
) WITHOUT ROWID;
"""
_COLUMNS: Final = ", ".join(f"{name} TEXT NOT NULL" for name in store_rows.RESULTS)
"""Columns of a result, one for each part, as JSON; logs are files."""
_STATEMENTS: Final = tuple(_TABLES.format(results=_COLUMNS).strip().removesuffix(";").split(";\n"))
_ADD: Final = f"INSERT OR IGNORE INTO result VALUES (?, ?, ?{', ?' * len(store_rows.RESULTS)})"  # noqa: S608
_VERSIONS: Final = "SELECT id, value FROM versions"
_PLAYED: Final = (
    f"SELECT versions, match.*, replay, {', '.join(store_rows.RESULTS)} "  # noqa: S608
    "FROM result JOIN match ON match = id ORDER BY id LIMIT ?"
)


@dataclass(frozen=True, slots=True)
class Tournament:
    """Tournament whose matches a store holds; only the same tournament can continue it.

    Table `fact` has these fields by name, as JSON.
    """

    config: ArenaConfig
    entrants: tuple[Entrant, ...]
    plan: Mapping[str, str | int | float]
    """Parameters of the plan."""
    seed: str = field(repr=False)
    """Seed as `Secret.text`."""
    terms: Mapping[str, str | int | float | bool] = field(default_factory=dict)
    """Other terms of the tournament: `recorded`, `trusted`, `max_forfeits`, and the quotas of isolated agents."""
    ruleset: str = RULESET

    def __post_init__(self) -> None:
        if self.ruleset != RULESET:
            raise ValueError(f"it was played under ruleset {self.ruleset}, and this is {RULESET}")
        Secret.parse(self.seed)

    @classmethod
    def of(cls, facts: Mapping[str, str]) -> "Tournament":
        """Return the tournament described by `facts`, the rows of the table `fact`.

        Raises:
            DamagedError: for facts that are invalid in this version.
        """
        try:
            values: dict[str, Any] = {name: msgspec.json.decode(text) for name, text in facts.items()}
            config: Any = values.get("config")
            values["config"] = ArenaConfig.from_dict(config)  # integers stay integers
            return msgspec.convert(values, cls)
        except (ValueError, TypeError, RecursionError) as error:  # msgspec's are ValueErrors
            raise store_rows.DamagedError(f"table fact: {error}") from None

    @property
    def secret(self) -> Secret:
        """Secret that the plan is drawn from."""
        return Secret.parse(self.seed)


def terms_of(quotas: Quotas | None, max_forfeits: int, *, recorded: bool) -> dict[str, int | float]:
    """Return the `terms` of a tournament.

    Args:
        quotas: quotas of isolated agents; None if all are trusted.
        max_forfeits: number of forfeits in a row that exclude an entrant; 0 for no limit.
        recorded: True if replays are kept.
    """
    numbers = {} if quotas is None else quotas.numbers()
    return {"recorded": recorded, "trusted": quotas is None, "max_forfeits": max_forfeits} | numbers


class Store:
    """Store of one tournament's matches; `begin` and `read` open it for the time of a `with` statement.

    Raises:
        StoreError: if SQLite reports an error; this holds for all methods.
    """

    def __init__(self, path: Path, *, writable: bool) -> None:
        """Open the file; see `begin` and `read`."""
        self.path = path
        name = path.absolute().as_uri()
        if not writable:
            # without a log there is no writer, and with immutable=1 SQLite makes no helper files
            name += "?mode=ro" if path.with_name(f"{path.name}-wal").exists() else "?mode=ro&immutable=1"
        with self._store_errors():
            self._db = sqlite3.connect(name, isolation_level=None, timeout=_PATIENCE_S, uri=True)
        self._versions = 0

    @classmethod
    @contextmanager
    def begin(cls, tournament: Tournament, folder: Path, *, resume: bool = False) -> "Iterator[Self]":
        """Open the store for playing a tournament; other commands cannot play in its folder meanwhile.

        Raises:
            StoreError: if the folder has a store already that is not to be resumed, or another command plays in it.
            OtherTournamentError: if the folder's store is of another tournament.
        """
        path = folder / STORE
        if not path.exists():
            with suppress(OSError):  # SQLite reports the error below
                path.touch(0o600)  # the file has the seeds of future matches
        store = cls(path, writable=True)
        with closing(store), only_one_plays_in(folder):
            store._begin(tournament, resume=resume)
            yield store

    @classmethod
    @contextmanager
    def read(cls, folder: Path) -> Iterator["Store"]:
        """Open the store of a tournament that has begun, for reading.

        Raises:
            StoreError: if there is none; here and in later calls also if the file is damaged.
        """
        path = folder / STORE
        if is_loop(folder):
            raise StoreError(f"{folder}: is a link that leads to itself")
        if not path.is_file():
            raise StoreError(f"{folder}: holds no tournament (a file {STORE})")
        store = cls(path, writable=False)
        with closing(store):
            if not store._has_tables():
                raise StoreError(f"{folder}: holds a tournament that has not begun")
            yield store

    @classmethod
    def tournament_in(cls, folder: Path) -> Tournament | None:
        """Return the tournament in a folder; None if none has begun.

        Raises:
            StoreError: if the store cannot be read.
        """
        path = folder / STORE
        if not path.is_file():
            return None
        store = cls(path, writable=False)
        with closing(store):
            return store.tournament if store._has_tables() else None

    @property
    def tournament(self) -> Tournament:
        """Tournament whose matches the store holds."""
        with self._store_errors():
            return Tournament.of(self._facts())

    @property
    def ended(self) -> bool:
        """True if the plan has been played to its end; its secret must not be shown earlier."""
        with self._store_errors():
            return self._facts().get("ended") == "true"

    def end(self) -> None:
        """Mark the plan as played to its end."""
        with self.transaction() as db:
            db.execute("INSERT OR REPLACE INTO fact VALUES ('ended', 'true')")

    def plan(self, blocks: Iterable[Block]) -> int:
        """Write blocks that will be played, all or none, and return the number of their matches."""
        count = 0
        with self.transaction() as db:
            before = db.total_changes
            for match in (match for block in blocks for match in block):
                row = (match.id, match.block, match.seed, _json(match.seating), _json(match.agent_seeds))
                db.execute("INSERT OR IGNORE INTO match VALUES (?, ?, ?, ?, ?)", row)
                count += 1
            if db.total_changes > before:  # the plan may be longer than before
                db.execute("DELETE FROM fact WHERE name = 'ended'")
        return count

    def add(self, block: Iterable[PlayedMatch]) -> None:
        """Write played matches, all or none; a match that was stored before is not changed."""
        with self.transaction():
            for one in block:
                self._add_match(one)

    def _add_match(self, one: PlayedMatch) -> None:
        parts = {column: getattr(one.result, name) for column, name in store_rows.RESULTS.items()}
        parts["thinking"] = [
            (part.moves, round(part.total_s, 6), round(part.longest_s, 6)) for part in one.result.thinking
        ]
        parts["details"] = [part and (part.code, part.step, part.reason) for part in one.result.forfeits]
        self._db.execute(_ADD, (one.match.id, self._versions, one.replay, *map(_json, parts.values())))

    def waiting(self) -> Iterator[Block]:
        """Yield the blocks that are planned and not played, in the order of the plan."""
        for _, block in groupby(self._waiting(), key=lambda match: match.block):
            yield tuple(block)

    def _waiting(self) -> Iterator[Match]:
        """Yield the waiting matches, read in pages: other results are written meanwhile."""
        after, shape = "", self._shape()
        while True:
            with self._store_errors():
                found = self._db.execute(
                    "SELECT match.* FROM match LEFT JOIN result ON match = id "
                    "WHERE result.match IS NULL AND id > ? ORDER BY id LIMIT ?",
                    (after, _PAGE),
                ).fetchall()
                page = [store_rows.decode_match(row, *shape) for row in found]
            if not page:
                return
            yield from page
            after = page[-1].id

    def played(self, most: int = -1) -> Iterator[PlayedMatch]:
        """Return the played matches in the order of the plan: at most `most`, or all if -1."""
        return (one for one, _ in self.records(most))

    def records(self, most: int = -1) -> Iterator[tuple[PlayedMatch, dict[str, str]]]:
        """Yield the played matches, as `played` does, each with the package versions that played it."""
        shape = self._shape()
        with self._store_errors():
            known = {key: store_rows.decode_versions(key, text) for key, text in self._db.execute(_VERSIONS)}
            for by, *row in self._db.execute(_PLAYED, (most,)):
                yield store_rows.decode_played_match(row, *shape), known[by]

    def count_played(self) -> int:
        """Return the number of played matches."""
        return self._count("result")

    def count_planned(self) -> int:
        """Return the number of planned matches so far, played ones included."""
        return self._count("match")

    def close(self) -> None:
        """Close the file."""
        self._db.close()

    def _begin(self, tournament: Tournament, *, resume: bool) -> None:
        begun = self._has_tables()  # before any change: the file may not be ours
        with self._store_errors():
            self._db.execute("PRAGMA journal_mode = WAL")
            self._db.execute("PRAGMA synchronous = NORMAL")  # a power cut may lose the last matches, but never the file
            self._db.execute("PRAGMA foreign_keys = ON")
        with self.transaction() as db:
            if not begun and not self._has_tables():
                for statement in _STATEMENTS:
                    db.execute(statement)
                db.execute(f"PRAGMA application_id = {_APPLICATION_ID}")
                db.execute(f"PRAGMA user_version = {_FORMAT}")
            if not self.count_planned():  # an earlier command ended before it planned a match
                facts = [(one.name, _json(getattr(tournament, one.name))) for one in fields(tournament)]
                db.executemany("INSERT OR REPLACE INTO fact VALUES (?, ?)", facts)
            elif not resume:
                raise StoreError(
                    f"{self.path}: holds a tournament already, with {self.count_played()} of {self.count_planned()} "
                    "matches played: go on with --resume, or give another folder"
                )
            elif found := difference(self.tournament, tournament):
                raise OtherTournamentError(f"{self.path}: is of another tournament: {found}", self.path.parent)
            text = _json(versions())
            db.execute("INSERT OR IGNORE INTO versions (value) VALUES (?)", (text,))
            (self._versions,) = db.execute("SELECT id FROM versions WHERE value = ?", (text,)).fetchone()

    def _has_tables(self) -> bool:
        """Return whether the file has tables of this format; False if it is empty.

        Raises:
            StoreError: if the file is no store, is damaged, or has another format.
        """
        with self._store_errors():
            (application_id,) = self._db.execute("PRAGMA application_id").fetchone()
            (form,) = self._db.execute("PRAGMA user_version").fetchone()
            empty = not self._count("sqlite_schema")
        if empty:
            return False
        if application_id != _APPLICATION_ID:
            raise StoreError(f"{self.path}: is no store of a tournament")
        if form != _FORMAT:
            raise StoreError(f"{self.path}: is of format {form}, and this version reads format {_FORMAT}")
        with self._store_errors():
            (found,) = self._db.execute("PRAGMA quick_check(1)").fetchone()
            if found != "ok":
                raise store_rows.DamagedError(str(found))
        return True

    def _facts(self) -> dict[str, str]:
        return dict(self._db.execute("SELECT name, value FROM fact"))

    def _shape(self) -> tuple[int, int]:
        """Return the number of parties in a match, and the number of entrants."""
        tournament = self.tournament
        return len(Parties.of(tournament.config)), len(tournament.entrants)

    def _count(self, table: str) -> int:
        with self._store_errors():
            return int(self._db.execute(f"SELECT count(*) FROM {table}").fetchone()[0])  # noqa: S608 - ours

    @contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """Open a transaction: all writes in it are kept, or none if it raises."""
        with self._store_errors():
            self._db.execute("BEGIN IMMEDIATE")
            try:
                yield self._db
                self._db.execute("COMMIT")
            except BaseException:
                if self._db.in_transaction:  # on a full disk SQLite may have rolled back itself
                    self._db.execute("ROLLBACK")
                raise

    @contextmanager
    def _store_errors(self) -> Iterator[None]:
        try:
            yield
        except store_rows.DamagedError as error:
            raise StoreError(f"{self.path}: is damaged: {one_line(str(error))}") from None
        except UnicodeError:  # in a message of SQLite
            raise StoreError(f"{self.path}: is damaged: it holds what is no text") from None
        except sqlite3.Error as error:
            raise StoreError(f"{self.path}: {one_line(self._message(error))}") from None

    def _message(self, error: sqlite3.Error) -> str:
        """Return an error of SQLite in words; if it cannot write, with the free and the needed space."""
        name = getattr(error, "sqlite_errorname", "")
        if not name.startswith((_FULL, _FAILED)):
            return f"cannot be used: {error}"
        folder, needed = self.path.parent, self._bytes_needed()
        why = "the disk is full" if name == _FULL or is_full(folder, max(LEAST_FREE, needed or 0)) else error
        return f"cannot be written: {why}: {room(folder, needed)}"

    def _bytes_needed(self) -> int | None:
        """Return the approximate size of the waiting matches [bytes]; None if no plan is written yet."""
        with suppress(sqlite3.Error):
            (count,) = self._db.execute(
                "SELECT count(*) FROM match LEFT JOIN result ON match = id WHERE result.match IS NULL"
            ).fetchone()
            for (seating,) in self._db.execute("SELECT seating FROM match LIMIT 1"):
                return int(count) * store_bytes(str(seating).count(",") + 1)
        return None


@contextmanager
def only_one_plays_in(folder: Path) -> Iterator[None]:
    """Hold a lock on a folder, which the kernel releases when this process ends. Windows has no such lock.

    Raises:
        StoreError: if another command holds it.
    """
    try:
        import fcntl
    except ImportError:
        yield
        return
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except OSError:  # the folder cannot be read: writing to it raises an error with the reason
        yield
        return
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        raise StoreError(f"{folder}: another command is playing in this folder") from None
    except OSError:  # this file system has no such locks
        pass
    try:
        yield
    finally:
        os.close(descriptor)


def versions() -> dict[str, str]:
    """Return the versions in this process, by name: of the package, Python, NumPy and Numba."""
    return {
        "catch_arena": version("catch-arena"),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "numba": version("numba"),
    }


def store_bytes(parties: int) -> int:
    """Return the approximate size of a match in the store [bytes] (docs/howto/long_runs.md)."""
    return 90 + 84 * parties


def difference(there: Tournament, here: Tournament) -> str | None:
    """Return the first difference between a stored tournament and this one, in words; None if there is none."""
    old, new = ({**one.config.to_dict(), **one.plan, **one.terms} for one in (there, here))
    for name in (*old, *new):
        if old.get(name) != new.get(name):
            return f"{name} is {_shown(old.get(name))} there, and {_shown(new.get(name))} here"
    names = [" ".join(entrant.name for entrant in one.entrants) for one in (there, here)]
    if names[0] != names[1]:
        return f"its agents are {names[0]}, and here {names[1]}"
    compared = ("digest", "control", "prey", *(["prey_digest"] if here.config.prey else []))
    for begun, now in zip(there.entrants, here.entrants, strict=True):
        for name in compared:
            if getattr(begun, name) != getattr(now, name):
                subject = f"the {name.replace('_', ' ')} of agent {now.name}"
                return f"{subject} is {getattr(begun, name)} there, and {getattr(now, name)} here"
        fit = ["can begin" if one.fault is None else "cannot begin" for one in (begun, now)]
        if fit[0] != fit[1]:
            return f"agent {now.name} {fit[0]} there, and {fit[1]} here"
    if there.secret != here.secret:
        return "its seed is another one; without --seed it keeps its own"
    return None


def _shown(value: object) -> str:
    return "not given" if value is None else _json(value)


def _json(value: object) -> str:
    return msgspec.json.encode(value).decode()
