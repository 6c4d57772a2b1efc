"""Standings, a suite's figures, figures with intervals and a plan's cost, for a terminal of usually 80 columns."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import timedelta
from typing import Final

from rich.filesize import decimal
from rich.table import Table

from catch_arena.cli.terminal import echo, own_console, plain_table
from catch_arena.policy import Side
from catch_arena.suite.measures import AgentMeasures, Scores
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.execution.cost import Cost, match_counts
from catch_arena.tournament.plans.schedule import Plan, UntilSeparated
from catch_arena.tournament.statistics.intervals import FEWEST_BLOCKS, Estimate
from catch_arena.tournament.statistics.sprt import elo_of_share
from catch_arena.tournament.statistics.standings import Standing

_KEY: Final = """grp: members of a group do not differ significantly
rating: points, 0 is the mean; {score}
wins: matches won, ties shared"""
_SUITE_KEY: Final = """score: own catches / (own + the mean opponent's catches); 0.5 is level
wins: matches won, ties shared; place: by rating, among itself and its opponents
first: significantly better than each opponent; open: not decided yet"""
_FIRST: Final = {True: "yes", None: "open", False: "no"}
PARTS: Final = {"training": False, "held out": True}
"""Parts of a suite, each with whether its scenarios are held out."""


def print_standings(tables: Mapping[Side, Sequence[Standing]], entrants: Iterable[Entrant]) -> None:
    """Print the standings, and the number of matches from which each excluded entrant was left out."""
    for side, table in tables.items():
        own_console().print(standings_table(table, side, titled=len(tables) > 1))
    for entrant in entrants:
        lines = [one for side, table in tables.items() for one in table if one.name == entrant.on(side).name]
        if without := sum(one.forfeits.get("FORFEIT_OUT", 0) for one in lines):
            matches = sum(one.matches for one in lines)
            echo(f"{entrant.name} was excluded: {without} of its {matches} matches were played without it")


def standings_table(table: Sequence[Standing], side: Side = "hunter", *, titled: bool = False) -> Table:
    """Return the standings of a side, with margins of 95 % confidence."""
    hunts = side == "hunter"
    key = _KEY.format(score="score: catches per match" if hunts else "caught: times per match")
    columns: dict[str, Callable[[Standing], str]] = {
        "#": lambda line: str(line.place),
        "agent": lambda line: line.name,
        "grp": lambda line: line.group,
        "played": lambda line: str(line.matches),
        "rating": lambda line: _with_margin(line.rating, "+.0f", 1),
        "score" if hunts else "caught": lambda line: _with_margin(line.score, ".1f", 1),
        "wins": lambda line: _with_margin(line.win_share, ".0f", 100) + " %",
    }
    if hunts:
        key += "; cont.: contests won"
        columns["cont."] = lambda line: (
            "-" if math.isnan(line.contest_win_share) else f"{100 * line.contest_win_share:.0f} %"
        )
    if any(line.lost_to_mates for line in table):
        key += "\nmates: requests per match lost to a team-mate"
        columns["mates"] = lambda line: f"{line.lost_to_mates:.1f}"
    if any(line.forfeits for line in table):
        key += "\nforf.: matches forfeited"
        columns["forf."] = lambda line: str(sum(line.forfeits.values()))
    title = {"hunter": "As hunters", "prey": "As prey"}[side] if titled else None
    shown = plain_table(*columns, text="agent", padding=(0, 1, 0, 0), title=title, caption=key)
    for line in table:
        shown.add_row(*(cell(line) for cell in columns.values()), style="bold" if line.place == 1 else None)
    return shown


def print_measures(measures: AgentMeasures, known: Mapping[str, Scores]) -> None:
    """Print the tables and figures of an agent in a suite."""
    for part, held_out in PARTS.items():
        shown = plain_table(
            *("scenario", "score", "95 %", "wins", "95 %", "place", "first", "forf."),
            title=f"{measures.agent.name}, {part.replace(' ', '-')} scenarios",
            padding=(0, 1, 0, 0),
        )
        for scenario in measures.scenarios:
            if scenario.held_out == held_out:
                shown.add_row(
                    scenario.name,
                    f"{scenario.score.mean:.2f}",
                    interval(scenario.score, ".2f"),
                    f"{100 * scenario.win_share.mean:.0f} %",
                    interval(scenario.win_share, ".0f", 100),
                    f"{scenario.place} of {scenario.of}",
                    "?" if scenario.first is None and measures.blocks < FEWEST_BLOCKS else _FIRST[scenario.first],
                    str(sum(scenario.forfeits.values())),
                )
        own_console().print(shown)
    echo(_SUITE_KEY)
    echo(f"interquartile mean, training: {with_interval(measures.training, '.3f')}")
    echo(f"interquartile mean, held out: {with_interval(measures.held_out, '.3f')}")
    echo(f"gap, training minus held out: {with_interval(measures.gap, '.3f')}")
    echo("time: it made no move" if math.isnan(measures.move_ms) else f"time: {measures.move_ms:.2f} ms per move")
    for name, scores in known.items():
        figures = ", ".join(
            f"{part} {with_interval(measures.improvement(scores, held_out=held_out), '.2f')}"
            for part, held_out in PARTS.items()
        )
        echo(f"probability of improvement over {name}: {figures}")


def plan_table(plan: Plan, entrants: int, cost: Cost | None, jobs: int) -> Table:
    """Return the plan and, if known, its cost."""
    shown = Table(box=None, show_header=False, pad_edge=False)
    shown.add_row("plan", ", ".join(f"{name} {value}" for name, value in plan.parameters.items()))
    shown.add_row("matches", f"{'at most ' if isinstance(plan, UntilSeparated) else ''}{plan.size}")
    if not isinstance(plan, UntilSeparated):
        played, met = match_counts(plan, entrants)
        shown.add_row("an agent plays", f"{_number_range(*played)} matches")
        shown.add_row("a pair meets in", f"{_number_range(*met)} matches")
    if cost is not None:
        alone_s = plan.size * cost.seconds
        shared = f"{_duration(alone_s / jobs)} with {jobs} processes, " if jobs > 1 else ""
        shown.add_row("time", f"about {shared}{_duration(alone_s)} with one process")
        shown.add_row("store", f"about {decimal(plan.size * cost.stored)}")
        if cost.replay:
            shown.add_row("replays", f"about {decimal(plan.size * cost.replay)}")
    return shown


def _number_range(low: int, high: int) -> str:
    return f"{low}" if low == high else f"{low} to {high}"


def _duration(seconds: float) -> str:
    """Return a duration in words: seconds, or hours, minutes and seconds."""
    return f"{max(seconds, 0.1):.1f} s" if seconds < 60 else str(timedelta(seconds=round(seconds)))


def interval(estimate: Estimate, form: str, scale: int = 1) -> str:
    """Return the two ends of an estimate's interval, or «?» if there are too few blocks."""
    if math.isnan(estimate.low):
        return "?"
    return f"{scale * estimate.low:{form}} to {scale * estimate.high:{form}}"


def with_interval(estimate: Estimate, form: str) -> str:
    """Return an estimate, and its interval in brackets."""
    return f"{estimate.mean:{form}} ({interval(estimate, form)})"


def share_text(share: Estimate) -> str:
    """Return a share in per cent and in points, each with its interval if there is one."""
    if math.isnan(share.margin):
        points = elo_of_share(share.mean)
        return f"{100 * share.mean:.1f} %, {points:+.0f} points; an interval needs {FEWEST_BLOCKS} blocks"
    mean, low, high = (f"{elo_of_share(one):+.0f}" for one in (share.mean, share.low, share.high))
    return f"{100 * share.mean:.1f} % ({interval(share, '.1f', 100)}), {mean} points ({low} to {high})"


def _with_margin(estimate: Estimate, form: str, scale: int) -> str:
    margin = "?" if math.isnan(estimate.margin) else format(scale * estimate.margin, form.removeprefix("+"))
    mean = f"{scale * estimate.mean:{form}}"
    return f"{'+0' if mean == '-0' else mean} ± {margin}"
