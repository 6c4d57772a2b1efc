"""Print and draw runs of train_ppo.py as one learning curve: `python examples/training_curves.py runs/seed*`.

One run says little about a recipe, because another seed learns faster or slower. So give three or more runs that differ
in their seed alone. A row is a tournament that all runs have played: the decisions and seconds before it, the share of
wins (mean of the runs, least and most), and the learner's rating above that of the best of the others. With
`--out curve.svg` the shares of wins are a picture too.
"""

import argparse
import csv
import sys
from pathlib import Path
from statistics import mean

from catch_arena.errors import reason

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("runs", nargs="+", type=Path, help="folders that train_ppo.py has written (--out)")
parser.add_argument("--out", type=Path, help="picture of the curve, a file .svg")
given = parser.parse_args()
if given.out and given.out.suffix != ".svg":
    parser.error(f"--out must end in .svg, got {given.out}; a browser or Inkscape converts it")

PICTURE = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 640 330" font-family="sans-serif" font-size="13">
<rect width="640" height="330" rx="6" fill="#ffffff"/>
<text x="20" y="24" font-weight="bold">share of matches won</text>
{grid}
<path d="M{band}Z" fill="#3a49d6" fill-opacity="0.18"/>
<path d="M{line}" fill="none" stroke="#3a49d6" stroke-width="2.5" stroke-linejoin="round"/>
{dots}
<text x="620" y="318" text-anchor="end">decisions, in millions</text>
</svg>
"""


def picture(points: list[tuple[int, list[float]]]) -> str:
    """Return an SVG of the shares of wins of all runs by decisions: their mean, and a band from least to most."""
    last = points[-1][0]

    def at(decisions: float, percent: float) -> str:
        return f"{60 + 560 * decisions / last:.1f} {280 - 2.4 * percent:.1f}"

    grid = []
    for percent in range(0, 101, 25):
        grid.append(f'<path d="M{at(0, percent)}H620" stroke="#c8ccda"/>')
        grid.append(f'<text x="50" y="{284 - 2.4 * percent:.1f}" text-anchor="end">{percent} %</text>')
    for part in range(5):
        x, _ = at(last * part / 4, 0).split()
        grid.append(f'<text x="{x}" y="300" text-anchor="middle">{last * part / 4e6:.2f}</text>')
    most = [at(decisions, max(wins)) for decisions, wins in points]
    least = [at(decisions, min(wins)) for decisions, wins in reversed(points)]
    line = "L".join(at(decisions, mean(wins)) for decisions, wins in points)
    centres = (at(decisions, mean(wins)).split() for decisions, wins in points)
    dots = "".join(f'<circle cx="{x}" cy="{y}" r="3" fill="#3a49d6"/>' for x, y in centres)
    return PICTURE.format(grid="\n".join(grid), band="L".join(most + least), line=line, dots=dots)


def in_words(decisions: int) -> str:
    """Return a number of decisions in millions, or in thousands below one million."""
    return f"{decisions / 1e6:.1f} million" if decisions >= 1e6 else f"{decisions / 1e3:.0f} thousand"


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
    except FileNotFoundError:
        sys.exit(f"{run}: no tournament has been played yet; train_ppo.py plays one after --evaluate decisions")
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
        f"| {in_words(decisions)} | {mean(seconds):.0f} | {mean(wins):.0f} % "
        f"| {min(wins):.0f} to {max(wins):.0f} % | {mean(leads):+.0f} ({min(leads):+.0f} to {max(leads):+.0f}) |"
    )
if given.out:
    shares = [(decisions, [curve[decisions][1] for curve in curves]) for decisions in played]
    given.out.write_text(picture(shares), encoding="utf-8")
    print(f"curve: {given.out}")
