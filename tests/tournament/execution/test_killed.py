"""A tournament whose process is killed (SIGKILL) goes on where it was, and ends as if nothing had happened."""

import hashlib
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from catch_arena.errors import StoreError
from catch_arena.tournament.export import export
from catch_arena.tournament.store import Store

AGENTS = ["nearest", "random", "contested", "crashes.py"]
"""The last one is out after ten matches, which no resumption may forget."""
WORDS = [
    *AGENTS,
    "--scenario",
    "duel",
    "--set",
    "time_limit_s=3",
    "--rounds",
    "6",
    "--seed",
    "0",
    "--record",
    "--resume",
    "--trusted",
]
MATCHES = 72
SERVER = """
import os, signal, sys
from itertools import count
from pathlib import Path
from catch_arena.cli import main
from catch_arena import parallel_env
from catch_arena.tournament import entrants
from catch_arena.tournament import standings_files
from catch_arena.tournament.plans import schedule
from catch_arena.cli import live_standings, tables
from catch_arena.tournament.execution import runner
from catch_arena.tournament.statistics import standings
from catch_arena.tournament.store import Store
from catch_arena.tournament.execution import worker

def kill_at(place, name, number, when):
    owner, calls = {"Store": Store, "Path": Path}[place], count(1)
    function = getattr(owner, name)
    def counted(*arguments, **options):
        last = next(calls) == number
        if last and when == "before":
            os.kill(os.getpid(), signal.SIGKILL)
        result = function(*arguments, **options)
        if last:
            os.kill(os.getpid(), signal.SIGKILL)
        return result
    setattr(owner, name, counted)

parallel_env("duel").reset(seed=0)  # loads what is compiled
print("ready", flush=True)
for line in sys.stdin:
    place, name, number, when, *words = line.split()
    child = os.fork()
    if not child:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        if place != "never":
            kill_at(place, name, int(number), when)
        main(words)
    _, status = os.waitpid(child, 0)
    print(os.waitstatus_to_exitcode(status), flush=True)
"""
NEVER = "never - 0 -"
KILLS = (
    ("Store transaction 1 after", 0),
    ("Store plan 1 after", 0),
    ("Store keep 5 after", 10),
    ("Store _keep 3 after", 12),
    ("Path replace 4 before", 14),
    ("Path replace 1 after", 14),
    ("Store keep 9 before", 30),
    ("Store end 1 before", 72),
    ("Store end 1 after", 72),
    ("Path replace 1 before", 72),
)
"""At which call of which function a tournament is killed, and how many matches are in its store then.

A block has two matches, so the third `_keep` is in the middle of a transaction. `Path.replace` ends each replay: the
fourth that is not called leaves half of a block's replays, and a temporary file.
"""


class Server:
    """Runs the command line in fresh processes, forked from one that has imported everything already."""

    def __init__(self, folder: Path):
        self.process = subprocess.Popen(
            [sys.executable, "-c", SERVER], cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert self.process.stdout.readline() == "ready\n"

    def play(self, out: str, kill: str = NEVER) -> int:
        """Play the tournament; its exit code, negative for a signal."""
        words = ["tournament", *WORDS, "--jobs", "1", "--out", out]
        self.process.stdin.write(f"{kill} {' '.join(words)}\n")
        self.process.stdin.flush()
        return int(self.process.stdout.readline())


@pytest.fixture
def server(tmp_path):
    server = Server(tmp_path)
    yield server
    server.process.stdin.close()
    server.process.wait()
    server.process.stdout.close()


def exported(folder: Path) -> bytes:
    with Store.read(folder) as store:
        export(store, "jsonl", folder / "matches.jsonl", timing=False)
    return (folder / "matches.jsonl").read_bytes()


def kept(folder: Path) -> int:
    """Return how many matches stand in a store that may be empty; each has its replay, and the right one."""
    try:
        with Store.read(folder) as store:
            played = list(store.played())
    except StoreError as error:
        if "holds a tournament that has not begun" not in str(error):
            raise
        return 0
    for one in played:
        content = (folder / "replays" / f"{one.match.id}.replay").read_bytes()
        assert hashlib.blake2b(content, digest_size=16).hexdigest() == one.replay
    return len(played)


@pytest.fixture
def undisturbed(server, tmp_path):
    """The export of the tournament that nothing disturbs."""
    shutil.copy(Path(__file__).parents[1] / "isolation" / "bad" / "crashes.py", tmp_path)
    assert server.play("undisturbed") == 0
    expected = exported(tmp_path / "undisturbed")
    assert expected.count(b"\n") == MATCHES
    assert expected.count(b"FORFEIT_OUT") == MATCHES / 2 - 10
    return expected


def test_killed_again_and_again_it_ends_as_if_undisturbed(server, tmp_path, undisturbed):
    for kill, matches in KILLS:
        assert (server.play("killed", kill), kept(tmp_path / "killed")) == (-signal.SIGKILL, matches), kill
    assert server.play("killed") == 0
    assert exported(tmp_path / "killed") == undisturbed


@pytest.mark.nightly
@pytest.mark.parametrize("call", ["Store transaction", "Store keep", "Store _keep", "Path replace"])
def test_killed_before_and_after_each_of_the_first_calls_it_ends_as_if_undisturbed(server, tmp_path, undisturbed, call):
    before = 0
    for kill in (f"{call} {number} {when}" for number in range(1, 5) for when in ("before", "after")):
        assert server.play("killed", kill) == -signal.SIGKILL, kill
        assert kept(tmp_path / "killed") >= before
        before = kept(tmp_path / "killed")
    assert server.play("killed") == 0
    assert exported(tmp_path / "killed") == undisturbed


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
        [
            *command,
            "--scenario",
            "duel",
            "--rounds",
            "5000",
            "--jobs",
            "2",
            "--out",
            "o",
            "--limit",
            "isolation=processes",
        ],
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
    )
    while len(told()) < 2 and process.poll() is None:
        time.sleep(0.05)
    process.kill()
    process.wait()
    assert len(told()) >= 2
    patience = time.monotonic() + 60
    while any(one.exists() for one in told()) and time.monotonic() < patience:
        time.sleep(0.05)
    assert not [one for one in told() if one.exists()]
