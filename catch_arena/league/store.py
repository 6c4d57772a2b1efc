"""Store of a league: that of a tournament, with versions of the entries and their ratings over time."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass
from datetime import datetime, timedelta
from typing import Final

import msgspec

from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.statistics.intervals import Estimate
from catch_arena.tournament.store import Store, Tournament

_TABLES: Final = """
CREATE TABLE IF NOT EXISTS league_version (
    entry TEXT, number INTEGER, digest TEXT, entered TEXT, entrant INTEGER, fault TEXT, log TEXT,
    PRIMARY KEY (entry, number)
) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS league_rating (
    entrant INTEGER, time TEXT, place INTEGER, rating REAL, low REAL, high REAL,
    PRIMARY KEY (entrant, time)
) WITHOUT ROWID
"""
_REMOVE_OLD: Final = """
DELETE FROM league_rating WHERE
    time NOT IN (SELECT DISTINCT time FROM league_rating ORDER BY time DESC LIMIT ?)
    AND EXISTS (
        SELECT 1 FROM league_rating AS later WHERE later.entrant = league_rating.entrant
        AND later.time > league_rating.time AND substr(later.time, 1, 10) = substr(league_rating.time, 1, 10)
    )
"""
_RUNS_KEPT: Final = 100
"""Number of the newest runs whose ratings are kept; of each day before, the last ratings are kept."""


@dataclass(frozen=True, slots=True)
class Version:
    """Version of an entry."""

    entry: str
    """Key of the entry."""
    number: int
    """Number of the version, from 1."""
    digest: str
    entered: str
    """Time at which the league first found it: ISO 8601, UTC."""
    entrant: int | None
    """Index of its entrant in the store; None if it did not pass the check."""
    fault: str = ""
    """Reason for which it did not pass."""
    log: str = ""
    """End of what it printed in the check."""


@dataclass(frozen=True, slots=True)
class RatingThen:
    """Rating of an entrant after a run [points]; `low` and `high` are the ends of its interval."""

    entrant: int
    time: str
    """Time of the run: ISO 8601, UTC."""
    place: int | None
    """Place among the persons; None for other entrants, and for an entrant whose interval is unknown."""
    rating: float
    low: float | None
    high: float | None

    @property
    def estimate(self) -> Estimate:
        """Rating with its interval."""
        low, high = (math.nan if end is None else end for end in (self.low, self.high))
        return Estimate(self.rating, low, high)


class LeagueStore(Store):
    """Store of a league, whose entrants and matches change as it goes on."""

    def _begin(self, tournament: Tournament, *, resume: bool) -> None:
        super()._begin(tournament, resume=resume)
        with self.transaction() as db:
            for statement in _TABLES.split(";"):
                db.execute(statement)

    def versions(self) -> list[Version]:
        """Return all versions, by entry and number."""
        return [Version(*row) for row in self._rows("SELECT * FROM league_version ORDER BY entry, number")]

    def ratings(self) -> list[RatingThen]:
        """Return the ratings of all entrants after each run that is kept, in the order of time."""
        return [RatingThen(*row) for row in self._rows("SELECT * FROM league_rating ORDER BY time, entrant")]

    def add_version(self, version: Version, entrants: Sequence[Entrant]) -> None:
        """Write a new version, and all entrants with its own at the end: both or none."""
        with self.transaction() as db:
            db.execute("INSERT OR REPLACE INTO fact VALUES ('entrants', ?)", (msgspec.json.encode(entrants).decode(),))
            db.execute("INSERT INTO league_version VALUES (?, ?, ?, ?, ?, ?, ?)", astuple(version))

    def add_ratings(self, ratings: Iterable[RatingThen]) -> None:
        """Write the ratings after a run, and remove those of old runs except the last ones of each day."""
        with self.transaction() as db:
            db.executemany("INSERT INTO league_rating VALUES (?, ?, ?, ?, ?, ?)", map(astuple, ratings))
            db.execute(_REMOVE_OLD, (_RUNS_KEPT,))

    def time_after(self, now: datetime) -> str:
        """Return the time of a run as text; a second after the last run's if the clock was set back."""
        ((last,),) = self._rows("SELECT max(time) FROM league_rating")
        if last is not None:
            now = max(now, datetime.fromisoformat(last) + timedelta(seconds=1))
        return now.isoformat(timespec="seconds")

    def next_block(self) -> tuple[int, int]:
        """Return the number of rounds so far, and the number of the next block, from 0."""
        last = self._rows("SELECT id, block FROM match ORDER BY id DESC LIMIT 1")
        return next(((int(match[1:].partition("-")[0]), block + 1) for match, block in last), (0, 0))

    def remove_old(self, most: int) -> None:
        """Remove the oldest blocks, so that at most `most` played matches are left."""
        with self.transaction() as db:
            newest_old = "SELECT block FROM match ORDER BY id DESC LIMIT 1 OFFSET ?"
            db.execute(f"DELETE FROM match WHERE block <= ({newest_old})", (most,))  # noqa: S608 - ours
