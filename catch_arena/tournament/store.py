"""A tournament's matches, planned and played, in one SQLite file: what is in it outlives whatever happens to us.

Each block is a transaction of its own, in write-ahead mode: a process that is killed loses the matches under way, and
none that was kept. Keeping a match twice changes nothing.
"""

import os
import platform
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field, fields
from importlib.metadata import version
from itertools import groupby
from pathlib import Path
from types import TracebackType
from typing import Any, Final

import msgspec

from catch_arena.config import RULESET, ArenaConfig
from catch_arena.errors import OtherTournamentError, StoreError
from catch_arena.files import LEAST_FREE, is_full, is_loop, room
from catch_arena.text import one_line
from catch_arena.tournament import stored_values
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.match import Block, Match, PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.secret import Secret

STORE: Final = "tournament.sqlite"
_APPLICATION_ID: Final = 0x43417231  # SQLite's application_id: what kind of file it is
_FORMAT: Final = 5
_PAGE: Final = 1000
"""How many matches that wait are read at once."""
_PATIENCE_S: Final = 60.0
"""How long another process may hold the file."""
_FULL: Final = "SQLITE_FULL"
_FAILED: Final = "SQLITE_IOERR"
"""What SQLite says where it cannot write. It says the second on a full disk too, of the files beside its own."""
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
_COLUMNS: Final = ", ".join(f"{name} TEXT NOT NULL" for name in stored_values.RESULTS)
"""One for each part of a result, as JSON; logs are files."""
_STATEMENTS: Final = tuple(_TABLES.format(results=_COLUMNS).strip().removesuffix(";").split(";\n"))
_KEEP: Final = f"INSERT OR IGNORE INTO result VALUES (?, ?, ?{', ?' * len(stored_values.RESULTS)})"  # noqa: S608
_VERSIONS: Final = "SELECT id, value FROM versions"
_PLAYED: Final = (
    f"SELECT versions, match.*, replay, {', '.join(stored_values.RESULTS)} "  # noqa: S608
    "FROM result JOIN match ON match = id ORDER BY id LIMIT ?"
)


@dataclass(frozen=True, slots=True)
class Tournament:
    """The tournament whose matches a store holds; only the same tournament can continue it.

    Table `fact` has these fields by name, as JSON.
    """

    config: ArenaConfig
    entrants: tuple[Entrant, ...]
    plan: Mapping[str, str | int | float]
    """The plan's parameters."""
    terms: Mapping[str, str | int | float | bool] = field(default_factory=dict)
    """Its other terms: `recorded`, `trusted`, and the limits of isolated agents."""
    seed: str | None = field(default=None, repr=False)
    """`Secret.text`; None where the plan is not drawn, or not for others to repeat."""
    ruleset: str = RULESET

    def __post_init__(self) -> None:
        if self.ruleset != RULESET:
            raise ValueError(f"it was played under ruleset {self.ruleset}, and this is {RULESET}")
        if self.seed is not None:
            Secret.parse(self.seed)

    @classmethod
    def of(cls, facts: Mapping[str, str]) -> "Tournament":
        """Return the tournament that is stored so.

        Raises:
            DamagedError: for facts that no tournament of this version has.
        """
        try:
            values: dict[str, Any] = {name: msgspec.json.decode(text) for name, text in facts.items()}
            config: Any = values.get("config")
            values["config"] = ArenaConfig.from_dict(config)  # whole numbers stay whole
            return msgspec.convert(values, cls)
        except (ValueError, TypeError, RecursionError) as error:  # msgspec's are ValueErrors
            raise stored_values.DamagedError(f"table fact: {error}") from None

    @property
    def secret(self) -> Secret | None:
        """Secret that the plan is drawn from."""
        return None if self.seed is None else Secret.parse(self.seed)


