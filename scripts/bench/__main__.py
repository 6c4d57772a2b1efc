"""Measure the speed of Catch Arena, next to other environments or to an older commit: `python scripts/bench`.

Each version has its own process, and so have the peers. In every round each process plays one short turn of each row,
so that other load on the machine affects all alike. Times are CPU time of all threads and processes; numeric libraries
get one thread each. Tables go to the screen, and with options to a JSON file and a page.
"""

import argparse
import importlib.metadata
import json
import os
import platform
import shlex
import signal
import sys
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import ours
import peers
from subject import Row
from tables import written
from versions import ROOT, UnmeasurableError, Version, checked_out, commit_of, current

from catch_arena.cli.progress import progress_bar
from catch_arena.errors import OutputError
from catch_arena.files import prepare_folder

COMMAND = shlex.join(["python", *(Path(one).name if Path(one).is_absolute() else one for one in sys.argv)])
"""Command line for the page, without the folders of this machine."""
MARKS = ("<!-- made by make bench -->", "<!-- made until here -->")
AGAINST_MARKS = ("<!-- made by scripts/bench against a commit -->", "<!-- made against it until here -->")


def parse() -> argparse.Namespace:
    """Read the command line."""
    groups = list(dict.fromkeys(row.group for row in ours.rows(quick=False).values()))
    parser = argparse.ArgumentParser(prog="bench", description=__doc__.splitlines()[0])
    parser.add_argument(
        "--only", nargs="+", metavar="ROWS", help=f"of {', '.join(groups)}, and without --against peers; by default all"
    )
    parser.add_argument("--rounds", type=int, default=10, help="turns of each row (%(default)s)")
    parser.add_argument("--seconds", type=float, default=0.25, help="CPU-seconds of a turn (%(default)s)")
    parser.add_argument(
        "--quick", action="store_true", help="tiny sizes, to see that it runs; the figures mean nothing"
    )
    parser.add_argument("--against", metavar="REF", help="measure that commit and the current version in turn")
    parser.add_argument("--pufferlib", type=Path, metavar="FOLDER", help="PufferLib's unpacked source package, a peer")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    parser.add_argument("--page", type=Path, help="replace the tables of this page, which stand between two marks")
    args = parser.parse_args()
    choices = groups if args.against else ["peers", *groups]
    args.only = args.only or choices
    for one in args.only:
        if one not in choices:
            parser.error(f"argument --only: invalid choice: {one!r} (choose from {', '.join(choices)})")
    if args.rounds < 1 or not args.seconds > 0:
        parser.error(f"--rounds must be at least 1 and --seconds positive, got {args.rounds} and {args.seconds}")
    if os.environ.get("NUMBA_DISABLE_JIT", "0") != "0" and not args.quick:
        parser.error("the benchmark needs compiled code: unset NUMBA_DISABLE_JIT")
    if args.pufferlib and not (args.pufferlib / peers.HEADER).is_file():
        parser.error(f"--pufferlib must be PufferLib's source package, and {args.pufferlib} has no {peers.HEADER}")
    if args.json:
        try:
            prepare_folder(args.json.parent)
        except OutputError as error:
            parser.error(str(error))
    args.marks = AGAINST_MARKS if args.against else MARKS
    begin, end = args.marks
    if args.page and not (args.page.is_file() and begin in (text := args.page.read_text()) and end in text):
        parser.error(f"{args.page} must be a page that holds {begin} and {end}")
    if args.quick:
        args.rounds, args.seconds = 2, 0.01
    return args


