"""Measure the speed of Catch Arena, beside its peers or beside an older version of its own: `python scripts/bench`.

All subjects take turns in every round, so that a busy machine slows all of them. Rates are per CPU-second of all
threads; numeric libraries get one thread each. Tables go to the screen, and where asked to a JSON file and a page.

With `--against REF` that commit and the current version take turns, each in a process of its own.
"""

import argparse
import importlib.metadata
import json
import os
import platform
import shlex
import sys
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import against
from checkout import CheckoutError, current
from puffer import HEADER

from catch_arena.errors import OutputError
from catch_arena.files import prepare_folder

# before numpy, torch and jax load, which read these once
os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
os.environ |= {
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
    "JAX_PLATFORMS": "cpu",
}

COMMAND = shlex.join(["python", *(Path(one).name if Path(one).is_absolute() else one for one in sys.argv)])
"""As the tables have it: where folders lie on this machine is nobody's business."""
PARTS = {
    "start": "import and first steps, in fresh processes",
    "peers": "other environments beside ours",
    "ours": "one arena, and batches of many sizes",
    "limits": "what a missed target comes up against",
    "phases": "where a step's time goes",
}
MARKS = ("<!-- made by make bench -->", "<!-- made until here -->")
AGAINST_MARKS = ("<!-- made by scripts/bench against a commit -->", "<!-- made against it until here -->")


@dataclass(frozen=True)
class Args:
    """What is measured, and where it goes."""

    only: list[str]
    rounds: int
    seconds: float
    quick: bool
    against: str | None
    pufferlib: Path | None
    json: Path | None
    page: Path | None

    @property
    def marks(self) -> tuple[str, str]:
        """Between which the tables stand in the page."""
        return AGAINST_MARKS if self.against else MARKS


def parse() -> Args:
    """The command line."""
    parser = argparse.ArgumentParser(prog="bench", description=__doc__.splitlines()[0])
    rows = ", ".join(against.ROWS)
    parser.add_argument(
        "--only",
        nargs="+",
        metavar="PART",
        help=f"a part: {', '.join(f'{part} ({what})' for part, what in PARTS.items())}; with --against a row: {rows}; "
        "all of them unless given",
    )
    parser.add_argument("--rounds", type=int, default=10, help="turns of each subject (%(default)s)")
    parser.add_argument("--seconds", type=float, default=0.25, help="CPU-seconds of a turn (%(default)s)")
    parser.add_argument(
        "--quick", action="store_true", help="tiny sizes, to see that it runs; the figures mean nothing"
    )
    parser.add_argument("--against", metavar="REF", help="measure that commit and the current version in turn")
    parser.add_argument("--pufferlib", type=Path, metavar="FOLDER", help="PufferLib's unpacked source package, a peer")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    parser.add_argument("--page", type=Path, help="replace the tables of this page, which stand between two marks")
    args = parser.parse_args()
    choices = against.ROWS if args.against else PARTS
    args.only = args.only or list(choices)
    for part in args.only:
        if part not in choices:
            parser.error(f"argument --only: invalid choice: {part!r} (choose from {', '.join(choices)})")
    args = Args(**vars(args))
    if args.rounds < 1 or not args.seconds > 0:
        parser.error(f"--rounds must be at least 1 and --seconds positive, got {args.rounds} and {args.seconds}")
    if os.environ.get("NUMBA_DISABLE_JIT", "0") != "0" and not (args.against and args.quick):
        parser.error("the benchmark needs compiled code: unset NUMBA_DISABLE_JIT")
    if args.pufferlib and not (args.pufferlib / HEADER).is_file():
        parser.error(f"--pufferlib must be PufferLib's unpacked source package, and {args.pufferlib} has no {HEADER}")
    if args.json:
        try:
            prepare_folder(args.json.parent)
        except OutputError as error:
            parser.error(str(error))
    begin, end = args.marks
    if args.page and not (args.page.is_file() and begin in (text := args.page.read_text()) and end in text):
        parser.error(f"{args.page} must be a page that holds {begin} and {end}")
    return args


