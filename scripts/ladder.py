"""Copy snapshots of training runs to agents/ladder: `python scripts/ladder.py runs/tag_1 --decisions 1000000 20000000`.

The runs are folders that examples/train_sides.py wrote. Each snapshot becomes an agent, with its weights in half
precision. Agents of an earlier run of the same scenario, side and seed are replaced.
"""

import argparse
import json
import re
import sys
from pathlib import Path
from typing import Any, Final

import numpy as np

from catch_arena.errors import CatchArenaError
from catch_arena.files import prepare_folder, whole_file
from catch_arena.training.networks import Mlp
from catch_arena.training.pointer import PointerNetwork

FOLDER: Final = Path(__file__).parent.parent / "agents" / "ladder"
HUNTER: Final = "catch_arena.agents.nearest"
"""Module of the agent that hunts in the files that train_sides.py writes for prey."""


def main() -> int:
    """Copy the snapshots; return the exit code: 0, or 2 after printing the reason in a line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path, help="folders that examples/train_sides.py wrote")
    parser.add_argument(
        "--decisions",
        nargs="*",
        type=int,
        help="ages: of each run, the snapshots nearest to them, by decisions of the hunters; without it the newest one",
    )
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder for the agents")
    args = parser.parse_args()
    try:
        for run in args.runs:
            for name in copy_run(run, args.decisions, prepare_folder(args.out)):
                print(f"ladder.{name}")
    except (CatchArenaError, OSError) as error:
        print(f"ladder: {error}", file=sys.stderr)
        return 2
    kilobytes = sum(path.stat().st_size for path in args.out.glob("*.npz")) / 1000
    print(f"{args.out}: weights of {kilobytes:.0f} kB")
    return 0


def copy_run(run: Path, wanted: list[int] | None, out: Path) -> list[str]:
    """Copy snapshots of a run; return the names of the agents.

    Args:
        run: folder of the run.
        wanted: ages of the snapshots, in decisions; None for the newest one.
        out: folder for the agents.

    Raises:
        ConfigError: for a snapshot that is of another ruleset.
        OSError: for a folder without a run.
    """
    settings = json.loads((run / "curve.json").read_text())["settings"]
    scenario, seed = settings["scenario"], settings["seed"]
    sides = sorted(settings["learn"], key=lambda side: side == "prey")
    made = [snapshots(run, side) for side in sides]  # at each evaluation there is one of each side
    ages = np.array(made[0][: len(made[-1])])  # a run that was killed may lack the last one of its second side
    kept = sorted({int(np.abs(ages - age).argmin()) for age in (ages[-1:] if wanted is None else wanted)})
    names: dict[tuple[str, int], str] = {}
    for side, own in zip(sides, made, strict=True):
        for path in out.glob(f"{scenario}_{side}_{seed}_*"):
            path.unlink()
        for place in kept:
            name = names[side, place] = f"{scenario}_{side}_{seed}_{round(own[place] / 1000)}k"
            snapshot = run / "snapshots" / f"{side}_{own[place]}.npz"
            copy_weights(snapshot, out / f"{name}.npz", pointer=settings["network"] == "pointer" and side != "prey")
            code = snapshot.with_suffix(".py").read_text().partition("\n")[2]
            if side != sides[0]:
                code = code.replace(HUNTER, f"catch_arena.agents.ladder.{names[sides[0], place]}")
            words = f"Frozen {side} of `{scenario}` after {own[place]:,} decisions; training seed {seed}."
            (out / f"{name}.py").write_text(f'"""{words}"""\n{code}')
    return list(names.values())


def snapshots(run: Path, side: str) -> list[int]:
    """Return the numbers of decisions of a side's snapshots, lowest first."""
    found = (re.fullmatch(rf"{side}_(\d+)", path.stem) for path in (run / "snapshots").glob("*.npz"))
    return sorted(int(one[1]) for one in found if one)


def copy_weights(source: Path, target: Path, *, pointer: bool) -> None:
    """Write a network's weights again, in half precision.

    Raises:
        ConfigError: for a file that cannot be read, and for weights that half precision cannot hold.
    """
    load = PointerNetwork.load if pointer else Mlp.load
    load(source)
    with np.load(source) as file, np.errstate(over="ignore"):
        tables: dict[str, Any] = {
            name: table.astype(np.float16) if table.dtype == np.float32 else table for name, table in file.items()
        }
    with whole_file(target) as written:
        np.savez_compressed(written, **tables)
    load(target)


if __name__ == "__main__":
    sys.exit(main())
