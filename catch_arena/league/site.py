"""Static pages of a league: the table over time, and a page for each person, which shows no log of others."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import Any, Final

import jinja2

from catch_arena.classroom.moments import best_moment, worst_moment
from catch_arena.classroom.submissions import SITE
from catch_arena.config import RULESET
from catch_arena.errors import ReplayError
from catch_arena.files import prepare_folder, write_whole
from catch_arena.league.entries import Entry
from catch_arena.league.kept_matches import Part, best_and_worst
from catch_arena.league.store import RatingThen, Version
from catch_arena.league.update import League
from catch_arena.player.bundle import css
from catch_arena.player.moments import Moment, moment_scripts
from catch_arena.player.page_template import page_policy, page_style, page_template
from catch_arena.render.match_info import agent_color
from catch_arena.replay import Replay
from catch_arena.report.charts import Axis
from catch_arena.text import last_lines, without_folders, without_source
from catch_arena.tournament.execution.runner import LOGS, REPLAYS, log_file

_PAGE: Final = "catch_arena.league"
_CURVES: Final = 8
"""Largest number of curves in the chart of the table."""
_MATCHES: Final = 20
"""Number of the newest matches in the list of a person's page."""
_LOG_LINES: Final = 80
"""Number of lines of a log, from its end; lines of source are left out of them."""


@dataclass(frozen=True, slots=True)
class Line:
    """Line of an entry in the table."""

    entry: Entry
    entrant: int | None
    """Index of its entrant in the store; None if no version has passed the check."""
    page: str
    """Name of its page; empty for an entry without one."""
    color: str
    now: RatingThen | None
    """Rating after the last run; None before it has played."""
    change: float | None
    """Change of the rating since the last day on which the league ran before; None if it is unknown [points]."""
    status: str
    """Empty, or why its rating is not precise yet."""
    parts: Sequence[Part]
    """Matches that it played, in the order of the plan."""
    wins: float | None
    """Share of the matches that it won, in [0, 1]."""
    version: int
    """Number of the version that plays; 0 for none."""
    versions: Sequence[Version]


def write_site(league: League) -> Path:
    """Write the pages of a league, each whole or not at all, and return the first one; other files stay."""
    folder = prepare_folder(league.folder / SITE)
    lines = _lines(league)
    persons = [line for line in lines if line.entry.kind == "person"]
    common = {"league": league.folder.absolute().name, "scenario": league.rules.scenario, "ruleset": RULESET}
    written = {"index.html"}
    for line in persons:
        written.add(line.page)
        write_whole(folder / line.page, _person_page(league, line, lines, common).encode())
    table = _template("table.html").render(
        common,
        lines=lines,
        persons=persons,
        axis=_axis([line.now for line in lines if line.now is not None]),
        chart=_chart(league.ratings, [line for line in persons if line.now][:_CURVES]),
        updated=league.ratings[-1].time[:16].replace("T", " ") if league.ratings else "",
        precision=league.rules.precision,
        policy=page_policy(),
        style=page_style(_PAGE, "league.css"),
    )
    write_whole(folder / "index.html", table.encode())
    old = {f"person_{number}.html" for number in league.numbers.values()} - written
    with suppress(OSError):  # the page of an entry that is gone; what cannot be removed stays
        for name in old:
            (folder / name).unlink(missing_ok=True)
    return folder / "index.html"


def _lines(league: League) -> list[Line]:
    """Return the line of each present entry: those with a rating first, the best first."""
    last = league.ratings[-1].time if league.ratings else ""
    ratings = {one.entrant: one for one in league.ratings if one.time == last}
    days = sorted({one.time[:10] for one in league.ratings})
    earlier = {one.entrant: one.rating for one in league.ratings if len(days) > 1 and one.time[:10] == days[-2]}
    lines = []
    for entry in league.entries:
        if entry.key not in league.versions:  # it could not be checked yet
            continue
        index, versions = league.current.get(entry.key), league.versions[entry.key]
        before = [earlier[one.entrant] for one in versions if one.entrant in earlier]
        now = None if index is None else ratings.get(index)
        parts = [] if index is None else league.parts.get(index, ())
        side = league.parties.on("hunter")
        won = [part.one.result.win_share(part.party, side) for part in parts if part.party < side.stop]
        lines.append(
            Line(
                entry=entry,
                entrant=index,
                page=f"person_{league.numbers[entry.key]}.html" if entry.kind == "person" else "",
                color="" if index is None else css(agent_color(league.rules.config, index)),
                now=now,
                change=now.rating - before[-1] if now is not None and before else None,
                status=_status(league, index),
                parts=parts,
                wins=sum(won) / len(won) if won else None,
                version=0 if index is None else next(one.number for one in versions if one.entrant == index),
                versions=versions,
            )
        )
    return sorted(lines, key=lambda line: (line.now is None, 0.0 if line.now is None else -line.now.rating))


def _status(league: League, entrant: int | None) -> str:
    if entrant is None:
        return "did not pass the check"
    if entrant in league.streaks.excluded:
        return "stopped: too many forfeits in a row"
    if league.is_waiting(entrant):
        return "waits for further matches"
    return "" if league.is_placed(entrant) else "rating is not precise"


