"""Figures that a page draws: numbers become positions in per cent, and words."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from catch_arena.policy import Side
from catch_arena.report.data import ReportData, SideData
from catch_arena.tournament.statistics.intervals import Estimate, shares
from catch_arena.tournament.statistics.outcomes import sums_by
from catch_arena.tournament.statistics.standings import Standing
from catch_arena.verdicts import REASONS, Verdict

_TICKS: Final = 5
_BINS: Final = 40
_LONG: Final = 10_000
"""Numbers from here on are easier to read in groups of three digits."""
_ROOMY: Final = 12
"""More agents than these have smaller cells in the head-to-head table."""
_WORDY: Final = 40
"""Up to so many agents each cell of the head-to-head table says all that it knows."""


@dataclass(frozen=True, slots=True)
class Axis:
    """A range of values, laid over a width of 100."""

    low: float
    high: float
    ticks: tuple[float, ...]

    @classmethod
    def over(cls, values: Iterable[float]) -> "Axis":
        """One with round ends that holds all these values; NaN is left out."""
        known = [value for value in values if math.isfinite(value)]
        low, high = min(known, default=0.0), max(known, default=0.0)
        step = _round_step((high - low) / _TICKS)
        first, last = math.floor(low / step), max(math.ceil(high / step), math.floor(low / step) + 1)
        ticks = tuple(step * number for number in range(first, last + 1))
        return cls(ticks[0], ticks[-1], ticks)

    def at(self, value: float) -> float:
        """Where a value stands, in [0, 100]."""
        return round(100.0 * min(max((value - self.low) / (self.high - self.low), 0.0), 1.0), 2)

    def whisker(self, one: Estimate) -> dict[str, float] | None:
        """Where an interval begins, how long it is, and where the figure stands; None where it is not known."""
        if not math.isfinite(one.mean):
            return None
        low, high = (one.low, one.high) if math.isfinite(one.low) else (one.mean, one.mean)
        return {"left": self.at(low), "width": round(self.at(high) - self.at(low), 2), "mean": self.at(one.mean)}


def _round_step(least: float) -> float:
    """The smallest of 1, 2, 5, 10 ... that is no smaller."""
    if least <= 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(least))
    return next(power * digit for digit in (1.0, 2.0, 5.0, 10.0) if power * digit >= least * (1.0 - 1e-9))


def headline_of_sides(tables: Mapping[Side, Sequence[Standing]], *, ended: bool) -> str:
    """Who is ahead on each side."""
    if len(tables) == 1:
        return headline(tables["hunter"], ended=ended)
    return "; ".join(f"as {word}: {headline(table, ended=ended)}" for word, table in tables.items()).capitalize()


def headline(table: Sequence[Standing], *, ended: bool) -> str:
    """Who is ahead, as far as that is known."""
    leaders = [line.name for line in table if line.groups[0] == 1]
    if len(table) == 1:
        return f"{table[0].name} played alone"
    if len(leaders) == 1:
        return f"{leaders[0]} comes first" if ended else f"{leaders[0]} leads so far"
    if len(leaders) == len(table):
        return "Nobody can be told apart yet"
    if len(leaders) > 3:  # more names are no headline
        return f"{leaders[0]} leads, and {len(leaders) - 1} others cannot be told from the best"
    return f"{', '.join(leaders[:-1])} and {leaders[-1]} lead and cannot be told apart"


def rating_axis(table: Sequence[Standing]) -> Axis:
    """For the ratings of those who played: one that forfeited everything has one far below, that says no more."""
    played = [line for line in table if sum(line.forfeits.values()) < line.matches] or table
    return Axis.over(end for line in played for end in (line.rating.low, line.rating.mean, line.rating.high))


def lanes(table: Sequence[Standing]) -> list[list[str]]:
    """Bars beside those that share a group: for each line of the table, what stands in each lane.

    «begin», «within», «end» or nothing; no two bars of one lane touch, and there are as few lanes as will do.
    """
    bars: list[list[int]] = []
    for group in range(1, 1 + max(one.groups[1] for one in table)):
        members = [row for row, one in enumerate(table) if one.groups[0] <= group <= one.groups[1]]
        if len(members) > 1:
            bars.append(members)
    ends: list[int] = []  # of each lane, its last bar's
    found: list[list[str]] = [[] for _ in table]
    for members in bars:
        lane = next((lane for lane, end in enumerate(ends) if end < members[0]), len(ends))
        if lane == len(ends):
            ends.append(0)
            for line in found:
                line.append("")
        ends[lane] = members[-1]
        for member in members:
            found[member][lane] = {members[0]: "begin", members[-1]: "end"}.get(member, "within")
    return found


def distributions(data: SideData) -> dict[str, Any]:
    """How often each agent had which score, the best agent first: bars as a path in `bins` x 1, and the quartiles."""
    outcomes = data.outcomes
    most = int(outcomes.scores.max())
    width = max(1, math.ceil((most + 1) / _BINS))
    bins = most // width + 1
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


def encounters(data: SideData) -> dict[str, Any]:
    """Each against each, the best first: the shares as whole per cents, and in words where there is room for them."""
    names = [line.name for line in data.standings]
    wordy = len(names) <= _WORDY
    rows = []
    for name in names:
        cells: list[dict[str, Any] | None] = []
        for other in names:
            one = data.encounters.get((name, other))
            if one is None or not one.matches:
                cells.append(None)
                continue
            tooltip = (
                f"{name} against {other}: {one.wins} won, {one.ties} tied, {one.matches - one.wins - one.ties} lost; "
                f"{percent(one.share.mean)} ({interval(one.share, 100)}); probability of improvement "
                f"{percent(one.improvement)}"
            )
            share = round(100 * one.share.mean)
            cells.append(
                {"share": share, "improvement": round(100 * one.improvement), "tooltip": tooltip if wordy else ""}
            )
        rows.append({"name": name, "cells": cells})
    return {"names": names, "rows": rows, "small": len(names) > _ROOMY}


@dataclass(frozen=True, slots=True)
class Seat:
    """Results of one seat; of a team's seats, or of one prey."""

    wins: Estimate
    """Its share of wins, ties shared."""
    score: float


