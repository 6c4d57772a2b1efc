"""Figures that a page draws: numbers become positions in per cent, and texts."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np

from catch_arena.explanation import Explanation
from catch_arena.explanation.formatting import millimetres
from catch_arena.explanation.highlights import has_loser
from catch_arena.policy import Side
from catch_arena.report.data import ReportData, SideData
from catch_arena.tournament.match import MoveTimes
from catch_arena.tournament.statistics.intervals import Estimate, shares
from catch_arena.tournament.statistics.outcomes import sums_by
from catch_arena.tournament.statistics.standings import Standing
from catch_arena.verdicts import Verdict

_TICKS: Final = 5
_BINS: Final = 40
_ROUNDING: Final = 1e-9
"""Largest difference of values, as a share of them, that is due to rounding."""
_LONG: Final = 10_000
"""Least number that is written in groups of three digits."""


@dataclass(frozen=True, slots=True)
class Axis:
    """Range of values, laid over a width of 100."""

    low: float
    high: float
    ticks: tuple[float, ...]

    @classmethod
    def over(cls, values: Iterable[float]) -> "Axis":
        """Return an axis with round ends that holds all values; values that are not finite are left out."""
        known = [value for value in values if math.isfinite(value)]
        low, high = min(known, default=0.0), max(known, default=0.0)
        equal = high - low <= _ROUNDING * max(abs(low), abs(high))
        step = 1.0 if equal else _round_step((high - low) / _TICKS)
        first, last = math.floor(low / step), max(math.ceil(high / step), math.floor(low / step) + 1)
        ticks = tuple(step * number for number in range(first, last + 1))
        return cls(ticks[0], ticks[-1], ticks)

    def at(self, value: float) -> float:
        """Return the position of a value, in [0, 100]."""
        return round(100.0 * min(max((value - self.low) / (self.high - self.low), 0.0), 1.0), 2)

    def whisker(self, estimate: Estimate) -> dict[str, float] | None:
        """Return the left end and width of an interval, and the position of its mean; None if the mean is unknown."""
        if not math.isfinite(estimate.mean):
            return None
        low, high = (estimate.low, estimate.high) if math.isfinite(estimate.low) else (estimate.mean, estimate.mean)
        return {"left": self.at(low), "width": round(self.at(high) - self.at(low), 2), "mean": self.at(estimate.mean)}


def _round_step(smallest: float) -> float:
    """Return the smallest of ..., 1, 2, 5, 10, ... that is not below `smallest`, which is above 0."""
    power = 10.0 ** math.floor(math.log10(smallest))
    return next(power * digit for digit in (1.0, 2.0, 5.0, 10.0) if power * digit >= smallest * (1.0 - 1e-9))


class Figure(NamedTuple):
    """A figure, its name, and a note after it."""

    name: str
    value: str
    note: str = ""


def figures(data: ReportData, explanations: Mapping[str, Explanation]) -> list[Figure]:
    """Return the figures of the first screen: all matches and contests, and the closest contest explained."""
    played, hunting = len(data.played), data.parties.hunting
    of_plan = f"of {number(data.planned)}" if data.planned > played else ""
    contests = sum(sum(one.result.contests_won[:hunting]) for one in data.played)
    margins = [
        contest.margin_um or 0
        for match in explanations.values()
        for contest in match.contests
        if contest.clause == "R5.4" and has_loser(contest)
    ]
    among = "" if len(explanations) == played else f"in {number(len(explanations))} matches"
    catches = sum(sum(one.result.scores[:hunting]) for one in data.played)
    return [
        Figure("Matches played", number(played), of_plan),
        Figure("Contests decided", number(contests)),
        Figure("Closest contest", millimetres(min(margins)), among) if margins else Figure("Catches", number(catches)),
    ]


def headline_of_sides(tables: Mapping[Side, Sequence[Standing]], *, ended: bool) -> str:
    """Return a headline with the leaders of each side."""
    if len(tables) == 1:
        return headline(tables["hunter"], ended=ended)
    lines = {side: headline(table, ended=ended) for side, table in tables.items()}
    if len(set(lines.values())) == 1:
        return lines["hunter"]
    return "As " + "; as ".join(f"{side}: {line}" for side, line in lines.items())


def headline(table: Sequence[Standing], *, ended: bool) -> str:
    """Return a headline with the leaders, as far as they are known."""
    leaders = [line.name for line in table if line.groups[0] == 1]
    if len(table) == 1:
        return f"{table[0].name} played alone"
    if len(leaders) == 1:
        return f"{leaders[0]} comes first" if ended else f"{leaders[0]} leads so far"
    if len(leaders) == len(table):
        return "No difference between the agents is significant yet"
    if len(leaders) > 3:  # more names are too long for a headline
        return f"{leaders[0]} leads, but {len(leaders) - 1} others do not differ significantly"
    return f"{', '.join(leaders[:-1])} and {leaders[-1]} lead without a significant difference"


def rating_axis(table: Sequence[Standing]) -> Axis:
    """Return an axis for ratings; agents that forfeited every match are left out, since their ratings lie far below."""
    played = [line for line in table if sum(line.forfeits.values()) < line.matches] or table
    return Axis.over(end for line in played for end in (line.rating.low, line.rating.mean, line.rating.high))


def distributions(data: SideData) -> dict[str, Any]:
    """Return each agent's distribution of scores, the best agent first: bars as a path in `bins` x 1, and quartiles."""
    outcomes = data.outcomes
    highest = int(outcomes.scores.max())
    width = max(1, math.ceil((highest + 1) / _BINS))
    bins = highest // width + 1
    counts = sums_by(outcomes.entrants, bins, outcomes.seating, outcomes.scores // width)
    parts = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1.0)

    def across(score: float) -> float:
        return round(100.0 * (score / width + 0.5) / bins, 2)

    rows = []
    for line in data.standings:
        entrant = data.names.index(line.name)
        bars = [(at, height) for at, height in enumerate((parts[entrant] / parts.max()).tolist()) if height]
        scores = outcomes.scores[outcomes.seating == entrant]
        quartiles = np.quantile(scores, (0.25, 0.5, 0.75), method="inverted_cdf").tolist()
        rows.append(
            {
                "line": line,
                "path": "".join(f"M{at} 1v{-height:.3f}h1V1" for at, height in bars),
                "quartiles": quartiles,
                "positions": [across(score) for score in quartiles],
            }
        )
    every = max(1, int(_round_step(bins / 8)))
    ticks = [(across(bar * width), bar * width) for bar in range(0, bins, every)]
    return {"rows": rows, "bins": bins, "width": width, "ticks": ticks}