def _person_page(league: League, line: Line, lines: Sequence[Line], common: Mapping[str, Any]) -> str:
    """Return the page of a person."""
    moments = _moments(league, line.parts)
    last_ratings: dict[int | None, RatingThen] = {one.entrant: one for one in league.ratings}
    failed = [one for one in line.versions if one.entrant is None and one.digest == line.entry.digest]
    return _template("person.html").render(
        common,
        line=line,
        persons=sum(other.entry.kind == "person" and other.now is not None for other in lines),
        failed=failed[0] if failed else None,
        versions=[(one, last_ratings.get(one.entrant)) for one in reversed(line.versions)],
        chart=_chart(league.ratings, [line]),
        meetings=_meetings(line.parts, league, {one.entrant: one for one in lines}),
        matches=line.parts[: -_MATCHES - 1 : -1],
        forfeits=[part for part in reversed(line.parts) if part.forfeit][:_MATCHES],
        entrants=league.entrants,
        parties=league.parties,
        moments=moments,
        log="" if line.entrant is None else _log(league, line.entrant),
        style=page_style(_PAGE, "league.css"),
        **moment_scripts(plays=bool(moments)),
    )


def _moments(league: League, parts: Sequence[Part]) -> list[tuple[str, Moment]]:
    """Return the best and the worst moment of an entrant, each with its heading, as far as their replays are there."""
    kinds = ("The best moment", best_moment), ("The worst moment", worst_moment)
    moments = []
    for (heading, moment_in), part in zip(kinds, best_and_worst(parts, league.parties) or (), strict=False):
        with suppress(ReplayError):  # a user removed it
            replay = Replay.load(league.state / REPLAYS / f"{part.one.match.id}.replay")
            if moment := moment_in(replay, part.party, part.one.result):
                moments.append((heading, moment))
    return moments


def _meetings(parts: Iterable[Part], league: League, lines: Mapping[int | None, Line]) -> list[dict[str, Any]]:
    """Return the results against each present opponent, the one that was met most often first."""
    found: dict[int, list[int]] = {}
    hunting = league.parties.hunting
    for part in (part for part in parts if part.party < hunting):
        ranks, seating = part.one.result.ranks, part.one.match.seating
        for other, rank in zip(seating[:hunting], ranks, strict=False):
            if other in lines and other != seating[part.party]:
                order = (ranks[part.party] > rank) - (ranks[part.party] < rank)
                found.setdefault(other, [0, 0, 0])[order + 1] += 1
    return [
        {"line": lines[other], "name": league.entrants[other].name, "wins": wins, "ties": ties, "losses": losses}
        for other, (wins, ties, losses) in sorted(found.items(), key=lambda one: -sum(one[1]))
    ]


def _log(league: League, entrant: int) -> str:
    try:
        log = log_file(league.state / LOGS, league.entrants[entrant].name).read_text("utf-8", "replace")
        return without_source(last_lines(log, _LOG_LINES))
    except OSError:  # it printed nothing, or a user removed the file
        return ""


def _axis(ratings: Iterable[RatingThen]) -> Axis:
    return Axis.over(end for one in ratings for end in (one.rating, one.low, one.high) if end is not None)


def _chart(ratings: Sequence[RatingThen], lines: Sequence[Line]) -> dict[str, Any] | None:
    """Return the ratings of some entries over time, as points in a square of 100; None for fewer than two runs."""
    times = sorted({one.time for one in ratings})
    own = {line.entry.key: {version.entrant for version in line.versions} for line in lines}
    shown = {key: [one for one in ratings if one.entrant in entrants] for key, entrants in own.items()}
    if len(times) < 2 or not any(shown.values()):
        return None
    first, last = (datetime.fromisoformat(times[end]).timestamp() for end in (0, -1))
    axis = _axis(one for found in shown.values() for one in found)

    def across(time: str) -> float:
        return round(100.0 * (datetime.fromisoformat(time).timestamp() - first) / max(last - first, 1.0), 2)

    curves = []
    for line in lines:
        points = [(across(one.time), one) for one in shown[line.entry.key]]
        ends = [(x, one.low, one.high) for x, one in points if one.low is not None and one.high is not None]
        edge = [(x, high) for x, _, high in ends] + [(x, low) for x, low, _ in reversed(ends)]
        curves.append(
            {
                "name": line.entry.name,
                "color": line.color,
                "points": " ".join(f"{x},{100 - axis.at(one.rating)}" for x, one in points),
                "band": " ".join(f"{x},{round(100 - axis.at(y), 2)}" for x, y in edge),
            }
        )
    shown_time = slice(11, 16) if times[0][:10] == times[-1][:10] else slice(10)
    return {"curves": curves, "axis": axis, "first": times[0][shown_time], "last": times[-1][shown_time]}


@cache
def _template(name: str) -> jinja2.Template:
    filters = {
        "points": lambda value: f"{value:+.0f}" if value else "0",
        "percent": lambda value: f"{100 * value:.0f} %",
        "without_folders": without_folders,
        "without_source": without_source,
        "moment": lambda time: time[:16].replace("T", " "),
    }
    return page_template(_PAGE, name, filters)
