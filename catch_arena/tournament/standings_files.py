"""Files with the standings of a tournament: standings.csv and standings.json, and with prey prey_standings.csv.

They do not depend on time, machine or the number of processes: the same plan writes the same bytes.
"""

import csv
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from catch_arena.config import RULESET
from catch_arena.files import write_whole
from catch_arena.policy import Side
from catch_arena.text import spreadsheet_cell
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.statistics.intervals import Estimate, rounded
from catch_arena.tournament.statistics.standings import Standing
from catch_arena.tournament.store import Tournament

SUMMARY: Final = "standings.json"
TABLES: Final[Mapping[Side, str]] = {"hunter": "standings.csv", "prey": "prey_standings.csv"}


def write_standings(
    folder: Path, tournament: Tournament, matches: int, tables: Mapping[Side, Sequence[Standing]]
) -> None:
    """Write the standings files of a tournament that has ended; they contain its seed.

    Each file is written whole or not at all. Files of these names are replaced, others stay.

    Raises:
        OutputError: if a file cannot be written.
    """
    for side, table in tables.items():
        write_whole(folder / TABLES[side], table_text(table).encode())
    write_whole(folder / SUMMARY, summary_text(tournament, matches, tables).encode())


def table_text(table: Sequence[Standing]) -> str:
    """Return the standings as CSV; an unknown interval is empty."""
    text = io.StringIO()
    rows = [_flat(standing) for standing in table]
    writer = csv.DictWriter(text, fieldnames=list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(row | {"agent": spreadsheet_cell(row["agent"])} for row in rows)
    return text.getvalue()


def summary_text(tournament: Tournament, matches: int, tables: Mapping[Side, Sequence[Standing]]) -> str:
    """Return as JSON the standings, and the seed, plan and settings for playing the tournament again."""
    names: dict[Side, str] = {"hunter": "standings", "prey": "prey_standings"}
    summary = {
        "ruleset": RULESET,
        "plan": dict(tournament.plan),
        "seed": tournament.secret.digits,
        "matches": matches,
        "config_digest": tournament.config.digest,
        "config": tournament.config.to_dict(),
        "entrants": [_entrant_columns(entrant, with_prey="prey" in tables) for entrant in tournament.entrants],
        **{names[side]: [_whole(standing) for standing in table] for side, table in tables.items()},
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
    row: dict[str, Any] = {
        "place": standing.place,
        "agent": standing.name,
        "group": standing.group,
        "matches": standing.matches,
    }
    for name in ("rating", "score", "iqm", "win_share"):
        estimate: Estimate = getattr(standing, name)
        row |= {name: estimate.mean, f"{name}_low": estimate.low, f"{name}_high": estimate.high}
    row |= {
        "mean_rank": standing.mean_rank,
        "contests_lost": standing.contests_lost,
        "contest_wins": standing.contest_win_share,
        "lost_to_mates": standing.lost_to_mates,
        "refused": standing.refused,
        "forfeits": sum(standing.forfeits.values()),
    }
    return {name: rounded(value) if isinstance(value, float) else value for name, value in row.items()}
