"""Train for a short time with each supported library, each in its own environment: `make compat`.

A client is a program in examples/. torch is large, so a base environment has it, with Catch Arena; the others use that
one and add their library. docs/reference/compatibility.md gets the table of results, with versions.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from pythons import run

ROOT = Path(__file__).resolve().parents[1]
PROGRAMS = ROOT / "examples"
PAGE = ROOT / "docs" / "reference" / "compatibility.md"
TABLE = re.compile(r"(<!-- made by `make compat` -->\n\n)(.*?)(?=\n\n<!-- end -->)", re.DOTALL)
ENVIRONMENTS = ROOT / "out" / "compat"


class Client(NamedTuple):
    """Program of one library, and its requirements in addition to torch and Catch Arena."""

    program: str
    requirements: tuple[str, ...]
    reported: tuple[str, ...]
    """Packages whose versions are in the table."""
    without_dependencies: tuple[str, ...] = ()
    """Requirements that are installed last, without their dependencies."""
    arguments: tuple[str, ...] = ()


_SB3 = ("stable-baselines3", "sb3-contrib")
CLIENTS = {
    "stable-baselines3": Client("train_sb3", _SB3, _SB3, arguments=("--steps", "8192")),
    "SuperSuit": Client("train_supersuit", (*_SB3, "supersuit>=3.11"), ("supersuit", *_SB3)),
    "TorchRL": Client("train_torchrl", ("torchrl",), ("torchrl", "tensordict")),
    "BenchMARL": Client("train_benchmarl", ("benchmarl",), ("benchmarl", "torch", "torchrl", "tensordict")),
    "RLlib": Client("train_rllib", ("ray[rllib]",), ("ray", "gymnasium")),
    "Tianshou": Client("train_tianshou", ("tianshou",), ("tianshou",)),
    # AgileRL requires an older PettingZoo, but works with ours; it imports peft without requiring it.
    "AgileRL": Client("train_agilerl", ("agilerl", "peft"), ("agilerl", "pettingzoo"), ("pettingzoo>=1.27",)),
    "single file": Client("train_single_file", (), ("torch",)),
    "Gymnasium": Client("train_gymnasium", ("array-api-compat", "packaging"), ("gymnasium",)),  # for its NumpyToTorch
}


def set_up(environment: Path, packages: list[tuple[str, ...]], base: Path | None = None) -> Path | None:
    """Make an environment that has the packages of `base` too, unless it exists; return its Python, or None."""
    python, ready, log = environment / "bin" / "python", environment / "ready", environment.with_suffix(".log")
    wanted = json.dumps(packages)
    log.write_bytes(b"")
    if not (ready.exists() and ready.read_text() == wanted):
        run(log, ROOT, sys.executable, "-m", "venv", "--clear", *(["--without-pip"] if base else []), environment)
        if base:
            part = f"lib/python{sys.version_info.major}.{sys.version_info.minor}/site-packages"
            (environment / part / "base.pth").write_text(f"{base / part}\n{ROOT}\n")
        if not all(run(log, ROOT, python, "-m", "pip", "install", "--quiet", *some) for some in packages):
            return None
        ready.write_text(wanted)
    return python


def versions(python: Path, names: tuple[str, ...]) -> str:
    """Return the names of packages, each with its version, as text."""
    program = "import importlib.metadata as m, sys; print(', '.join(f'{n} {m.version(n)}' for n in sys.argv[1:]))"
    return subprocess.run([python, "-c", program, *names], capture_output=True, text=True, check=True).stdout.strip()


def try_client(name: str, base: Path) -> tuple[str, str]:
    """Set up a client's environment and train; return the result and the versions."""
    client, environment = CLIENTS[name], ENVIRONMENTS / re.sub(r"\W+", "_", name.lower())
    packages = [client.requirements] if client.requirements else []
    packages += [("--no-deps", *client.without_dependencies)] if client.without_dependencies else []
    python = set_up(environment, packages, base)
    if python is None:
        return "could not be installed", ""
    words = (python, PROGRAMS / f"{client.program}.py", *client.arguments)
    with tempfile.TemporaryDirectory() as folder:  # files that clients write are not kept
        trains = run(environment.with_suffix(".log"), Path(folder), *words, PYTHONWARNINGS="ignore", RAY_DEDUP_LOGS="0")
    return "trains" if trains else "fails", versions(python, client.reported)


def page_with(page: str, results: dict[str, tuple[str, str]], common: str) -> str:
    """Return the page with new rows for these clients."""
    rows = {row.split("|")[1].strip(): row for row in re.findall(r"^\| .*$", TABLE.findall(page)[0][1], re.MULTILINE)}
    rows |= {name: f"| {name} | {result} | {found} |" for name, (result, found) in results.items()}
    lines = [f"Each with {common}, unless its row names another.\n", "| client | result | versions |", "|---|---|---|"]
    lines += [rows[name] for name in CLIENTS if name in rows]
    return TABLE.sub(lambda found: found[1] + "\n".join(lines), page)


def main() -> int:
    """Try the clients; return 0 if all of them train, else 1."""
    parser = argparse.ArgumentParser(description=__doc__)
    help_text = f"clients to try, of {', '.join(CLIENTS)}; without names, all"
    parser.add_argument("clients", nargs="*", metavar="CLIENT", help=help_text)
    wanted = parser.parse_args().clients or list(CLIENTS)
    if unknown := set(wanted) - set(CLIENTS):
        parser.error(f"unknown client {', '.join(sorted(unknown))}; the clients are {', '.join(CLIENTS)}")
    ENVIRONMENTS.mkdir(parents=True, exist_ok=True)
    base = ENVIRONMENTS / "base"
    print(f"base environment: {base}", flush=True)
    python = set_up(base, [("torch",), ("--editable", str(ROOT))])
    if python is None:
        return 1
    results = {}
    for name in wanted:
        print(f"{name} ...", flush=True)
        results[name] = try_client(name, base)
        print(f"  {': '.join(results[name])}", flush=True)
    PAGE.write_text(page_with(PAGE.read_text(), results, versions(python, ("pettingzoo", "numpy", "numba", "torch"))))
    return int(any(result != "trains" for result, _ in results.values()))


if __name__ == "__main__":
    sys.exit(main())
