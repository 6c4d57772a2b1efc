"""Measure runs of train_sides.py against each other: `python examples/measure_others.py runs/tag_*`.

A curve against a script ends where the script is beaten. Here each snapshot of a run plays the last agents of the other
runs, which it has never met. The runs differ in their seed alone.

Files in --out: `NAME/curve.json` of each run, which training_curves.py prints and draws.
"""

import json
from argparse import ArgumentDefaultsHelpFormatter, ArgumentParser, Namespace
from pathlib import Path
from typing import Any

from train_ppo import errors_in_one_line
from train_sides import measure, opposed, parties_of

from catch_arena import interrupts
from catch_arena.errors import ConfigError
from catch_arena.files import prepare_folder, write_whole
from catch_arena.policy import Side
from catch_arena.scenarios import scenario


def curve_of(run: Path, others: list[Path], settings: Namespace) -> list[dict[str, Any]]:
    """Return the results of each snapshot of a run."""
    config = scenario(settings.scenario, control="velocity")
    sides: dict[Side, str] = {"prey" if word == "prey" else "hunter": word for word in settings.learn}
    curve = []
    for side, word in sides.items():
        opponent = sides.get(opposed(parties_of(config, settings.learn), side))
        if opponent is None:
            raise ConfigError(f"{run}: no side has learned to play against its {word}; give runs of both sides")
        opponents = [str(other / f"{opponent}.py") for other in others]
        ages = sorted(int(path.stem.split("_")[1]) for path in (run / "snapshots").glob(f"{word}_*.py"))
        for age in ages:
            agent = str(run / "snapshots" / f"{word}_{age}.py")
            row = {"side": word, "against": f"{opponent} of other runs", "decisions": age}
            curve.append(row | measure(settings, config, side, agent, opponents))
            print(run.name, json.dumps(curve[-1]), flush=True)
    return curve


@errors_in_one_line("measure_others")
def main() -> None:
    """Measure all runs."""
    parser = ArgumentParser(description=(__doc__ or "").splitlines()[0], formatter_class=ArgumentDefaultsHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path, help="folders that train_sides.py has written (--out)")
    parser.add_argument("--out", type=Path, default=Path("runs/others"), help="folder of the curves")
    parser.add_argument("--matches", type=int, default=128, help="number of matches of each snapshot")
    given = parser.parse_args()
    if given.matches < 2:
        parser.error(f"--matches must be at least 2, got {given.matches}")
    found = {run: json.loads((run / "curve.json").read_text(encoding="utf-8"))["settings"] for run in given.runs}
    if len({(one["scenario"], tuple(one["learn"])) for one in found.values()}) > 1 or len(found) < 2:
        raise ConfigError("give two or more runs with equal --scenario and --learn")
    for run, settings in found.items():
        others = [other for other in found if other != run]
        used = settings | {"matches": given.matches, "seed": 0}  # the same matches for all
        curve = curve_of(run, others, Namespace(**used))
        text = json.dumps({"settings": used, "curve": curve}, indent=1)
        write_whole(prepare_folder(given.out / run.name) / "curve.json", text.encode())


if __name__ == "__main__":
    interrupts.run(main)
