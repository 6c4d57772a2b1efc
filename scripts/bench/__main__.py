"""Measure the speed of Catch Arena beside its peers, in one run on one machine: `python scripts/bench`.

All subjects take turns in every round, so that a busy machine slows all of them. Rates are per CPU-second of all
threads; numeric libraries get one thread each. Tables go to the screen, and where asked to a JSON file and a page.
"""

import argparse
import importlib.metadata
import json
import os
import platform
import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

# before numpy, torch and jax load, which read these once
os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
os.environ |= {
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
    "JAX_PLATFORMS": "cpu",
}

PARTS = ("start", "peers", "ours", "phases")
BEGIN, END = "<!-- made by make bench -->", "<!-- made until here -->"


@dataclass(frozen=True)
class Args:
    """What is measured, and where it goes."""

    only: list[str]
    rounds: int
    seconds: float
    quick: bool
    json: Path | None
    page: Path | None


def parse() -> Args:
    """The command line."""
    parser = argparse.ArgumentParser(prog="bench", description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS), help="these parts of the benchmark")
    parser.add_argument("--rounds", type=int, default=7, help="turns of each subject")
    parser.add_argument("--seconds", type=float, default=0.5, help="CPU-seconds of a turn")
    parser.add_argument(
        "--quick", action="store_true", help="tiny sizes, to see that it runs; the figures mean nothing"
    )
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    parser.add_argument("--page", type=Path, help="replace the tables of this page, which stand between two marks")
    args = Args(**vars(parser.parse_args()))
    if args.rounds < 1 or not args.seconds > 0:
        parser.error(f"--rounds must be at least 1 and --seconds positive, got {args.rounds} and {args.seconds}")
    if os.environ.get("NUMBA_DISABLE_JIT", "0") != "0":
        parser.error("the benchmark needs compiled code: unset NUMBA_DISABLE_JIT")
    for path in (args.json, args.page):
        if path is not None and not path.parent.is_dir():
            parser.error(f"{path.parent} must be a folder")
    if args.page and not (args.page.is_file() and BEGIN in (text := args.page.read_text()) and END in text):
        parser.error(f"{args.page} must be a page that holds {BEGIN} and {END}")
    return args


def machine() -> str:
    """The processor, and the versions of what the figures depend on."""
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
    return f"{model}, {os.cpu_count()} cores, {platform.system()}; {', '.join(versions)}"


def main() -> None:
    """Measure what is asked for, and write it down."""
    args = parse()
    import ours
    from measure import play_rounds
    from page import written
    from peers import peers
    from phases import phases
    from startup import startup

    figures: dict[str, Any] = {"machine": machine(), "command": shlex.join(["python", *sys.argv]), "skipped": {}}
    if "start" in args.only:
        figures["startup"] = startup(quick=args.quick)
    subjects = []
    if {"peers", "ours"} & {*args.only}:
        subjects += ours.reference(quick=args.quick)
    if "peers" in args.only:
        found, figures["skipped"] = peers(quick=args.quick)
        subjects += found
    if "ours" in args.only:
        figures["bytes_per_arena"] = ours.bytes_per_arena(quick=args.quick)
        subjects += ours.all_others(quick=args.quick)
    rounds, seconds = (2, 0.01) if args.quick else (args.rounds, args.seconds)
    play_rounds(subjects, rounds, seconds)
    figures["subjects"] = [subject.figures() for subject in subjects]
    if "phases" in args.only:
        figures["phases"] = phases(quick=args.quick)
    tables = written(figures, subjects)
    print(tables)
    if args.json:
        args.json.write_text(json.dumps(figures, indent=2) + "\n")
    if args.page:
        text = args.page.read_text()
        args.page.write_text(f"{text.partition(BEGIN)[0]}{BEGIN}\n\n{tables}\n{END}{text.partition(END)[2]}")


if __name__ == "__main__":
    main()