def seat_tables(data: ReportData) -> list[dict[str, Any]]:
    """Return the results by seat: a table for each side that has several seats."""
    tables = []
    for side in data.sides:
        cut = data.parties.on(side.side)
        if len(data.parties.seats[cut]) > 1 or len(data.sides) == 1:
            tables.append(_seat_table(data.parties.names[cut], seat_results(side)))
    return tables


def _seat_table(names: Sequence[str], seats: Sequence[Seat]) -> dict[str, Any]:
    ends = [end for seat in seats for end in (seat.wins.low, seat.wins.mean, seat.wins.high)]
    return {"rows": list(zip(names, seats, strict=True)), "axis": Axis.over([0.0, *ends]), "even": 1 / len(seats)}


def seat_results(data: SideData) -> list[Seat]:
    """How the seats of this tournament fared: each agent sat in each of them, block by block."""
    outcomes = data.outcomes
    seat = np.broadcast_to(np.arange(outcomes.seating.shape[1]), outcomes.seating.shape)
    block = np.broadcast_to(outcomes.block[:, None], outcomes.seating.shape)

    def by_block(values: Any) -> Any:
        return sums_by(outcomes.blocks, seat.shape[1], block, seat, values)

    wins = shares(by_block(outcomes.win_shares), by_block(1.0))
    return [Seat(won, float(score)) for won, score in zip(wins, outcomes.scores.mean(axis=0), strict=True)]


def refusals(data: ReportData) -> dict[str, str]:
    """Which reasons occurred at all, in the arbiter's order, each with what it means."""
    met = {name for line in data.standings for name in line.refusals}
    return {verdict.name: REASONS[verdict] for verdict in Verdict if verdict.name in met}


def move_times(data: ReportData) -> dict[str, tuple[float, float]]:
    """Each agent's time for a move [ms]: the mean, and the longest."""
    found = {name: [0.0, 0.0, 0.0] for name in data.names}
    for one in data.played:
        for entrant, spent in zip(one.match.seating, one.result.thinking, strict=True):
            times = found[data.names[entrant]]
            times[0] += spent.moves
            times[1] += spent.total_s
            times[2] = max(times[2], spent.longest_s)
    return {
        name: (1000.0 * total / max(moves, 1.0), 1000.0 * longest) for name, (moves, total, longest) in found.items()
    }


def percent(share: float) -> str:
    """A share in [0, 1] for people."""
    return "–" if math.isnan(share) else f"{100 * share:.0f} %"


def interval(one: Estimate, scale: float = 1.0, digits: int = 0) -> str:
    """«43 to 57», or that it is not known."""
    if not math.isfinite(one.low):
        return "interval unknown"
    return f"{number(scale * one.low, digits)} to {number(scale * one.high, digits)}"


def number(value: float, digits: int = 0) -> str:
    """With thin spaces between the thousands of long ones, and a minus that is as wide as a plus."""
    if not math.isfinite(value):
        return "–"
    text = f"{round(value, digits) + 0.0:,.{digits}f}".replace("-", "−")  # + 0.0: no minus before a zero
    return text.replace(",", "\u202f" if abs(value) >= _LONG else "")
