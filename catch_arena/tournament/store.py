"""Store of a tournament's played matches: one SQLite file, which survives the end of any process.

Each block is a separate transaction, in write-ahead mode: a killed process loses the matches under way, and no stored
match. Blocks are stored in the order of the plan, so a store has the first blocks of it. Storing a match twice changes
nothing.
"""

import os
import platform
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass, field, fields, replace
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import msgspec

from catch_arena.config import RULESET, ArenaConfig
from catch_arena.errors import DamagedStoreError, OtherTournamentError, StoreError
from catch_arena.text import one_line
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.match import PlayedMatch
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.secret import Secret

if TYPE_CHECKING:
    from typing_extensions import Self

STORE: Final = "tournament.sqlite"
_APPLICATION_ID: Final = 0x43417231  # SQLite's application_id: the kind of the file
_FORMAT: Final = 6
_PATIENCE_S: Final = 60.0
"""Longest time that another process may lock the file [s]."""
_TABLES: Final = """
CREATE TABLE fact (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE versions (id INTEGER PRIMARY KEY, value TEXT NOT NULL UNIQUE);
CREATE TABLE match (
    id TEXT PRIMARY KEY,
    block INTEGER NOT NULL,
    versions INTEGER NOT NULL REFERENCES versions (id),
    played TEXT NOT NULL
)
"""
"""Tables; `played` is a `PlayedMatch` as JSON."""
_INVALID: Final = (ValueError, TypeError, RecursionError)
"""Errors of reading a value that no command has written; msgspec's are ValueErrors."""
_BY_PARTY: Final = ("scores", "ranks", "verdicts", "contests_won", "contests_lost", "forfeits", "thinking")


@dataclass(frozen=True, slots=True)
class Tournament:
    """Tournament whose matches a store holds; only the same tournament can continue it.

    Table `fact` has these fields by name, as JSON.
    """

    config: ArenaConfig
    entrants: tuple[Entrant, ...]
    plan: Mapping[str, str | int | float]
    seed: str = field(repr=False)
    """Seed as `Secret.text`."""
    terms: Mapping[str, str | int | float | bool] = field(default_factory=dict)
    """Other terms of the tournament: `recorded`, `trusted`, `max_forfeits`, and the quotas of isolated agents."""
    ruleset: str = RULESET

    def __post_init__(self) -> None:
        Secret.parse(self.seed)

    @property
    def secret(self) -> Secret:
        """Secret that the plan is drawn from."""
        return Secret.parse(self.seed)


def terms_of(quotas: Quotas | None, max_forfeits: int, *, recorded: bool) -> dict[str, int | float]:
    """Return the `terms` of a tournament: `quotas` is None if all agents are trusted, `max_forfeits` 0 for no limit."""
    numbers = {} if quotas is None else quotas.numbers()
    return {"recorded": recorded, "trusted": quotas is None, "max_forfeits": max_forfeits} | numbers


