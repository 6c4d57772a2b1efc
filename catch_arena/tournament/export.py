"""Files of a tournament for people and other tools: the standings, and the export of its matches.

Standings are standings.csv, standings.json, and with prey prey_standings.csv. An export is JSON with a line for each
match, or a table with a row for each party, sorted by match. Standings, and exports without timing, have the same bytes
for the same plan, whichever executor played it.
"""

import csv
import io
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import IO, Any, Final, TextIO

from msgspec.structs import asdict

from catch_arena.config import RULESET, require_choice
from catch_arena.errors import ConfigError, install_hint
from catch_arena.files import whole_file, write_whole
from catch_arena.policy import Side
from catch_arena.text import spreadsheet_cell
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.statistics.intervals import Estimate, rounded
from catch_arena.tournament.statistics.standings import Standing
from catch_arena.tournament.store import Store, Tournament
from catch_arena.verdicts import Verdict

SUMMARY: Final = "standings.json"
TABLES: Final[Mapping[Side, str]] = {"hunter": "standings.csv", "prey": "prey_standings.csv"}
_RESULTS: Final = ("scores", "ranks", "verdicts", "contests_won", "contests_lost", "steps", "digest")
_BY_MATCH: Final[dict[str, type]] = {
    "match": str,
    "block": int,
    "seed": int,
    "steps": int,
    "digest": str,
    "replay_digest": str,
    "ruleset": str,
    "config_digest": str,
    "tournament_seed": str,
}
_BY_PARTY: Final[dict[str, type]] = {
    "side": str,
    "agent": str,
    "agent_digest": str,
    "agent_seed": int,
    "score": int,
    "rank": int,
    "contests_won": int,
    "contests_lost": int,
    "lost_to_mates": int,
    "forfeit": str,
}
_VERSIONS: Final[dict[str, type]] = dict.fromkeys(("catch_arena", "python", "numpy", "numba"), str)
_TIMING: Final[dict[str, type]] = {"moves": int, "total_s": float, "longest_s": float}
_STANDING: Final = (
    *("place", "agent", "group", "matches", "rating", "score", "iqm", "win_share"),
    *("mean_rank", "contests_lost", "contest_wins", "lost_to_mates", "refused", "forfeits"),
)
_ROWS: Final = 20_000
"""Number of rows of a Parquet file that are held in memory at a time."""


def export(store: Store, path: Path, *, timing: bool = True) -> None:
    """Write all played matches to a .jsonl, .csv or .parquet file.

    `timing` adds times, which no other run repeats. Raise ConfigError for another ending, or without pyarrow.
    """
    writers = {".jsonl": _write_jsonl, ".csv": _write_csv, ".parquet": _write_parquet}
    require_choice("the ending of the file", path.suffix.lower(), list(writers))
    with whole_file(path) as file:
        writers[path.suffix.lower()](store, file, timing)


def records(store: Store, *, timing: bool = True) -> Iterator[dict[str, Any]]:
    """Yield a record of each played match; lists are by party (parties.py), which is by seat without teams."""
    tournament = store.tournament
    parties = Parties.of(tournament.config)
    sides = [parties.side_of(party) for party in range(len(parties))]
    with_teams = len(parties) < len(parties.by_seat)
    entrants, config_digest = tournament.entrants, tournament.config.digest
    tournament_seed = tournament.secret.digits if store.ended else None
    for played, versions in store.records():
        match, result = played.match, played.result
        players = [entrants[index].on(side) for index, side in zip(match.seating, sides, strict=True)]
        teams = {"seats": parties.seats, "lost_to_mates": result.lost_to_mates, "catches": result.catches}
        record = {
            "match": match.id,
            "block": match.block,
            "seed": match.seed,
            "sides": sides,
            "agents": [entrant.name for entrant in players],
            "agent_digests": [entrant.digest for entrant in players],
            "agent_seeds": match.agent_seeds,
            **{name: getattr(result, name) for name in _RESULTS},
            "forfeits": result.forfeit_codes,
            **(teams if with_teams else {}),
            "replay_digest": played.replay,
            "ruleset": RULESET,
            "config_digest": config_digest,
            "tournament_seed": tournament_seed,
            "versions": versions,
        }
        if timing:
            record["thinking"] = [asdict(seat) for seat in result.thinking]
            record["details"] = [one and {"step": one.step, "reason": one.reason} for one in result.forfeits]
        yield record


def rows(store: Store, *, timing: bool = True) -> Iterator[dict[str, Any]]:
    """Yield the rows of a table with `columns`, one for each party of each played match; missing verdicts are 0."""
    first_seats = [seats[0] for seats in Parties.of(store.tournament.config).seats]
    for record in records(store, timing=timing):
        known = {"lost_to_mates": [0] * len(first_seats)} | record
        for party, seat in enumerate(first_seats):
            row = {name: record[name] for name in _BY_MATCH} | record["versions"] | {"seat": seat}
            row |= {name: known[name if name in known else f"{name}s"][party] for name in _BY_PARTY}
            row |= {verdict.name.lower(): record["verdicts"][party].get(verdict.name, 0) for verdict in Verdict}
            yield row | (record["thinking"][party] if timing else {})


