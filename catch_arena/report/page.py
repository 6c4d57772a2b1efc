"""Page of the report: a tournament's data in a template, as one file that loads nothing.

Texts from strangers stay text: templates escape them, and the page's policy lets only its own scripts run.
"""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final

import jinja2

from catch_arena.config import RULESET
from catch_arena.explanation import Explanation
from catch_arena.explanation.highlights import best_highlights
from catch_arena.files import write_whole
from catch_arena.player.bundle import bundle_text, css, packed_text
from catch_arena.player.element import element_script, script_json
from catch_arena.player.page_template import page_file, page_policy, page_style, page_template
from catch_arena.render.match_info import agent_color
from catch_arena.render.shapes import TURTLE_PARTS, Color
from catch_arena.report import charts
from catch_arena.report.data import ReportData
from catch_arena.report.lost_contests import LostContest, answer_to, find_lost_contests
from catch_arena.report.selection import SelectedMatch, select_matches
from catch_arena.text import without_folders
from catch_arena.tournament.agent_spec import command_of, file_of
from catch_arena.tournament.entrants import SHIPPED_PREY
from catch_arena.tournament.statistics.head_to_head import head_to_head

REPORT: Final = "report.html"
_PAGE: Final = "catch_arena.report"
BUDGET: Final = 1_000_000
"""Default number of bytes for the replays in the page."""
MOST_LISTED: Final = 20_000
"""Greatest number of matches in the page's list."""


def write_report(
    folder: Path, *, budget: int = BUDGET, matches: Sequence[str] = (), output: Path | None = None
) -> Path:
    """Write the report of a tournament, whole or not at all; without `output`, into its folder.

    Its replays may take `budget` bytes, and more only for those of `matches`, given by their ids.

    Raises:
        StoreError: if there is nothing to report.
        ReplayError: for a match that was not recorded.
        OutputError: if the file cannot be written.
    """
    data = ReportData.of(folder)
    path = output or folder / REPORT
    selected = select_matches(data, budget, matches)
    explanations = {match: choice.explanation for match, choice in selected.items()}
    lost = find_lost_contests(data, explanations)
    for match in {one.match for one in lost}:
        answers = [one.answer for one in lost if one.match == match]
        selected[match] = selected[match]._replace(bundle=bundle_text(data.replay(match), answers))
    write_whole(path, page(data, selected, explanations, lost).encode())
    return path


def page(
    data: ReportData,
    selected: dict[str, SelectedMatch],
    explanations: Mapping[str, Explanation],
    lost: Sequence[LostContest] = (),
    *,
    watched: bool = False,
) -> str:
    """Return the report as HTML, which plays the selected matches; the best moment is chosen from `explanations`.

    A `watched` page is served, and requests news and the replays that it shows.
    """
    moment = next(iter(best_highlights(explanations, 1)), None)
    titles = {one.match.id: one.match.title(data.parties.block_size) for one in data.played}
    colors = [agent_color(data.tournament.config, number) for number in range(len(data.tournament.entrants))]
    return _template().render(
        data=data,
        table=data.standings,
        headline=charts.headline_of_sides({side.side: side.standings for side in data.sides}, ended=data.ended),
        sides=[
            {
                "prey": side.side == "prey",
                "table": side.standings,
                "ratings": charts.rating_axis(side.standings),
                "distributions": charts.distributions(side),
                "encounters": head_to_head(side),
            }
            for side in data.sides
        ],
        figures=charts.figures(data, explanations),
        moment=moment,
        answer=answer_to(moment, lost),
        lost=lost,
        titles=titles,
        colors={name: css(color) for side in data.sides for name, color in zip(side.names, colors, strict=True)},
        turtles={name: _turtle(color) for side in data.sides for name, color in zip(side.names, colors, strict=True)},
        teams=len(data.parties) < len(data.parties.by_seat),
        seat_tables=charts.seat_tables(data),
        refusals=charts.refusals(data),
        move_times=charts.move_times(data),
        forfeits=_forfeits(data),
        settings=data.tournament.config.to_flat_dict(),
        ruleset=RULESET,
        shipped_prey=SHIPPED_PREY,
        recorded=len(data.recorded),
        listed=min(len(data.played), MOST_LISTED),
        selected=selected,
        selected_json=script_json({match: [choice.bundle, choice.why] for match, choice in selected.items()}),
        matches=packed_text(script_json(_matches(data, titles)).encode()),
        watched=watched,
        policy=content_policy(watched=watched),
        element=element_script(),
        style=page_style(_PAGE, "report.css"),
        script=page_file(_PAGE, "report.js"),
    )


@cache
def content_policy(*, watched: bool) -> str:
    """Return the Content-Security-Policy: two scripts run, and only a watched page loads its news."""
    return page_policy(element_script(), page_file(_PAGE, "report.js"), connects=watched)


@cache
def _template() -> jinja2.Template:
    filters = {"percent": charts.percent, "interval": charts.interval, "number": charts.number, "origin": _origin}
    return page_template(_PAGE, "report.html", filters)


def _turtle(color: Color) -> list[tuple[str, str]]:
    """Return the parts of a turtle that faces up: a colour and points, for a picture of SVG."""
    parts = []
    for points, own, white in TURTLE_PARTS:
        red, green, blue = (round(own * channel + 255 * white) for channel in color)
        parts.append((css((red, green, blue)), " ".join(f"{-y:.3f},{-x:.3f}" for x, y in points[::2])))
    return parts


def _matches(data: ReportData, titles: Mapping[str, str]) -> dict[str, Any]:
    """Return the list of matches, in columns; values by party stand match after match."""
    played = data.played[:MOST_LISTED]
    return {
        "names": [side.names for side in data.sides],
        "seats": len(data.parties),
        "hunting": data.parties.hunting,
        "ids": [played_match.match.id for played_match in played],
        "titles": [titles[played_match.match.id] for played_match in played],
        "recorded": [int(played_match.match.id in data.recorded) for played_match in played],
        "seating": [entrant for played_match in played for entrant in played_match.match.seating],
        "scores": [score for played_match in played for score in played_match.result.scores],
        "ranks": [rank for played_match in played for rank in played_match.result.ranks],
    }


def _forfeits(data: ReportData) -> list[dict[str, Any]]:
    """Return the ways in which agents forfeited, the most frequent first, each with its count and first case."""
    found: dict[tuple[str, str, str], dict[str, Any]] = {}
    size = data.parties.block_size
    for played_match in data.played:
        for party, forfeit in enumerate(played_match.result.forfeits):
            if forfeit is None:
                continue
            entrant = data.tournament.entrants[played_match.match.seating[party]]
            name, code = entrant.name, forfeit.code
            reason = without_folders(forfeit.reason.replace(entrant.spec, _origin(entrant.spec)))
            place = f"{played_match.match.title(size)}, {data.parties.called(party)}"
            first = {"where": place, "step": forfeit.step, "times": 0}
            way = found.setdefault((name, code, reason), {"name": name, "code": code, "reason": reason} | first)
            way["times"] += 1
    return sorted(found.values(), key=lambda way: -way["times"])


def _origin(spec: str) -> str:
    """Return where an agent comes from: a file's name without its folders, or a command's program."""
    if (words := command_of(spec)) is not None:
        return f"a command: {Path(words[0]).name}"
    return spec if file_of(spec) is None else Path(spec).name