def machine() -> str:
    """The processor, how many arenas the core plays in one register of it, and the versions of what the figures depend
    on.
    """
    model = platform.processor() or platform.machine()
    known = Path("/proc/cpuinfo")
    if known.exists():
        names = [line.partition(":")[2].strip() for line in known.read_text().splitlines() if line[:10] == "model name"]
        model = names[0] if names else model
    versions = [f"Python {platform.python_version()}"]
    for package in ("numpy", "numba", "pettingzoo", "mpe2", "magent2", "torch", "vmas", "jax", "jaxmarl", "jumanji"):
        try:
            versions.append(f"{package} {importlib.metadata.version(package)}")
        except importlib.metadata.PackageNotFoundError:
            continue
    from catch_arena.core.vectors import PLAYED  # after what NumPy reads once

    lanes = f"{len(PLAYED)} arenas in a register"
    return f"{model}, {os.cpu_count()} cores, {lanes}, {platform.system()}; {', '.join(versions)}"


def measured_version() -> str:
    """Of what, and when."""
    try:
        version = f"commit {current()}"
    except CheckoutError:
        version = f"version {importlib.metadata.version('catch-arena')}"
    return f"Catch Arena, {version}, on {datetime.now(timezone.utc).date()}"


def beside_a_commit(args: Args) -> tuple[dict[str, Any], str]:
    """The figures of `--against`, and their tables."""
    try:
        figures = against.measure(args.against, args.only, *rounds_of(args), quick=args.quick)
    except (against.UnmeasurableError, CheckoutError) as error:
        sys.exit(f"bench: {error}")
    figures = {"machine": machine(), "command": COMMAND, **figures}
    return figures, against.written(figures)


def rounds_of(args: Args) -> tuple[int, float]:
    """How many there are, and how many CPU-seconds a turn takes."""
    return (2, 0.01) if args.quick else (args.rounds, args.seconds)


def beside_peers(args: Args) -> tuple[dict[str, Any], str]:
    """The figures of all parts, and their tables."""
    import ours
    from limits import limits
    from measure import play_rounds
    from page import written
    from peers import peers
    from phases import phases
    from startup import startup

    figures: dict[str, Any] = {
        "machine": machine(),
        "version": measured_version(),
        "command": COMMAND,
        "skipped": {},
    }
    if "start" in args.only:
        figures["startup"] = startup(quick=args.quick)
    subjects = []
    if {"peers", "ours"} & {*args.only}:
        subjects += ours.reference(quick=args.quick)
    if "peers" in args.only:
        found, figures["skipped"] = peers(quick=args.quick, pufferlib=args.pufferlib)
        subjects += found
    if "ours" in args.only:
        figures["bytes_per_arena"] = ours.bytes_per_arena(quick=args.quick)
        subjects += ours.all_others(quick=args.quick)
    play_rounds(subjects, *rounds_of(args))
    figures["subjects"] = [subject.figures() for subject in subjects]
    if "limits" in args.only:
        figures["limits"] = limits(quick=args.quick)
    if "phases" in args.only:
        figures["phases"] = phases(quick=args.quick)
    return figures, written(figures, subjects)


def main() -> None:
    """Measure what is asked for, and write it down."""
    args = parse()
    try:
        figures, tables = beside_a_commit(args) if args.against else beside_peers(args)
    except KeyboardInterrupt:
        print("bench: interrupted", file=sys.stderr)
        sys.exit(130)
    if args.quick:
        tables = (
            f"Measured with `--quick`: all sizes are tiny, whatever the rows say; the figures mean nothing.\n\n{tables}"
        )
    print(tables)
    if args.json:
        args.json.write_text(json.dumps(figures, indent=2) + "\n")
    if args.page:
        begin, end = args.marks
        text = args.page.read_text()
        args.page.write_text(f"{text.partition(begin)[0]}{begin}\n\n{tables}\n{end}{text.partition(end)[2]}")


if __name__ == "__main__":
    main()
