"""Print and draw runs of train_ppo.py or train_sides.py: `python examples/training_curves.py runs/seed*`.

One run says little about a recipe, because another seed learns faster or slower. So give three or more runs that differ
in their seed alone. For train_ppo.py, a row is a tournament that all runs have played: the decisions and seconds before
it, the share of wins (mean of the runs, least and most), and the learner's rating above that of the best of the others.
For train_sides.py, each side and scripted agent has a table, with the share of wins or the catches in a match of each
run, and the interval of 95 %. With `--out curve.svg` the shares of wins, or the catches, are a picture too.
"""

import argparse
import csv
import json
import sys
from pathlib import Path
from statistics import mean

PICTURE = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 640 {height}" font-family="sans-serif" font-size="13">
<rect width="640" height="{height}" rx="6" fill="#ffffff"/>
{panels}
</svg>
"""
PANEL = """<text x="20" y="{head}" font-weight="bold">{title}</text>
<text x="620" y="{head}" text-anchor="end" font-weight="bold">{names}</text>
{grid}
{lines}
<text x="620" y="{foot}" text-anchor="end">decisions, in millions</text>"""
HEIGHT = 330
COLOURS = ("#3a49d6", "#c2410c", "#0f766e", "#a21caf", "#52525b")
PARTS = (0.25, 0.5, 1, 2, 3, 5, 10, 25, 50, 100)  # what a quarter of the vertical axis may be

Curves = dict[str, list[tuple[int, float, float, float]]]
"""By name, the points of each curve: decisions, value, lower and upper end of its band."""


def panel(top: int, title: str, curves: Curves) -> str:
    """Return the elements of a panel that begins at this height; shares are in percent."""
    points, unit = [point for curve in curves.values() for point in curve], " %" if title.startswith("share") else ""
    last, highest = max(1, *(point[0] for point in points)), 100 if unit else max(point[3] for point in points)
    part = next((part for part in PARTS if 4 * part >= highest), highest)

    def at(decisions: float, value: float) -> str:
        return f"{60 + 560 * decisions / last:.1f} {top + 280 - 60 * value / part:.1f}"

    grid, lines, names = [], [], []
    for count in range(5):
        x, y = at(last * count / 4, 0).split()[0], top + 280 - 60 * count
        grid.append(f'<path d="M60.0 {y:.1f}H620" stroke="#c8ccda"/>')
        grid.append(f'<text x="50" y="{y + 4:.1f}" text-anchor="end">{part * count:g}{unit}</text>')
        grid.append(f'<text x="{x}" y="{top + 300}" text-anchor="middle">{last * count / 4e6:.2f}</text>')
    for place, (name, run) in enumerate(curves.items()):
        colour = COLOURS[place % len(COLOURS)]
        most = [at(decisions, high) for decisions, _, _, high in run]
        least = [at(decisions, low) for decisions, _, low, _ in reversed(run)]
        middle = [at(decisions, value) for decisions, value, _, _ in run]
        lines.append(f'<path d="M{"L".join(most + least)}Z" fill="{colour}" fill-opacity="0.18"/>')
        line = f'<path d="M{"L".join(middle)}" fill="none" stroke="{colour}"'
        lines.append(f'{line} stroke-width="2.5" stroke-linejoin="round"/>')
        lines += [f'<circle cx="{x}" cy="{y}" r="3" fill="{colour}"/>' for x, y in map(str.split, middle)]
        names.append(f'<tspan fill="{colour}">{name}</tspan>')
    shown = {"grid": "\n".join(grid), "lines": "\n".join(lines), "names": "&#160; ".join(names)}
    return PANEL.format(head=top + 24, foot=top + 318, title=title, **shown)


def in_words(decisions: float) -> str:
    """Return a number of decisions in millions, or in thousands below one million."""
    return f"{decisions / 1e6:.1f} million" if decisions >= 1e6 else f"{decisions / 1e3:.0f} thousand"


def show_sides(runs: list[Path]) -> dict[str, Curves]:
    """Print runs of train_sides.py, and return the panels of their picture, by title."""
    panels: dict[str, Curves] = {}
    for run in runs:
        found = json.loads((run / "curve.json").read_text(encoding="utf-8"))
        for row in found["curve"]:
            figure, title, scale = ("wins", "share of wins", 100) if "wins" in row else ("catches", "catches", 1)
            first, second = ("against", "side") if row["side"] == "prey" else ("side", "against")
            title += f" of {row[first]} against {row[second]} in {found['settings']['scenario']}"
            value, low, high = (scale * one for one in row[figure])
            curve = panels.setdefault(title, {}).setdefault(run.name, [])
            curve.append((row["decisions"], value, max(0, low), high))
    for title, curves in panels.items():
        print(f"\n{title}:\n\n| decisions | {' | '.join(curves)} |\n|---:|{len(curves) * '---:|'}")
        digits, unit = (0, " %") if title.startswith("share") else (1, "")
        for row in zip(*curves.values(), strict=False):  # an evaluation that all runs have
            cells = [f"{value:.{digits}f}{unit} ({low:.{digits}f} to {high:.{digits}f})" for _, value, low, high in row]
            print(f"| {in_words(mean(point[0] for point in row))} | {' | '.join(cells)} |")
    return panels


def show_tournaments(runs: list[Path]) -> dict[str, Curves]:
    """Print runs of train_ppo.py, and return the panel of their picture, by title."""
    played: dict[int, list[tuple[float, float, float]]] = {}  # seconds, share of wins [%] and lead, by decisions
    for run in runs:
        with (run / "curve.csv").open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        for own in (row for row in rows if row["agent"] == "ppo"):
            others = [row for row in rows if row["decisions"] == own["decisions"] and row is not own]
            lead = float(own["rating"]) - max(float(row["rating"]) for row in others)
            figures = played.setdefault(int(own["decisions"]), [])
            figures.append((float(own["seconds"]), 100 * float(own["win_share"]), lead))
    common = {decisions: figures for decisions, figures in played.items() if len(figures) == len(runs)}
    if not common:
        sys.exit("the runs have no tournament after the same number of decisions; train with the same --evaluate")
    print("| decisions | seconds | wins, mean of the runs | least to most | rating above the best of the others |")
    print("|---:|---:|---:|---:|---:|")
    points = []
    for decisions, figures in common.items():
        seconds, wins, leads = zip(*figures, strict=True)
        points.append((decisions, mean(wins), min(wins), max(wins)))
        print(
            f"| {in_words(decisions)} | {mean(seconds):.0f} | {mean(wins):.0f} % "
            f"| {min(wins):.0f} to {max(wins):.0f} % | {mean(leads):+.0f} ({min(leads):+.0f} to {max(leads):+.0f}) |"
        )
    return {"share of matches won": {"": points}}


def main() -> None:
    """Print and draw the runs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path, help="folders that a trainer has written (--out)")
    parser.add_argument("--out", type=Path, help="picture of the curve, a file .svg")
    given = parser.parse_args()
    if given.out and given.out.suffix != ".svg":
        parser.error(f"--out must end in .svg, got {given.out}; a browser or Inkscape converts it")
    kind = "curve.json" if (given.runs[0] / "curve.json").exists() else "curve.csv"
    for run in given.runs:
        if not (run / kind).exists():
            sys.exit(f"{run}: has no {kind}; a trainer writes it after --evaluate decisions")
    panels = show_sides(given.runs) if kind == "curve.json" else show_tournaments(given.runs)
    if given.out:
        drawn = [panel(HEIGHT * place, title, curves) for place, (title, curves) in enumerate(panels.items())]
        text = PICTURE.format(height=HEIGHT * len(drawn), panels="\n".join(drawn))
        given.out.write_text(text, encoding="utf-8")
        print(f"curve: {given.out}")


if __name__ == "__main__":
    main()