def seat_tables(data: ReportData) -> list[dict[str, Any]]:
    """Return the results by seat: a table for each side that has several seats.

    In each block every agent sat in each seat. A row has a seat's name, its share of wins, in which a tie counts as a
    part of a win for each, and its mean score.
    """
    tables = []
    for side in data.sides:
        names, outcomes = data.parties.names[data.parties.on(side.side)], side.outcomes
        if len(names) == 1 and len(data.sides) > 1:
            continue
        cells = outcomes.blocks, len(names), outcomes.block[:, None], np.arange(len(names))
        wins = shares(sums_by(*cells, outcomes.win_shares), sums_by(*cells))
        ends = [end for share in wins for end in (share.low, share.mean, share.high)]
        rows = list(zip(names, wins, outcomes.scores.mean(axis=0).tolist(), strict=True))
        tables.append({"rows": rows, "axis": Axis.over([0.0, *ends]), "even": 1 / len(names)})
    return tables


def refusals(data: ReportData) -> dict[str, str]:
    """Return the verdicts that refused a request in any match, in the arbiter's order, each with its meaning."""
    met = {name for line in data.standings for name in line.refusals}
    return {verdict.name: verdict.reason for verdict in Verdict if verdict.name in met}


def move_times(data: ReportData) -> dict[str, tuple[float, float]]:
    """Return each agent's mean time for a move (NaN if it made none) and its longest one [ms]."""
    found: dict[str, list[MoveTimes]] = {name: [] for name in data.names}
    for played_match in data.played:
        for entrant, spent in zip(played_match.match.seating, played_match.result.thinking, strict=True):
            found[data.names[entrant]].append(spent)
    in_all = {name: MoveTimes.of_all(times) for name, times in found.items()}
    return {name: (times.mean_ms, 1000.0 * times.longest_s) for name, times in in_all.items()}


def percent(share: float) -> str:
    """Return a share in [0, 1] as text in per cent, or a dash for NaN."""
    return "–" if math.isnan(share) else f"{100 * share:.0f} %"


def interval(estimate: Estimate, scale: float = 1.0, digits: int = 0) -> str:
    """Return an interval as text, such as «43 to 57», or «interval unknown»."""
    if not math.isfinite(estimate.low):
        return "interval unknown"
    return f"{number(scale * estimate.low, digits)} to {number(scale * estimate.high, digits)}"


def number(value: float, digits: int = 0) -> str:
    """Return a number as text: thin spaces between the thousands of long ones, and a minus as wide as a plus."""
    if not math.isfinite(value):
        return "–"
    text = f"{round(value, digits) + 0.0:,.{digits}f}".replace("-", "−")  # + 0.0: no minus before a zero
    return text.replace(",", "\u202f" if abs(value) >= _LONG else "")
