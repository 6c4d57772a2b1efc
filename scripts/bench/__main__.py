"""Measure the speed of Catch Arena, next to other environments or to an older commit: `python scripts/bench`.

Each version has its own process, and so have the peers. In every round each process plays one short turn of each row,
so that other load on the machine affects all alike. Times are CPU time of all threads and processes; numeric libraries
get one thread each. Tables go to the screen, and with options to a JSON file and a page.
"""

from catch_arena import interrupts

if __name__ == "__main__":
    interrupts.listen()  # before the imports below

import argparse
import json
import os
import shlex
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import BrokenExecutor
from contextlib import ExitStack
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import ours
import peers
from machine import machine
from side import Side
from tables import written
from versions import ROOT, UnmeasurableError, check_out, current

from catch_arena.cli.terminal import progress_bar

COMMAND = shlex.join(["python", *(Path(one).name if Path(one).is_absolute() else one for one in sys.argv)])
"""Command line for the page, without the folders of this machine."""
BEGIN, END = "<!-- made by make bench -->", "<!-- made until here -->"
"""Marks of the page between which the tables stand."""


def parse() -> argparse.Namespace:
    """Read the command line."""
    groups = ["peers", *dict.fromkeys(row.group for row in ours.rows().values())]
    parser = argparse.ArgumentParser(prog="bench", description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--only", nargs="+", choices=groups, metavar="ROWS", help=f"some of {', '.join(groups)}; without it, all")
    add("--rounds", type=int, default=10, help="turns of each row (%(default)s)")
    add("--seconds", type=float, default=0.25, help="CPU-seconds of a turn (%(default)s)")
    add("--against", metavar="REF", help="measure that commit and the current version in turn, and no peers")
    add("--pufferlib", type=Path, metavar="FOLDER", help="PufferLib's unpacked source package, a peer")
    add("--json", type=Path, metavar="FILE", help="write the figures to this file")
    add("--page", type=Path, metavar="FILE", help="replace the tables of this page")
    args = parser.parse_args()
    args.only = args.only or groups[bool(args.against) :]
    if args.against and ("peers" in args.only or args.page):
        parser.error("--against measures no peers and writes no page; leave out --only peers and --page")
    if args.rounds < 1 or not args.seconds > 0:
        parser.error(f"--rounds must be at least 1 and --seconds positive, got {args.rounds} and {args.seconds}")
    if os.environ.get("NUMBA_DISABLE_JIT", "0") != "0":
        parser.error("the benchmark needs compiled code: unset NUMBA_DISABLE_JIT")
    if args.page and not (args.page.is_file() and BEGIN in (text := args.page.read_text()) and END in text):
        parser.error(f"--page must be a page that has the marks {BEGIN} and {END}, got {args.page}")
    if args.json:
        args.json.parent.mkdir(parents=True, exist_ok=True)
    return args


def measure(args: argparse.Namespace) -> dict[str, Any]:
    """Measure the chosen rows, and return all figures.

    Raises:
        UnmeasurableError: nothing can be measured.
    """
    compared = {ours.ONE_ARENA, ours.BATCH, ours.LARGE} if "peers" in args.only else set()
    own = {name: row for name, row in ours.rows().items() if row.group in args.only or name in compared}
    versions = f"Catch Arena, {current()}, on {datetime.now(timezone.utc).date()}"
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="bench-")))
        sides = {}
        if args.against:
            commit = check_out(args.against, folder / "older")
            sides["before"] = Side(f"{args.against} ({commit[:12]})", folder / "older", folder / "before", own)
            versions = f"Before: the commit {commit[:12]}. Now: {versions}"
        sides["now"] = Side("the current version", ROOT, folder / "now", own)
        if "peers" in args.only:
            sides["peers"] = Side("it", None, folder / "peers", peers.rows(args.pufferlib))
        for side in sides.values():
            stack.callback(side.end)
        skipped = play(list(sides.values()), args.rounds, args.seconds)
    if not any(side.figures for side in sides.values()):
        raise UnmeasurableError(next(iter(skipped.values())))
    return {
        "machine": machine(),
        "what": versions,
        "command": COMMAND,
        "rounds": f"Medians of {args.rounds} rounds, in turn",
        "skipped": skipped,
        "versions": {name: side.figures for name, side in sides.items()},
    }


def play(sides: Sequence[Side], rounds: int, seconds: float) -> dict[str, str]:
    """Play all rounds of all rows, and return the rows that could not be made, each with the reason."""
    names = list(dict.fromkeys(name for side in sides for name in side.rows))
    skipped: dict[str, str] = {}
    print("compiling", file=sys.stderr)
    with progress_bar("measuring", total := (1 + rounds) * len(names)) as show:
        for done, name in enumerate(names):
            # at the same time, since compiling takes long
            begun = [(side, side.make(name, seconds)) for side in sides if name in side.rows]
            for side, sizes in begun:
                try:
                    side.figures[name] = {"unit": side.rows[name].unit, **sizes.result(), "cpu": [], "wall": []}
                except (UnmeasurableError, BrokenExecutor) as error:
                    skipped[name] = str(error)
            show(done + 1, total)
        for side in sides:
            side.figures = {name: row for name, row in side.figures.items() if name not in skipped}
        for number in range(rounds):
            for done, name in enumerate(names):
                sharing = [side for side in sides if name in side.figures]
                for side in sharing if number % 2 == 0 else reversed(sharing):
                    side.play(name, seconds)
                show((1 + number) * len(names) + done + 1, total)
    return skipped


def main() -> None:
    """Measure the chosen rows, and write the results."""
    args = parse()
    try:
        figures = measure(args)
    except (UnmeasurableError, BrokenExecutor) as error:
        sys.exit(f"bench: {error}")
    text = written(figures)
    print(text)
    if args.json:
        args.json.write_text(json.dumps(figures, indent=2) + "\n")
    if args.page:
        page = args.page.read_text()
        args.page.write_text(f"{page.partition(BEGIN)[0]}{BEGIN}\n\n{text}\n{END}{page.partition(END)[2]}")


if __name__ == "__main__":
    interrupts.run(main)
