"""What a tournament leaves in its folder: results.jsonl, standings.csv and standings.json.

Nothing in them depends on time, machine or the number of processes: the same plan writes the same bytes.
"""

import csv
import io
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from catch_arena.config import RULESET, ArenaConfig
from catch_arena.errors import OutputError
from catch_arena.replay import write_whole
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.runner import Played
from catch_arena.tournament.standings import Estimate, Standing

RESULTS, TABLE, SUMMARY = "results.jsonl", "standings.csv", "standings.json"
_DIGITS: Final = 6


def prepare_folder(folder: Path) -> Path:
    """The folder, made where it is missing and proven writable: better to fail before the play than after it.

    Raises: OutputError.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".catch-arena-probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written to: {error.strerror or error}") from None
    return folder


def write_results(
    folder: Path,
    *,
    config: ArenaConfig,
    seed: int,
    entrants: Sequence[Entrant],
    played: Sequence[Played],
    table: Sequence[Standing],
) -> None:
    """Write the three files, each whole or not at all; files of these names are replaced, others left alone.

    Raises: OutputError.
    """
    write_whole(folder / RESULTS, results_text(entrants, played).encode())
    write_whole(folder / TABLE, table_text(table).encode())
    write_whole(folder / SUMMARY, summary_text(config, seed, entrants, len(played), table).encode())


def results_text(entrants: Sequence[Entrant], played: Sequence[Played]) -> str:
    """One line of JSON a match, by match id; lists are by seat."""
    lines = [
        _json(
            {
                "match": one.match.id,
                "block": one.match.block,
                "seed": one.match.seed,
                "agents": [entrants[place].name for place in one.match.seating],
                "scores": one.result.scores,
                "ranks": one.result.ranks,
                "verdicts": one.result.verdicts,
                "steps": one.result.steps,
                "digest": one.result.digest,
            }
        )
        for one in sorted(played, key=lambda one: one.match.id)
    ]
    return "".join(f"{line}\n" for line in lines)


def table_text(table: Sequence[Standing]) -> str:
    """The standings as CSV; an interval that is not known is empty."""
    text = io.StringIO()
    rows = [_flat(standing) for standing in table]
    writer = csv.DictWriter(text, fieldnames=list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def summary_text(
    config: ArenaConfig, seed: int, entrants: Sequence[Entrant], matches: int, table: Sequence[Standing]
) -> str:
    """The standings with all that is needed to play the tournament again."""
    summary = {
        "ruleset": RULESET,
        "seed": seed,
        "matches": matches,
        "config_digest": config.digest,
        "config": config.to_dict(),
        "entrants": [
            {"name": entrant.name, "control": entrant.control, "digest": entrant.digest} for entrant in entrants
        ],
        "standings": [_flat(standing) for standing in table],
    }
    return json.dumps(summary, indent=2) + "\n"


def _flat(standing: Standing) -> dict[str, Any]:
    row: dict[str, Any] = {"place": standing.place, "agent": standing.name, "matches": standing.matches}
    for name in ("score", "win_share"):
        estimate: Estimate = getattr(standing, name)
        row |= {name: estimate.mean, f"{name}_low": estimate.low, f"{name}_high": estimate.high}
    row |= {
        "mean_rank": standing.mean_rank,
        "contests_lost": standing.contests_lost,
        "refused": standing.refused,
    }
    return {key: _plain(value) for key, value in row.items()}


def _plain(value: Any) -> Any:
    """Numbers as they are written: rounded, so that the last bit of a sum does not show; None where there is none."""
    if not isinstance(value, float):
        return value
    return None if math.isnan(value) else round(value, _DIGITS)


def _json(value: object) -> str:
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False)
