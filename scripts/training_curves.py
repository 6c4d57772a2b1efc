"""Prints several runs of scripts/train_ppo.py as one learning curve: `python scripts/training_curves.py runs/seed*`.

One run says little of how a recipe learns: the same settings with another seed learn faster or slower. So give runs
that differ in their seed alone, three or more. A row is a tournament that all runs have played: after how many
decisions and seconds, the share of wins (mean of the runs, least and most), and by how much the learner's rating is
above that of the best of the others.
"""

import argparse
import csv
import statistics
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from catch_arena.errors import reason

LEARNER = "ppo"
"""What train_ppo.py calls its agent."""


class Point(NamedTuple):
    """One tournament of one run."""

    decisions: int
    seconds: float
    wins: float
    """The learner's share of wins [%]."""
    lead: float
    """Its rating above that of the best of the others."""


def points_of(run: Path) -> list[Point]:
    """A run's tournaments, in their order.

    Raises:
        ValueError: for a folder that has none.
    """
    path = run / "curve.csv"
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        found = []
        for decisions in dict.fromkeys(row["decisions"] for row in rows):
            ratings = {row["agent"]: float(row["rating"]) for row in rows if row["decisions"] == decisions}
            own = next(row for row in rows if row["decisions"] == decisions and row["agent"] == LEARNER)
            best = max(rating for agent, rating in ratings.items() if agent != LEARNER)
            lead = ratings[LEARNER] - best
            found.append(Point(int(decisions), float(own["seconds"]), 100 * float(own["win_share"]), lead))
    except (OSError, KeyError, ValueError, StopIteration) as error:
        raise ValueError(f"{path}: must be a curve that train_ppo.py has written: {reason(error)}") from None
    if not found:
        raise ValueError(f"{path}: holds no tournament")
    return found


def table(runs: Sequence[Sequence[Point]]) -> str:
    """As Markdown.

    Raises:
        ValueError: for runs that have no tournament in common.
    """
    lines = [
        "| decisions | seconds | wins, mean of the runs | least to most | rating above the best of the others |",
        "|---:|---:|---:|---:|---:|",
    ]
    by_decisions = [{point.decisions: point for point in points} for points in runs]
    played = [after for after in by_decisions[0] if all(after in one for one in by_decisions)]
    if not played:
        raise ValueError("the runs have no tournament after the same number of decisions")
    for after in played:
        points = [one[after] for one in by_decisions]
        _, seconds, wins, leads = (list(column) for column in zip(*points, strict=True))
        lines.append(
            f"| {after / 1e6:.1f} million | {statistics.mean(seconds):.0f} "
            f"| {statistics.mean(wins):.0f} % | {min(wins):.0f} to {max(wins):.0f} % "
            f"| {statistics.mean(leads):+.0f} ({min(leads):+.0f} to {max(leads):+.0f}) |"
        )
    return "\n".join(lines)


def main() -> int:
    """The exit code: 0, or 2 with a line that says why not."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path, help="folders that train_ppo.py wrote (--out)")
    args = parser.parse_args()
    try:
        print(table([points_of(run) for run in args.runs]))
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
