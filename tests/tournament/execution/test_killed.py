"""A tournament whose process is killed (SIGKILL) goes on where it was, and ends as if nothing had happened."""

import hashlib
import random
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from catch_arena.tournament.export import export
from catch_arena.tournament.store import STORE, Store

AGENTS = ["nearest", "random", "contested", "crashes.py"]
"""The last one is out after ten matches, which no resumption may forget."""
WORDS = [
    *AGENTS,
    "--scenario",
    "duel",
    "--set",
    "time_limit_s=3",
    "--rounds",
    "20",
    "--seed",
    "0",
    "--record",
    "--resume",
    "--trusted",
]
MATCHES = 240
SERVER = """
import os, signal, sys, time
from catch_arena.cli import main
from catch_arena import parallel_env
from catch_arena.tournament import entrants
from catch_arena.tournament import standings_files
from catch_arena.tournament.plans import schedule
from catch_arena.cli import live_standings, tables
from catch_arena.tournament.execution import runner
from catch_arena.tournament.statistics import standings
from catch_arena.tournament import store
from catch_arena.tournament.execution import worker
parallel_env("duel").reset(seed=0)  # loads what is compiled
print("ready", flush=True)
for line in sys.stdin:
    moment, *words = line.split()
    child = os.fork()
    if not child:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        main(words)
    clock = ~child << 3 | 2  # clock_getcpuclockid(3): a busy machine stretches the time on the wall
    while moment != "never" and time.clock_gettime(clock) < float(moment):
        if os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT):
            break
        time.sleep(0.0002)
    if moment != "never":
        os.kill(child, signal.SIGKILL)
    _, status, usage = os.wait4(child, 0)
    print(os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime, flush=True)
"""


class Server:
    """Runs the command line in fresh processes, forked from one that has imported everything already."""

    def __init__(self, folder: Path):
        self.process = subprocess.Popen(
            [sys.executable, "-c", SERVER], cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert self.process.stdout.readline() == "ready\n"

    def play(self, out: str, killed_after_s: float | None = None) -> tuple[int, float]:
        """Play the tournament, for so much CPU time; its exit code, negative for a signal, and the time it had."""
        moment = "never" if killed_after_s is None else killed_after_s
        words = ["tournament", *WORDS, "--jobs", "1", "--out", out]
        self.process.stdin.write(f"{moment} {' '.join(words)}\n")
        self.process.stdin.flush()
        code, cpu_s = self.process.stdout.readline().split()
        return int(code), float(cpu_s)


@pytest.fixture
def server(tmp_path):
    server = Server(tmp_path)
    yield server
    server.process.stdin.close()
    server.process.wait(timeout=30)
    server.process.stdout.close()


def exported(folder: Path) -> bytes:
    with Store.read(folder) as store:
        export(store, "jsonl", folder / "matches.jsonl", timing=False)
    return (folder / "matches.jsonl").read_bytes()


def kept(folder: Path) -> int:
    """How many matches stand in a store that may not be there yet; each with its replay, and the right one."""
    if not (folder / STORE).exists() or not (folder / STORE).stat().st_size:
        return 0
    with Store.read(folder) as store:
        played = list(store.played())
    for one in played:
        content = (folder / "replays" / f"{one.match.id}.replay").read_bytes()
        assert hashlib.blake2b(content, digest_size=16).hexdigest() == one.replay
    return len(played)


@pytest.mark.parametrize("times", [6, pytest.param(20, marks=pytest.mark.nightly)])
def test_killed_at_random_moments_it_ends_as_if_undisturbed(server, tmp_path, times):
    shutil.copy(Path(__file__).parents[1] / "isolation" / "bad" / "crashes.py", tmp_path)
    code, cpu_s = server.play("undisturbed")
    assert code == 0
    expected = exported(tmp_path / "undisturbed")
    assert expected.count(b"\n") == MATCHES
    assert expected.count(b"FORFEIT_OUT") == MATCHES / 2 - 10

    moments = random.Random(20)
    kills, midway, ended = 0, 0, 0
    while kills < times:
        out, progress = f"killed{ended}", 0
        while server.play(out, moments.uniform(0, cpu_s / 8) if kills < times else None)[0] != 0:
            before, progress = progress, kept(tmp_path / out)
            assert progress >= before
            kills += 1
            midway += 0 < progress < MATCHES
        assert exported(tmp_path / out) == expected
        ended += 1
    assert midway >= times / 4  # the others came before the first match, or after the last


def test_the_processes_of_a_killed_tournament_end_too(tmp_path):
    """Its agents' processes tell their ids, some anew with a match; nobody is left to tell them to end."""
    tells = tmp_path / "tells.py"
    tells.write_text(
        "import os\nfrom pathlib import Path\nclass Agent:\n"
        "    def reset(self, seed): Path(__file__).with_name(f'{os.getpid()}.pid').touch()\n"
        "    def act(self, view): return 0\n"
    )

    def told() -> set[Path]:
        return {Path("/proc", path.stem) for path in tmp_path.glob("*.pid")}

    command = [sys.executable, "-m", "catch_arena", "tournament", "tells.py", "idle"]
    process = subprocess.Popen(
        # in namespaces it could not write there, and would know other numbers
        [*command, "--scenario", "duel", "--rounds", "5000", "--jobs", "2", "--out", "o", "--isolation", "processes"],
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
    )
    patience = time.monotonic() + 60
    while len(told()) < 2 and time.monotonic() < patience:
        time.sleep(0.05)
    process.kill()
    process.wait(timeout=30)
    assert len(told()) >= 2
    patience = time.monotonic() + 60
    while any(one.exists() for one in told()) and time.monotonic() < patience:
        time.sleep(0.05)
    assert not [one for one in told() if one.exists()]
