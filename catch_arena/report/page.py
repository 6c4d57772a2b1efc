"""The page: findings, put into templates. One file, which loads nothing."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final

import jinja2

from catch_arena.config import RULESET
from catch_arena.player import element_script, packed_text, page_file, script_json
from catch_arena.replay import write_whole
from catch_arena.report import charts
from catch_arena.report.charts import Axis
from catch_arena.report.chosen import Chosen, chosen
from catch_arena.report.findings import Findings

REPORT: Final = "report.html"
BUDGET: Final = 1_000_000
"""Bytes for the films of matches, unless told otherwise."""
MOST_LISTED: Final = 20_000
"""Matches in the page's list."""
_MOST_WAYS: Final = 100
"""To forfeit; more are counted."""


def write_report(folder: Path, *, budget: int = BUDGET, matches: Sequence[str] = ()) -> Path:
    """Write the report into a tournament's folder, whole or not at all.

    Args: `budget`, how many bytes of films it may have; `matches`, the ids of some that it has in any case.
    Raises: StoreError where there is nothing to report; ReplayError for a match that was not recorded; OutputError.
    """
    findings = Findings.of(folder)
    path = folder / REPORT
    write_whole(path, page(findings, chosen(findings, budget, matches)).encode())
    return path


def page(findings: Findings, films: dict[str, Chosen], *, watched: bool = False) -> str:
    """The report. Args: `watched`, whether it is served: it asks for news, and for the films that it shows."""
    audit = findings.audit
    seats = charts.seats(findings) if audit is None else audit.seats
    forfeits = _forfeits(findings)
    return _template().render(
        findings=findings,
        table=findings.standings,
        headline=charts.headline(findings.standings, ended=len(findings.played) >= findings.planned),
        ratings=charts.rating_axis(findings.standings),
        lanes=charts.lanes(findings.standings),
        distributions=charts.distributions(findings),
        encounters=charts.encounters(findings),
        audit=audit,
        seats=seats,
        seat_axis=Axis.over([0.0, *_ends(seat.wins for seat in seats)]),
        refusals=charts.refusals(findings),
        thinking=charts.thinking(findings),
        forfeits=forfeits[:_MOST_WAYS],
        forfeit_count=sum(way["times"] for way in forfeits),
        forfeit_ways=len(forfeits),
        settings=_settings(findings.tournament.config.to_dict()),
        ruleset=RULESET,
        recorded=len(findings.recorded),
        listed=min(len(findings.played), MOST_LISTED),
        films=films,
        films_json=script_json({match: [film.film, film.why] for match, film in films.items()}),
        matches=packed_text(script_json(_matches(findings)).encode()),
        watched=watched,
        element=element_script(),
        style=page_file("catch_arena.report", "report.css"),
        script=page_file("catch_arena.report", "report.js"),
    )


@cache
def _template() -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("catch_arena.report", "page"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"percent": charts.percent, "interval": charts.interval, "number": charts.number}
    return environment.get_template("report.html")


def _ends(estimates: Any) -> list[float]:
    return [end for one in estimates for end in (one.low, one.mean, one.high)]


def _matches(findings: Findings) -> dict[str, Any]:
    """The list of matches, in columns; what is by seat stands match after match."""
    played = findings.played[:MOST_LISTED]
    return {
        "names": findings.names,
        "seats": findings.tournament.config.hunters,
        "ids": [one.match.id for one in played],
        "recorded": [int(one.match.id in findings.recorded) for one in played],
        "seating": [place for one in played for place in one.match.seating],
        "scores": [score for one in played for score in one.result.scores],
        "ranks": [rank for one in played for rank in one.result.ranks],
    }


def _forfeits(findings: Findings) -> list[dict[str, Any]]:
    """How agents failed, the most frequent way first; each with how often, and the first time."""
    found: dict[tuple[str, str, str], dict[str, Any]] = {}
    for one in findings.played:
        for seat, code in enumerate(one.result.forfeits):
            if code is None:
                continue
            detail = one.result.details[seat] if one.result.details else None
            name, reason = findings.names[one.match.seating[seat]], detail.reason if detail else ""
            first = {"match": one.match.id, "seat": seat, "step": detail.step if detail else None, "times": 0}
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