def columns(*, timing: bool = True) -> dict[str, type]:
    """Return the columns of the table in order, by name, with their types."""
    verdicts = {verdict.name.lower(): int for verdict in Verdict}
    return _BY_MATCH | {"seat": int} | _BY_PARTY | verdicts | _VERSIONS | (_TIMING if timing else {})


def _write_jsonl(store: Store, file: IO[bytes], timing: bool) -> None:
    for record in records(store, timing=timing):
        file.write(json.dumps(record, separators=(",", ":"), ensure_ascii=False).encode() + b"\n")


def _write_csv(store: Store, file: IO[bytes], timing: bool) -> None:
    text = io.TextIOWrapper(file, "utf-8", newline="")
    _write_rows(text, columns(timing=timing), rows(store, timing=timing))
    text.detach()  # flushed, and left open


def _write_rows(text: TextIO, names: Iterable[str], table: Iterable[dict[str, Any]]) -> None:
    writer = csv.DictWriter(text, list(names), lineterminator="\n")
    writer.writeheader()
    writer.writerows(row | {"agent": spreadsheet_cell(row["agent"])} for row in table)


def _write_parquet(store: Store, file: IO[bytes], timing: bool) -> None:
    try:
        import pyarrow as pa
        from pyarrow.parquet import ParquetWriter
    except ImportError:
        raise ConfigError(f"format parquet needs PyArrow: {install_hint('parquet')}") from None
    kinds = {str: pa.string(), int: pa.int64(), float: pa.float64()}
    schema = pa.schema([(name, kinds[kind]) for name, kind in columns(timing=timing).items()])
    table = rows(store, timing=timing)
    with ParquetWriter(file, schema) as writer:
        while part := list(islice(table, _ROWS)):
            writer.write_table(pa.Table.from_pylist(part, schema))


def write_standings(
    folder: Path, tournament: Tournament, matches: int, tables: Mapping[Side, Sequence[Standing]]
) -> None:
    """Write the standings files of a tournament that has ended; they contain its seed, and replace older ones."""
    for side, table in tables.items():
        write_whole(folder / TABLES[side], table_text(table).encode())
    write_whole(folder / SUMMARY, summary_text(tournament, matches, tables).encode())


def table_text(table: Sequence[Standing]) -> str:
    """Return the standings as CSV; an unknown interval is empty."""
    text = io.StringIO()
    rows = [_flat(standing) for standing in table]
    _write_rows(text, rows[0], rows)
    return text.getvalue()


def summary_text(tournament: Tournament, matches: int, tables: Mapping[Side, Sequence[Standing]]) -> str:
    """Return as JSON the standings, and the seed, plan and settings for playing the tournament again."""
    summary = {
        "ruleset": RULESET,
        "plan": dict(tournament.plan),
        "seed": tournament.secret.digits,
        "matches": matches,
        "config_digest": tournament.config.digest,
        "config": tournament.config.to_dict(),
        "entrants": [_entrant_columns(entrant, with_prey="prey" in tables) for entrant in tournament.entrants],
        **{Path(TABLES[side]).stem: [_whole(standing) for standing in table] for side, table in tables.items()},
    }
    return json.dumps(summary, indent=2) + "\n"


def _entrant_columns(entrant: Entrant, *, with_prey: bool) -> dict[str, str]:
    prey = {"prey": entrant.on("prey").name, "prey_digest": entrant.prey_digest} if with_prey else {}
    return {"name": entrant.name, "control": entrant.control, "digest": entrant.digest} | prey


def _whole(standing: Standing) -> dict[str, Any]:
    refusals = {name: rounded(often) for name, often in standing.refusals.items()}
    return _flat(standing) | {"refusals": refusals, "forfeits": standing.forfeits}


def _flat(standing: Standing) -> dict[str, Any]:
    """Return a line of the table: an interval has two columns, and refusals and forfeits are sums."""
    forfeits = sum(standing.forfeits.values())
    renamed = {"agent": standing.name, "contest_wins": standing.contest_win_share, "forfeits": forfeits}
    row: dict[str, Any] = {}
    for name in _STANDING:
        value = renamed[name] if name in renamed else getattr(standing, name)
        if isinstance(value, Estimate):
            row |= {name: rounded(value.mean), f"{name}_low": rounded(value.low), f"{name}_high": rounded(value.high)}
        else:
            row[name] = rounded(value) if isinstance(value, float) else value
    return row