def terms_of(limits: AgentLimits | None, max_forfeits: int, *, recorded: bool) -> dict[str, int | float]:
    """Return a tournament's `terms`.

    Args:
        limits: those of isolated agents, None where all are trusted.
        max_forfeits: see `execution.forfeit_streaks`.
        recorded: whether there are replays.
    """
    numbers = {} if limits is None else limits.numbers()
    return {"recorded": recorded, "trusted": limits is None, "max_forfeits": max_forfeits} | numbers


class Store:
    """The matches of one tournament. A context that closes the file.

    Raises:
        StoreError: for whatever SQLite refuses.
    """

    def __init__(self, path: Path | None = None, *, writable: bool = True) -> None:
        """Open the file, or one in memory; see `begin` and `read`."""
        self.path = path
        self._playing = ExitStack()
        name = ":memory:" if path is None else path.absolute().as_uri()
        if path is not None and not writable:
            # without a log there is no writer; with immutable=1, SQLite makes no files of its own to wait for one
            name += "?mode=ro" if path.with_name(f"{path.name}-wal").exists() else "?mode=ro&immutable=1"
        with self._store_errors():
            self._db = sqlite3.connect(name, isolation_level=None, timeout=_PATIENCE_S, uri=True)
        self._versions = 0

    @classmethod
    def begin(cls, tournament: Tournament, folder: Path | None = None, *, resume: bool = False) -> "Store":
        """The store of a tournament that is to be played, kept in memory where there is no folder.

        Raises:
            StoreError: if the folder has a store already that is not to be resumed, or another command plays in it.
            OtherTournamentError: where it is of another tournament.
        """
        path = None if folder is None else folder / STORE
        if path is not None and not path.exists():
            with suppress(OSError):  # SQLite says it in its words
                path.touch(0o600)  # it has the seeds of matches to come
        store = cls(path)
        with store._closed_on_error():
            if folder is not None:
                store._playing.enter_context(only_one_plays_in(folder))
            store._open(tournament, resume=resume)
        return store

    @classmethod
    def read(cls, folder: Path) -> "Store":
        """The store of a tournament that has begun.

        Raises:
            StoreError: if there is none; from here on also if something in it is damaged.
        """
        path = folder / STORE
        if is_loop(folder):
            raise StoreError(f"{folder}: is a link that leads to itself")
        if not path.is_file():
            raise StoreError(f"{folder}: holds no tournament (a file {STORE})")
        store = cls(path, writable=False)
        with store._closed_on_error():
            if not store._has_tables():
                raise StoreError(f"{folder}: holds a tournament that has not begun")
        return store

    @classmethod
    def secret_in(cls, folder: Path) -> Secret | None:
        """What the tournament in a folder is drawn from; None where there is none yet.

        Raises:
            StoreError: where it cannot be read.
        """
        path = folder / STORE
        if not path.is_file():
            return None
        with cls(path, writable=False) as store:
            return store.tournament.secret if store._has_tables() else None

    @property
    def tournament(self) -> Tournament:
        """Whose matches these are."""
        with self._store_errors():
            return Tournament.of(self._facts())

    @property
    def ended(self) -> bool:
        """Whether its plan has been played to its end: before, nobody may know what it is drawn from."""
        with self._store_errors():
            return self._facts().get("ended") == "true"

    def end(self) -> None:
        """The plan has no further matches."""
        with self.transaction() as db:
            db.execute("INSERT OR REPLACE INTO fact VALUES ('ended', 'true')")

    def plan(self, blocks: Iterable[Block]) -> int:
        """Write blocks that will be played, all or none; how many matches there are in them."""
        count = 0
        with self.transaction() as db:
            before = db.total_changes
            for match in (match for block in blocks for match in block):
                row = (match.id, match.block, match.seed, _json(match.seating), _json(match.agent_seeds))
                db.execute("INSERT OR IGNORE INTO match VALUES (?, ?, ?, ?, ?)", row)
                count += 1
            if db.total_changes > before:  # it may be longer than it was
                db.execute("DELETE FROM fact WHERE name = 'ended'")
        return count

    def keep(self, block: Iterable[PlayedMatch]) -> None:
        """Write matches that were played, all or none; one that was kept before stays as it was."""
        with self.transaction():
            for one in block:
                self._keep(one)

    def _keep(self, one: PlayedMatch) -> None:
        parts = {name: getattr(one.result, name) for name in stored_values.RESULTS}
        parts["thinking"] = [
            (part.moves, round(part.total_s, 6), round(part.longest_s, 6)) for part in one.result.thinking
        ]
        parts["details"] = [part and (part.code, part.step, part.reason) for part in one.result.details]
        self._db.execute(_KEEP, (one.match.id, self._versions, one.replay, *map(_json, parts.values())))

    def waiting(self) -> Iterator[Block]:
        """The matches that are planned and not played, by block, in the order of the plan."""
        for _, block in groupby(self._waiting(), key=lambda match: match.block):
            yield tuple(block)

    def _waiting(self) -> Iterator[Match]:
        """Match by match, read a page at a time: in between there are writes."""
        after, shape = "", self._shape()
        while True:
            with self._store_errors():
                found = self._db.execute(
                    "SELECT match.* FROM match LEFT JOIN result ON match = id "
                    "WHERE result.match IS NULL AND id > ? ORDER BY id LIMIT ?",
                    (after, _PAGE),
                ).fetchall()
                page = [stored_values.match_of(row, *shape) for row in found]
            if not page:
                return
            yield from page
            after = page[-1].id

    def played(self, most: int = -1) -> Iterator[PlayedMatch]:
        """What was played, in the order of the plan; `most`, at most so many."""
        return (one for one, _ in self.records(most))

    def records(self, most: int = -1) -> Iterator[tuple[PlayedMatch, dict[str, str]]]:
        """The same, each with the versions that played it."""
        shape = self._shape()
        with self._store_errors():
            known = {key: stored_values.versions_of(key, text) for key, text in self._db.execute(_VERSIONS)}
            for by, *row in self._db.execute(_PLAYED, (most,)):
                yield stored_values.played_of(row, *shape), known[by]

    def count_played(self) -> int:
        """How many matches were played."""
        return self._count("result")

    def count_planned(self) -> int:
        """How many matches are planned so far, those that were played included."""
        return self._count("match")

    def close(self) -> None:
        """Close the file; another command may play in its folder then."""
        self._db.close()
        self._playing.close()

    def __enter__(self) -> "Store":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def _name(self) -> str:
        return "the store" if self.path is None else str(self.path)

    def _open(self, tournament: Tournament, *, resume: bool) -> None:
        begun = self._has_tables()  # before anything is changed in a file that may not be ours
        with self._store_errors():
            self._db.execute("PRAGMA journal_mode = WAL")
            self._db.execute("PRAGMA synchronous = NORMAL")  # a power cut may take the last matches, but never the file
            self._db.execute("PRAGMA foreign_keys = ON")
        with self.transaction() as db:
            if not begun and not self._has_tables():
                for statement in _STATEMENTS:
                    db.execute(statement)
                db.execute(f"PRAGMA application_id = {_APPLICATION_ID}")
                db.execute(f"PRAGMA user_version = {_FORMAT}")
            if not self.count_planned():  # whoever began it got no further
                facts = [(one.name, _json(getattr(tournament, one.name))) for one in fields(tournament)]
                db.executemany("INSERT OR REPLACE INTO fact VALUES (?, ?)", facts)
            elif not resume:
                raise StoreError(
                    f"{self._name}: holds a tournament already, with {self.count_played()} of {self.count_planned()} "
                    "matches played: go on with --resume, or give another folder"
                )
            elif found := difference(self.tournament, tournament):
                message = f"{self._name}: is of another tournament: {found}"
                raise StoreError(message) if self.path is None else OtherTournamentError(message, self.path.parent)
            text = _json(versions())
            db.execute("INSERT OR IGNORE INTO versions (value) VALUES (?)", (text,))
            (self._versions,) = db.execute("SELECT id FROM versions WHERE value = ?", (text,)).fetchone()

    def _has_tables(self) -> bool:
        """Whether there is anything in it.

        Raises:
            StoreError: for what we have not made, or in another format.
        """
        with self._store_errors():
            (application_id,) = self._db.execute("PRAGMA application_id").fetchone()
            (form,) = self._db.execute("PRAGMA user_version").fetchone()
            empty = not self._count("sqlite_schema")
        if empty:
            return False
        if application_id != _APPLICATION_ID:
            raise StoreError(f"{self._name}: is no store of a tournament")
        if form != _FORMAT:
            raise StoreError(f"{self._name}: is of format {form}, and this version reads format {_FORMAT}")
        with self._store_errors():
            (found,) = self._db.execute("PRAGMA quick_check(1)").fetchone()
            if found != "ok":
                raise stored_values.DamagedError(str(found))
        return True

    def _facts(self) -> dict[str, str]:
        return dict(self._db.execute("SELECT name, value FROM fact"))

    def _shape(self) -> tuple[int, int]:
        """Return the number of parties in a match, and of entrants."""
        tournament = self.tournament
        return len(Parties.of(tournament.config)), len(tournament.entrants)

    def _count(self, table: str) -> int:
        with self._store_errors():
            return int(self._db.execute(f"SELECT count(*) FROM {table}").fetchone()[0])  # noqa: S608 - ours

    @contextmanager
    def _closed_on_error(self) -> Iterator[None]:
        try:
            yield
        except BaseException:
            self.close()
            raise

    @contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """What is written in it is kept, all or none."""
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
        except stored_values.DamagedError as error:
            raise StoreError(f"{self._name}: is damaged: {one_line(str(error))}") from None
        except UnicodeError:  # of what SQLite itself says
            raise StoreError(f"{self._name}: is damaged: it holds what is no text") from None
        except sqlite3.Error as error:
            raise StoreError(f"{self._name}: {one_line(self._message(error))}") from None

    def _message(self, error: sqlite3.Error) -> str:
        """What SQLite says; where it cannot write, with the room that there is, and what the rest needs."""
        name = getattr(error, "sqlite_errorname", "")
        if self.path is None or not name.startswith((_FULL, _FAILED)):
            return f"cannot be used: {error}"
        folder, needed = self.path.parent, self._bytes_needed()
        why = "the disk is full" if name == _FULL or is_full(folder, max(LEAST_FREE, needed or 0)) else error
        return f"cannot be written: {why}: {room(folder, needed)}"

    def _bytes_needed(self) -> int | None:
        """Bytes for the matches that wait, about; None where the plan is not written either."""
        with suppress(sqlite3.Error):
            (count,) = self._db.execute(
                "SELECT count(*) FROM match LEFT JOIN result ON match = id WHERE result.match IS NULL"
            ).fetchone()
            for (seating,) in self._db.execute("SELECT seating FROM match LIMIT 1"):
                return int(count) * store_bytes(str(seating).count(",") + 1)
        return None


@contextmanager
def only_one_plays_in(folder: Path) -> Iterator[None]:
    """Hold a lock on a folder, which the kernel releases with this process. On Windows there is none.

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
    except OSError:  # it cannot be read; whoever writes there says so
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
    """What plays in this process, by version: the package, Python, NumPy and Numba."""
    return {
        "catch_arena": version("catch-arena"),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "numba": version("numba"),
    }


def store_bytes(parties: int) -> int:
    """Return about how many bytes a match takes in the store (docs/tournaments.md)."""
    return 90 + 84 * parties


def difference(there: Tournament, here: Tournament) -> str | None:
    """Return the first fact in which a stored tournament differs from this one, in words; None if there is none."""
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
                what = f"the {name.replace('_', ' ')} of agent {now.name}"
                return f"{what} is {getattr(begun, name)} there, and {getattr(now, name)} here"
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
