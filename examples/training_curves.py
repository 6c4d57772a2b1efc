"""Print several runs of train_ppo.py as one learning curve: `python examples/training_curves.py runs/seed*`.

One run says little about a recipe, because another seed learns faster or slower. So give three or more runs that differ
in their seed alone. A row is a tournament that all runs have played: the decisions and seconds before it, the share of
wins (mean of the runs, least and most), and the learner's rating above that of the best of the others.
"""

import argparse
import csv
import sys
from pathlib import Path
from statistics import mean

from catch_arena.errors import reason

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("runs", nargs="+", type=Path, help="folders that train_ppo.py has written (--out)")
given = parser.parse_args()

curves = []
"""Seconds, share of wins [%] and lead in rating of each run, by the number of decisions."""
for run in given.runs:
    try:
        tournaments: dict[int, dict[str, dict[str, str]]] = {}
        with (run / "curve.csv").open(newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                tournaments.setdefault(int(row["decisions"]), {})[row["agent"]] = row
        curve = {}
        for decisions, rows in tournaments.items():
            own, best = rows.pop("ppo"), max(float(row["rating"]) for row in rows.values())
            curve[decisions] = float(own["seconds"]), 100 * float(own["win_share"]), float(own["rating"]) - best
        curves.append(curve)
    except (OSError, KeyError, ValueError) as error:
        sys.exit(f"{run / 'curve.csv'}: is not a curve of train_ppo.py: {reason(error)}")

played = [decisions for decisions in curves[0] if all(decisions in curve for curve in curves)]
if not played:
    sys.exit("the runs have no tournament after the same number of decisions; train with the same --evaluate")
print("| decisions | seconds | wins, mean of the runs | least to most | rating above the best of the others |")
print("|---:|---:|---:|---:|---:|")
for decisions in played:
    seconds, wins, leads = zip(*(curve[decisions] for curve in curves), strict=True)
    print(
        f"| {decisions / 1e6:.1f} million | {mean(seconds):.0f} | {mean(wins):.0f} % "
        f"| {min(wins):.0f} to {max(wins):.0f} % | {mean(leads):+.0f} ({min(leads):+.0f} to {max(leads):+.0f}) |"
    )
