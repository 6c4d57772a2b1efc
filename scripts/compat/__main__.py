"""Train for a short time with each supported library, each in its own environment: `make compat`.

A client is a program in examples/. torch is large, so a base environment has it, with Catch Arena; the others use that
one and add their library. docs/compatibility.md gets the table of results, with versions.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = ROOT / "examples"
PAGE = ROOT / "docs" / "compatibility.md"
LIMIT_S = 900
"""Time limit of one client's program on a busy machine [s]."""


class Client(NamedTuple):
    """Program of one library, and its requirements besides torch and Catch Arena."""

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


def run(command: list[object], log: Path, limit_s: float = 3600, folder: str | None = None) -> int:
    """Run a command with its output in a file; return its exit code."""
    environment = {**os.environ, "PYTHONWARNINGS": "ignore", "RAY_DEDUP_LOGS": "0"}
    with log.open("ab") as output:
        try:
            words = [str(word) for word in command]
            options = {"stdout": output, "stderr": output, "env": environment, "cwd": folder, "timeout": limit_s}
            return subprocess.run(words, check=False, **options).returncode
        except subprocess.TimeoutExpired:
            output.write(f"\nended after {limit_s:.0f} s, the time limit\n".encode())
            return 1


def packages_of(environment: Path) -> Path:
    """Return the folder of an environment's packages."""
    return environment / "lib" / f"python{sys.version_info.major}.{sys.version_info.minor}" / "site-packages"


def set_up(environment: Path, packages: list[tuple[str, ...]], base: Path | None, log: Path) -> bool:
    """Make an environment, unless it exists with the same packages; return whether it is ready."""
    wanted, ready = json.dumps(packages), environment / "ready"
    if ready.exists() and ready.read_text() == wanted:
        return True
    python = base or Path(sys.executable)
    if run([python, "-m", "venv", *(["--without-pip"] if base else []), environment], log):
        return False
    if base is not None:
        (packages_of(environment) / "base.pth").write_text(f"{packages_of(base.parent.parent)}\n{ROOT}\n")
    for some in packages:
        if some and run([environment / "bin" / "python", "-m", "pip", "install", "--quiet", *some], log):
            return False
    ready.write_text(wanted)
    return True


def versions(environment: Path, names: tuple[str, ...]) -> dict[str, str]:
    """Return the installed versions of packages by name; empty if one is missing."""
    program = "import importlib.metadata as m, json, sys; print(json.dumps({n: m.version(n) for n in sys.argv[1:]}))"
    command = [environment / "bin" / "python", "-c", program, *names]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    return json.loads(done.stdout) if done.returncode == 0 else {}


def try_client(name: str, environments: Path, base: Path) -> dict[str, Any]:
    """Set up a client's environment and train; return its name, result, log, and if it ran, time [s] and versions."""
    client, environment = CLIENTS[name], environments / re.sub(r"\W+", "_", name.lower())
    log = environment.with_suffix(".log")
    log.write_bytes(b"")
    alone = ("--no-deps", *client.without_dependencies) if client.without_dependencies else ()
    if not set_up(environment, [client.requirements, alone], base, log):
        return {"name": name, "result": "could not be installed", "log": str(log)}
    began = time.monotonic()
    command = [environment / "bin" / "python", PROGRAMS / f"{client.program}.py", *client.arguments]
    with tempfile.TemporaryDirectory() as folder:  # files that clients write are not kept
        failed = run(command, log, LIMIT_S, folder)
    return {
        "name": name,
        "result": "fails" if failed else "trains",
        "seconds": round(time.monotonic() - began),
        "versions": versions(environment, client.reported),
        "log": str(log),
    }


def page_with(page: str, results: list[dict[str, Any]], common: dict[str, str]) -> str:
    """Return the page with new rows for these clients."""
    begin, end = "<!-- made by `make compat` -->", "<!-- end -->"
    head, _, rest = page.partition(begin)
    table, _, tail = rest.partition(end)
    rows = {row.split("|")[1].strip(): row for row in table.splitlines() if row.startswith("| ")}
    for result in results:
        found = ", ".join(f"{name} {version}" for name, version in result.get("versions", {}).items())
        rows[result["name"]] = f"| {result['name']} | {result['result']} | {found} |"
    known = "\n".join(rows[name] for name in CLIENTS if name in rows)
    both = ", ".join(f"{name} {version}" for name, version in common.items())
    text = f"Each with {both}, unless its row names another.\n\n| client | result | versions |\n|---|---|---|\n{known}"
    return f"{head}{begin}\n\n{text}\n\n{end}{tail}"


def main() -> int:
    """Try the clients; return 0 if all of them train, else 1."""
    parser = argparse.ArgumentParser(prog="python scripts/compat", description=__doc__)
    parser.add_argument(
        "clients", nargs="*", metavar="CLIENT", help=f"clients to try, of {', '.join(CLIENTS)}; without names, all"
    )
    parser.add_argument(
        "--environments", type=Path, default=ROOT / "out" / "compat", help="folder for the environments"
    )
    parser.add_argument("--torch", default="torch", help="requirement for torch, such as torch==2.13.0")
    parser.add_argument("--page", action="store_true", help="write the results into docs/compatibility.md")
    given = parser.parse_args()
    unknown = set(given.clients) - set(CLIENTS)
    if unknown:
        parser.error(f"unknown client {', '.join(sorted(unknown))}; the clients are {', '.join(CLIENTS)}")
    environments = given.environments.resolve()
    environments.mkdir(parents=True, exist_ok=True)
    base, log = environments / "base", environments / "base.log"
    print(f"base environment: {base}", flush=True)
    if not set_up(base, [(given.torch,), ("--editable", str(ROOT))], None, log):
        print(f"the base environment could not be made; see {log}")
        return 1
    results = []
    for name in given.clients or CLIENTS:
        print(f"{name} ...", flush=True)
        result = try_client(name, environments, base / "bin" / "python")
        results.append(result)
        found = ", ".join(f"{package} {version}" for package, version in result.get("versions", {}).items())
        print(f"  {result['result']} ({result.get('seconds', 0)} s): {found or result['log']}", flush=True)
        if result["result"] != "trains":
            print("  " + "\n  ".join(Path(result["log"]).read_text(errors="replace").splitlines()[-12:]), flush=True)
    common = versions(base, ("pettingzoo", "numpy", "numba", "torch"))
    if given.page:
        PAGE.write_text(page_with(PAGE.read_text(), results, common))
    return int(any(result["result"] != "trains" for result in results))


if __name__ == "__main__":
    sys.exit(main())