def measure(args: argparse.Namespace) -> dict[str, Any]:
    """Measure the chosen rows, and return all figures.

    Raises:
        UnmeasurableError: nothing can be measured.
        KeyboardInterrupt: on Ctrl-C or SIGTERM. Processes and temporary folders are removed in any case.
    """
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    own = {name: row for name, row in ours.rows(quick=args.quick).items() if row.group in args.only}
    with ExitStack() as stack:
        try:
            work = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="bench-")))
            chosen: dict[str, tuple[Version, dict[str, Row]]] = {}
            what = measured_version()
            if args.against:
                commit = commit_of(args.against)
                stack.enter_context(checked_out(commit, work / "older"))
                older = Version(f"{args.against} ({commit[:12]})", work / "older", work / "before")
                chosen["before"] = (older, own)
                what = f"Before: the commit {commit[:12]}. Now: {what}"
            else:
                # our rows that are compared with the peers
                names = {ours.ONE_ARENA, ours.BATCH, ours.LARGE} if "peers" in args.only else set()
                own |= {name: row for name, row in ours.rows(quick=args.quick).items() if name in names}
            chosen["now"] = (Version("the current version", ROOT, work / "now"), own)
            if "peers" in args.only:
                others = peers.rows(quick=args.quick, pufferlib=args.pufferlib)
                chosen["peers"] = (Version("it", None, work / "peers"), others)
            for version, _ in chosen.values():
                stack.enter_context(version.running(quick=args.quick, pufferlib=args.pufferlib))
            skipped = play(list(chosen.values()), args.rounds, args.seconds)
        finally:
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, signal.SIG_IGN)  # a second Ctrl-C would prevent the removal of the checkout
    if not any(version.rows for version, _ in chosen.values()):
        raise UnmeasurableError(next(iter(skipped.values())))
    return {
        "machine": machine(),
        "what": what,
        "command": COMMAND,
        "rounds": f"Medians of {args.rounds} rounds, in turn",
        "skipped": skipped,
        "versions": {name: version.rows for name, (version, _) in chosen.items()},
    }


def play(chosen: Sequence[tuple[Version, Mapping[str, Row]]], rounds: int, seconds: float) -> dict[str, str]:
    """Play all rounds of all rows, and return the rows that could not be made, each with the reason."""
    names = list(dict.fromkeys(name for _, rows in chosen for name in rows))
    skipped: dict[str, str] = {}
    print("compiling", file=sys.stderr)
    with progress_bar("measuring", total := (1 + rounds) * len(names)) as show:
        for done, name in enumerate(names):
            sides = [(version, rows[name]) for version, rows in chosen if name in rows]
            for version, _ in sides:  # at the same time, since compiling takes long
                version.ask("make", name, seconds)
            for version, row in sides:
                try:
                    version.rows[name] = {"unit": row.unit, **version.answer(), "cpu": [], "wall": []}
                except UnmeasurableError as error:
                    skipped[name] = str(error)
            show(done + 1, total)
        for version, _ in chosen:
            version.rows = {name: row for name, row in version.rows.items() if name not in skipped}
        for number in range(rounds):
            for done, name in enumerate(names):
                sides = [version for version, _ in chosen if name in version.rows]
                for version in sides if number % 2 == 0 else reversed(sides):
                    version.play(name, seconds)
                show((1 + number) * len(names) + done + 1, total)
    return skipped


def machine() -> str:
    """Return the processor, the number of arenas in one of its registers, and the versions that affect the results."""
    model = platform.processor() or platform.machine()
    known = Path("/proc/cpuinfo")
    if known.exists():
        names = [line.partition(":")[2].strip() for line in known.read_text().splitlines() if line[:10] == "model name"]
        model = names[0] if names else model
    versions = [f"Python {platform.python_version()}"]
    for package in ("numpy", "numba", "pettingzoo", "mpe2", "torch", "vmas", "jax", "jaxmarl"):
        try:
            versions.append(f"{package} {importlib.metadata.version(package)}")
        except importlib.metadata.PackageNotFoundError:
            continue
    from catch_arena.core.vectors import PLAYED  # not part of what an older commit must have

    lanes = f"{len(PLAYED)} arenas in a register"
    return f"{model}, {os.cpu_count()} cores, {lanes}, {platform.system()}; {', '.join(versions)}"


def measured_version() -> str:
    """Return the current version and the date."""
    try:
        version = f"commit {current()}"
    except UnmeasurableError:
        version = f"version {importlib.metadata.version('catch-arena')}"
    return f"Catch Arena, {version}, on {datetime.now(timezone.utc).date()}"


def main() -> None:
    """Measure the chosen rows, and write the results."""
    args = parse()
    try:
        figures = measure(args)
    except UnmeasurableError as error:
        sys.exit(f"bench: {error}")
    except KeyboardInterrupt:
        print("bench: interrupted", file=sys.stderr)
        sys.exit(130)
    text = written(figures)
    if args.quick:
        text = (
            f"Measured with `--quick`: all sizes are tiny, whatever the rows say; the figures mean nothing.\n\n{text}"
        )
    print(text)
    if args.json:
        args.json.write_text(json.dumps(figures, indent=2) + "\n")
    if args.page:
        begin, end = args.marks
        page = args.page.read_text()
        args.page.write_text(f"{page.partition(begin)[0]}{begin}\n\n{text}\n{end}{page.partition(end)[2]}")


if __name__ == "__main__":
    main()
