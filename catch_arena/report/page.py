"""The page: a tournament's data, put into templates. One file, which loads nothing.

What strangers have written into it is text: templates escape it, and the page's policy lets no script run but its own.
"""

import base64
import hashlib
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final

import jinja2

from catch_arena.config import RULESET
from catch_arena.files import write_whole
from catch_arena.player import element_script, packed_text, page_file, script_json
from catch_arena.report import charts
from catch_arena.report.data import ReportData
from catch_arena.report.selection import SelectedMatch, select_matches
from catch_arena.text import without_folders
from catch_arena.tournament.entrants import SHIPPED_PREY

REPORT: Final = "report.html"
_PAGE: Final = "catch_arena.report"
BUDGET: Final = 1_000_000
"""Bytes for the replays of matches, unless told otherwise."""
MOST_LISTED: Final = 20_000
"""Matches in the page's list."""
_MOST_WAYS: Final = 100
"""To forfeit; more are counted."""


def write_report(
    folder: Path, *, budget: int = BUDGET, matches: Sequence[str] = (), output: Path | None = None
) -> Path:
    """Write the report of a tournament, whole or not at all.

    Args:
        folder: the tournament's folder.
        budget: how many bytes of replays it may have.
        matches: the ids of some that it has in any case.
        output: the file; if None, it is in the folder.

    Raises:
        StoreError: where there is nothing to report.
        ReplayError: for a match that was not recorded.
        OutputError: where it cannot be written.
    """
    data = ReportData.of(folder)
    path = output or folder / REPORT
    write_whole(path, page(data, select_matches(data, budget, matches)).encode())
    return path


def page(data: ReportData, selected: dict[str, SelectedMatch], *, watched: bool = False) -> str:
    """The report.

    Args:
        data: what the report shows.
        selected: the matches that it plays.
        watched: whether it is served: it asks for news, and for the replays that it shows.
    """
    forfeits = _forfeits(data)
    return _template().render(
        data=data,
        table=data.standings,
        headline=charts.headline_of_sides({side.side: side.standings for side in data.sides}, ended=data.ended),
        sides=[
            {
                "prey": side.side == "prey",
                "table": side.standings,
                "ratings": charts.rating_axis(side.standings),
                "lanes": charts.lanes(side.standings),
                "distributions": charts.distributions(side),
                "encounters": charts.encounters(side),
            }
            for side in data.sides
        ],
        teams=len(data.parties) < len(data.parties.by_seat),
        seat_tables=charts.seat_tables(data),
        refusals=charts.refusals(data),
        move_times=charts.move_times(data),
        forfeits=forfeits[:_MOST_WAYS],
        forfeit_count=sum(way["times"] for way in forfeits),
        forfeit_ways=len(forfeits),
        settings=_settings(data.tournament.config.to_dict()),
        ruleset=RULESET,
        shipped_prey=SHIPPED_PREY,
        recorded=len(data.recorded),
        listed=min(len(data.played), MOST_LISTED),
        selected=selected,
        selected_json=script_json({match: [one.bundle, one.why] for match, one in selected.items()}),
        matches=packed_text(script_json(_matches(data)).encode()),
        watched=watched,
        policy=content_policy(watched=watched),
        element=element_script(),
        style=page_file(_PAGE, "report.css"),
        script=page_file(_PAGE, "report.js"),
    )


@cache
def content_policy(*, watched: bool) -> str:
    """The Content-Security-Policy: two scripts run, by their digests; nothing is loaded, but news where it is watched.

    Styles may stand anywhere, as those of each line's chart do.
    """
    own = element_script().removeprefix("<script>").removesuffix("</script>"), page_file(_PAGE, "report.js")
    digests = (base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in own)
    parts = {
        "default-src": "'none'",
        "script-src": " ".join(f"'sha256-{digest}'" for digest in digests),
        "style-src": "'unsafe-inline'",
        "img-src": "data:",
        "connect-src": "'self'" if watched else "'none'",
        "base-uri": "'none'",
        "form-action": "'none'",
    }
    return "; ".join(f"{name} {value}" for name, value in parts.items())


@cache
def _template() -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader(_PAGE, "page"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"percent": charts.percent, "interval": charts.interval, "number": charts.number}
    return environment.get_template("report.html")


def _matches(data: ReportData) -> dict[str, Any]:
    """The list of matches, in columns; what is by party stands match after match."""
    played = data.played[:MOST_LISTED]
    return {
        "names": [side.names for side in data.sides],
        "seats": len(data.parties),
        "hunting": data.parties.hunting,
        "ids": [one.match.id for one in played],
        "recorded": [int(one.match.id in data.recorded) for one in played],
        "seating": [entrant for one in played for entrant in one.match.seating],
        "scores": [score for one in played for score in one.result.scores],
        "ranks": [rank for one in played for rank in one.result.ranks],
    }


def _forfeits(data: ReportData) -> list[dict[str, Any]]:
    """How agents failed, the most frequent way first; each with how often, and the first time."""
    found: dict[tuple[str, str, str], dict[str, Any]] = {}
    for one in data.played:
        for party, code in enumerate(one.result.forfeits):
            if code is None:
                continue
            detail = one.result.details[party] if one.result.details else None
            entrant = data.tournament.entrants[one.match.seating[party]]
            name, reason = entrant.name, detail.reason if detail else ""
            reason = without_folders(reason.replace(entrant.spec, entrant.source))
            where = f"match {one.match.id}, {data.parties.called(party)}"
            first = {"where": where, "step": detail.step if detail else None, "times": 0}
            way = found.setdefault((name, code, reason), {"name": name, "code": code, "reason": reason} | first)
            way["times"] += 1
    return sorted(found.values(), key=lambda way: -way["times"])


def _settings(config: dict[str, Any]) -> dict[str, Any]:
    """The settings in one table; those of a group follow its name and a dot."""
    flat: dict[str, Any] = {}
    for name, value in config.items():
        if isinstance(value, dict):
            flat |= {f"{name}.{part}": inner for part, inner in value.items()}
        else:
            flat[name] = value
    return flat