class Store:
    """Store of one tournament's matches; `begin` and `read` open it for the time of a `with` statement.

    All methods raise StoreError if SQLite reports an error, or the file is damaged; `read` also if it is missing.
    """

    def __init__(self, path: Path, *, writable: bool) -> None:
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

        It raises StoreError if the folder's store has matches and is not to be resumed, or if another command plays in
        it; OtherTournamentError if the store is of another tournament.
        """
        path = folder / STORE
        if not path.exists():
            with suppress(OSError):  # SQLite reports the error below
                path.touch(0o600)  # the file has the seeds of future matches
        store = cls(path, writable=True)
        with closing(store._db), only_one_plays_in(folder):
            store._begin(tournament, resume=resume)
            yield store

    @classmethod
    @contextmanager
    def read(cls, folder: Path) -> Iterator["Store"]:
        """Open the store of a tournament that has begun, for reading."""
        path = folder / STORE
        if not path.is_file():
            raise StoreError(f"{folder}: holds no tournament (a file {STORE})")
        store = cls(path, writable=False)
        with closing(store._db):
            if not store._has_tables():
                raise StoreError(f"{folder}: holds a tournament that has not begun")
            yield store

    @classmethod
    def tournament_in(cls, folder: Path) -> Tournament | None:
        """Return the tournament in a folder; None if none has begun."""
        path = folder / STORE
        if not path.is_file():
            return None
        store = cls(path, writable=False)
        with closing(store._db):
            return store.tournament if store._has_tables() else None

    @property
    def tournament(self) -> Tournament:
        """Tournament whose matches the store holds."""
        values = {
            name: self._decode(f"table fact, row {name}", text)
            for name, text in self._rows("SELECT name, value FROM fact")
        }
        if (ruleset := values.get("ruleset", RULESET)) != RULESET:
            why = one_line(f"was played under ruleset {ruleset}, and this is {RULESET}")
            raise StoreError(f"{self.path}: {why}: continue, report or export it with that version")
        where = "table fact, row config"
        try:
            config = ArenaConfig.from_dict(values.get("config"))  # type: ignore[arg-type]  # integers stay integers
            where = "table fact"
            return msgspec.convert(values | {"config": config}, Tournament)
        except _INVALID as error:
            raise self._damaged(f"{where}: {error}") from None

    @property
    def ended(self) -> bool:
        """True if the plan has been played to its end; its secret must not be shown earlier."""
        return 0 < self._planned() <= self.count_played()

    def set_planned(self, matches: int) -> None:
        """Write the number of matches of the plan; the largest possible number if it depends on their results."""
        with self.transaction() as db:
            db.execute("INSERT OR REPLACE INTO fact VALUES ('planned', ?)", (_json(matches),))

    def end(self) -> None:
        """Mark the plan as played to its end: it has no more matches than the store."""
        self.set_planned(self.count_played())

    def add(self, block: Iterable[PlayedMatch]) -> None:
        """Write played matches, all or none; a match that was stored before is not changed."""
        with self.transaction():
            for one in block:
                self._add_match(one)

    def _add_match(self, one: PlayedMatch) -> None:
        """Write a match without its logs, which are files, and without the observations of forfeits."""
        forfeits = (part and msgspec.structs.replace(part, observation=None) for part in one.result.forfeits)
        kept = replace(one, result=replace(one.result, logs=(), forfeits=tuple(forfeits)))
        row = (one.match.id, one.match.block, self._versions, _json(kept))
        self._db.execute("INSERT OR IGNORE INTO match VALUES (?, ?, ?, ?)", row)

    def played(self) -> Iterator[PlayedMatch]:
        """Return the played matches in the order of the plan."""
        return (one for one, _ in self.records())

    def records(self) -> Iterator[tuple[PlayedMatch, dict[str, str]]]:
        """Yield the played matches, as `played` does, each with the package versions that played it."""
        tournament = self.tournament
        parties, entrants = len(Parties.of(tournament.config)), len(tournament.entrants)
        rows = self._rows("SELECT id, value FROM versions")
        known = {key: self._decode(f"table versions, row {key}", text, dict[str, str]) for key, text in rows}
        with self._store_errors():
            for name, by, text in self._db.execute("SELECT id, versions, played FROM match ORDER BY id"):
                where = f"table match, row {name}"
                played = self._decode(where, text, PlayedMatch)
                fault = _misfit(played, name, parties, entrants) or (by not in known and f"versions {by} are missing")
                if fault:
                    raise self._damaged(f"{where}: {fault}")
                yield played, known[by]

    def count_played(self) -> int:
        """Return the number of played matches."""
        ((count,),) = self._rows("SELECT count(*) FROM match")
        return int(count)

    def count_planned(self) -> int:
        """Return the number of planned matches; that of played ones if no number is written, as in a league."""
        return self._planned() or self.count_played()

    def _begin(self, tournament: Tournament, *, resume: bool) -> None:
        begun = self._has_tables()  # before any change: the file may not be ours
        with self._store_errors():
            self._db.execute("PRAGMA journal_mode = WAL")
            self._db.execute("PRAGMA synchronous = NORMAL")  # a power cut may lose the last matches, but never the file
            self._db.execute("PRAGMA foreign_keys = ON")
        with self.transaction() as db:
            if not begun:
                for statement in _TABLES.split(";"):
                    db.execute(statement)
                db.execute(f"PRAGMA application_id = {_APPLICATION_ID}")
                db.execute(f"PRAGMA user_version = {_FORMAT}")
            if not self.count_played():  # an earlier command ended before the end of the first block
                facts = [(one.name, _json(getattr(tournament, one.name))) for one in fields(tournament)]
                db.executemany("INSERT OR REPLACE INTO fact VALUES (?, ?)", facts)
            elif not resume:
                raise StoreError(
                    f"{self.path}: holds a tournament already, with {self.count_played()} of {self.count_planned()} "
                    "matches played: go on with --resume, or give another folder"
                )
            elif found := difference(self.tournament, tournament):
                raise OtherTournamentError(f"{self.path}: is of another tournament: {found}")
            text = _json(versions())
            db.execute("INSERT OR IGNORE INTO versions (value) VALUES (?)", (text,))
            (self._versions,) = db.execute("SELECT id FROM versions WHERE value = ?", (text,)).fetchone()

    def _has_tables(self) -> bool:
        """Return whether the file has tables; False if it is empty. Another format than this one is a StoreError."""
        query = "SELECT * FROM pragma_application_id, pragma_user_version, (SELECT count(*) FROM sqlite_schema)"
        ((application_id, form, tables),) = self._rows(query)
        if not tables:
            return False
        if application_id != _APPLICATION_ID:
            raise StoreError(f"{self.path}: is no store of a tournament")
        if form != _FORMAT:
            age = "an older" if form < _FORMAT else "a newer"
            raise StoreError(
                f"{self.path}: is of {age} version of Catch Arena (format {form}, and this one reads {_FORMAT}): "
                "continue, report or export it with that version"
            )
        ((found,),) = self._rows("PRAGMA quick_check(1)")
        if found != "ok":
            raise self._damaged(found)
        return True

    def _planned(self) -> int:
        """Return the number of planned matches; 0 if none is written."""
        rows = self._rows("SELECT value FROM fact WHERE name = 'planned'")
        return next((int(self._decode("table fact, row planned", text, int)) for (text,) in rows), 0)

    def _rows(self, query: str) -> list[tuple[Any, ...]]:
        with self._store_errors():
            return self._db.execute(query).fetchall()

    @contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """Open a transaction: all writes in it are kept, or none if it raises."""
        with self._store_errors(), self._db as db:
            db.execute("BEGIN IMMEDIATE")
            yield db

    @contextmanager
    def _store_errors(self) -> Iterator[None]:
        try:
            yield
        except UnicodeError:  # in a message of SQLite
            raise self._damaged("it holds what is no text") from None
        except sqlite3.Error as error:
            raise StoreError(f"{self.path}: cannot be used: {one_line(str(error))}") from None

    def _decode(self, where: str, text: str, kind: Any = Any) -> Any:
        """Return a stored value; `where` names its table and row."""
        try:
            return msgspec.json.decode(text, type=kind)
        except _INVALID as error:
            raise self._damaged(f"{where}: {error}") from None

    def _damaged(self, value: object) -> DamagedStoreError:
        """Return the error for a stored value that no command has written, named by its table and row."""
        return DamagedStoreError(f"{self.path}: is damaged: {one_line(str(value))}")


@contextmanager
def only_one_plays_in(folder: Path) -> Iterator[None]:
    """Hold a lock on a folder, or raise StoreError if another command holds it. Windows has no such lock.

    The kernel releases it when this process ends.
    """
    with ExitStack() as stack:
        with suppress(ImportError, OSError):  # no such locks, or a folder that cannot be read: writing to it raises
            import fcntl

            descriptor = os.open(folder, os.O_RDONLY)
            stack.callback(os.close, descriptor)
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise StoreError(f"{folder}: another command is playing in this folder") from None
        yield


def versions() -> dict[str, str]:
    """Return the versions in this process, by name: of the package, Python, NumPy and Numba."""
    return {
        "catch_arena": version("catch-arena"),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "numba": version("numba"),
    }


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


def _misfit(one: PlayedMatch, row: str, parties: int, entrants: int) -> str | None:
    """Return why a match cannot be in that row, with these numbers of parties and entrants; None if it can."""
    if one.match.id != row:
        return "id must be that of the row"
    for part, names in ((one.match, ("seating", "agent_seeds")), (one.result, _BY_PARTY)):
        for name in names:
            if len(getattr(part, name)) != parties:
                return f"{name} must be {parties}"
    if not all(0 <= index < entrants for index in one.match.seating):
        return f"seating must have indices of {entrants} entrants"
    return None


def _json(value: object) -> str:
    return msgspec.json.encode(value).decode()
