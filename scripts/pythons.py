"""Try each CPython version of pyproject.toml, with the newest and with the oldest allowed dependencies.

Each gets a new environment in out/pythons, with the wheel (newest) or an editable install (oldest). There it plays a
match, renders it, holds a tournament and runs the tests of the rules, with `--ends` only those of its bits. Versions
that are not installed are printed.
"""

import argparse
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from catch_arena.files import tomllib

ROOT = Path(__file__).parents[1]
OUT = ROOT / "out" / "pythons"
UV = Path(sys.executable).with_name("uv")
BITS = ("golden", "oracle")
"""Tests that every Python plays the same matches."""
RULES = (*BITS, "properties", "rulebook", "unit")
COMMANDS = (
    "match nearest idle --scenario duel --seed 7 -o match.replay",
    "verify match.replay",
    "render match.replay -o match.mp4 --size 320x320 --fps 15",
    "tournament nearest first --scenario duel --rounds 2 --seed 7 --out results",
)


def promised_versions() -> list[str]:
    """Return the minor versions in the classifiers of pyproject.toml, such as "3.10"."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    versions = [line.rpartition(" ")[2] for line in project["classifiers"] if line.startswith("Programming Language")]
    return [version for version in versions if version.startswith("3.")]


def find_python(version: str) -> Path | None:
    """Return the interpreter of a minor version: on PATH, or pyenv's newest; None if there is none."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    candidates = [shutil.which(f"python{version}"), *sorted(pyenv.glob(f"{version}.*/bin/python"), reverse=True)]
    for candidate in filter(None, candidates):
        command = [candidate, "-c", "import sys, venv; print(*sys.version_info[:2], sep='.')"]
        found = subprocess.run(command, capture_output=True, text=True, check=False)
        if found.stdout.strip() == version:
            return Path(candidate)
    return None


def run(log: Path, folder: Path, *command: str | Path, **variables: str) -> bool:
    """Run a command in a folder, with a log; return whether it succeeds, and print the end of the log if it fails.

    `variables` are added to the environment.
    """
    with log.open("a", encoding="utf-8") as file:
        print("$", *command, file=file, flush=True)
        options = {"stdout": file, "stderr": file, "env": os.environ | variables}
        code = subprocess.run(command, cwd=folder, check=False, **options).returncode
    if code:
        print(f"  failed: {' '.join(map(str, command))} ({log})")
        lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
        print("\n".join(f"    {line}" for line in lines[-30:]), flush=True)
    return code == 0


def try_python(python: Path, wheel: Path, version: str, names: Sequence[str], *, newest: bool) -> bool:
    """Install into a fresh environment, play, render and test; return True if everything passed."""
    began = time.monotonic()
    folder = OUT / f"{version}-{'newest' if newest else 'oldest'}"
    log, environment, played = OUT / f"{folder.name}.log", folder / "venv", folder / "played"
    played.mkdir(parents=True)
    install = [UV, "pip", "install", "--python", environment / "bin" / "python"]
    install += ["--group", f"{ROOT}/pyproject.toml:test"]
    install += [f"{wheel}[video]"] if newest else ["--resolution", "lowest-direct", "--editable", f"{ROOT}[video]"]
    tests = (environment / "bin" / "pytest", "-q", "-n", "2", "-p", "no:cacheprovider", "-m", "not nightly")
    cache = {"NUMBA_CACHE_DIR": str(folder / "compiled")}
    passed = (
        run(log, OUT, UV, "venv", "--python", python, environment)
        and run(log, OUT, *install)
        and all(run(log, played, environment / "bin" / "catch-arena", *line.split(), **cache) for line in COMMANDS)
        and run(log, ROOT, *tests, *(f"tests/{name}" for name in names), **cache)
    )
    print(f"{folder.name}: {'passed' if passed else 'failed'} ({time.monotonic() - began:.0f} s)", flush=True)
    return passed


def main() -> int:
    """Try every version found, or with `--ends` the two that differ most; return 1 if one fails."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--ends",
        action="store_true",
        help="try only the lowest version with the oldest dependencies, and the highest with the newest",
    )
    ends = parser.parse_args().ends
    found = {version: python for version in promised_versions() if (python := find_python(version))}
    print("found:", *found, "| not found:", *(set(promised_versions()) - set(found) or ["none"]), flush=True)
    shutil.rmtree(OUT, ignore_errors=True)
    shutil.rmtree(ROOT / "build", ignore_errors=True)  # setuptools would pack the files of an earlier build
    OUT.mkdir(parents=True)
    if not run(OUT / "wheel.log", ROOT, UV, "build", "--wheel", "--out-dir", OUT, ROOT):
        return 1
    (wheel,) = OUT.glob("*.whl")
    versions = list(found)
    if ends:
        tries = [(versions[0], False), (versions[-1], True)]
    else:
        tries = [(version, newest) for version in versions for newest in (True, False)]
    names = BITS if ends else RULES
    results = [try_python(found[version], wheel, version, names, newest=newest) for version, newest in tries]
    return int(not all(results))


if __name__ == "__main__":
    sys.exit(main())
