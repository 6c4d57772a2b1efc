"""A tournament that is killed with SIGKILL resumes, ends with the same results, and leaves no process behind."""

import hashlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from isolation_levels import LEVELS
from tournament.agents import LEAVES_A_CHILD, write_agent
from tournament.runs import exported

from catch_arena.errors import StoreError
from catch_arena.interrupts import descendants
from catch_arena.tournament.store import Store

WORDS = (
    *("tournament", "nearest", "random", "contested", "crashes.py", "--scenario", "duel", "--set", "time_limit_s=3"),
    *("--rounds", "6", "--seed", "0", "--record", "--resume", "--trusted", "--jobs", "1", "--out"),
)
"""The last agent is out after ten matches, which no resumption may forget."""
MATCHES = 72
KILLED = """
import os, signal, sys
from itertools import count
from pathlib import Path
from catch_arena.cli import main
from catch_arena.tournament.store import Store

place, name, number, when, *words = sys.argv[1:]
owner, calls = {"Store": Store, "Path": Path}[place], count(1)
function = getattr(owner, name)

def counted(*arguments, **options):
    last = next(calls) == int(number)
    if last and when == "before":
        os.kill(os.getpid(), signal.SIGKILL)
    result = function(*arguments, **options)
    if last:
        os.kill(os.getpid(), signal.SIGKILL)
    return result

setattr(owner, name, counted)
main(words)
"""
KILLS = (
    ("Store transaction 1 after", 0),
    ("Store set_planned 1 after", 0),
    ("Store add 5 after", 10),
    ("Store _add_match 3 after", 12),
    ("Path replace 4 before", 14),
    ("Path replace 1 after", 14),
    ("Store add 9 before", 30),
    ("Store end 1 before", 72),
    ("Store end 1 after", 72),
    ("Path replace 1 before", 72),
)
"""At which call of which function a tournament is killed, and how many matches are in its store then.

A block has two matches, so the third `_add_match` is in the middle of a transaction. `Path.replace` ends each replay:
the fourth that is not called leaves half of a block's replays, and a temporary file.
"""


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


def test_killed_again_and_again_it_ends_as_if_undisturbed(tmp_path, catch_arena):
    shutil.copy(Path(__file__).parents[1] / "isolation" / "bad" / "crashes.py", tmp_path)
    assert catch_arena(*WORDS, "undisturbed").exit_code == 0
    expected = exported(tmp_path / "undisturbed")
    assert expected.count(b"\n") == MATCHES
    assert expected.count(b"FORFEIT_OUT") == MATCHES / 2 - 10
    for kill, matches in KILLS:
        words = [sys.executable, "-c", KILLED, *kill.split(), *WORDS, "killed"]
        killed = subprocess.run(words, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        assert (killed.returncode, kept(tmp_path / "killed")) == (-signal.SIGKILL, matches), kill
    assert catch_arena(*WORDS, "killed").exit_code == 0
    assert exported(tmp_path / "killed") == expected


PLAYS = """
import sys
from pathlib import Path
from catch_arena import scenario
from catch_arena.tournament.players import enter
from catch_arena.tournament.execution.executors import local_executor
from catch_arena.tournament.execution.runner import play_plan
from catch_arena.tournament.execution.executors import Worker
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.store import Store, Tournament
quotas = Quotas(isolation=sys.argv[1], init_s=120, step_ms=1_000_000)
config = scenario("duel")
plan = round_robin(2, Parties.of(config), 9, 0)
entrants = enter(["mine.py", "mine.py"])
with (
    Store.begin(Tournament(config, entrants, plan.parameters, "0"), Path()) as store,
    local_executor(Worker(config, entrants, quotas=quotas), 2) as executor,
):
    play_plan(store, plan, executor)
"""


@pytest.mark.parametrize("level", LEVELS)
def test_nothing_outlives_a_tournament_that_is_killed(level, tmp_path):
    """Not its workers nor their agents, nor a grandchild in a session of its own, nor their folders."""
    write_agent(tmp_path / "mine.py", "time.sleep(600)", LEAVES_A_CHILD, "import os, time\n")
    (tmp_path / "temporary").mkdir()
    environment = os.environ | {"TMPDIR": str(tmp_path / "temporary")}
    process = subprocess.Popen([sys.executable, "-c", PLAYS, level], cwd=tmp_path, env=environment)
    with process:
        while sum(is_grandchild(pid) for pid in descendants(process.pid)) < 4 and process.poll() is None:
            time.sleep(0.05)
        relatives = descendants(process.pid)
        assert len(relatives) >= 14  # two workers, with two programs each, their agents, and these children
        process.kill()
    assert within_a_minute(lambda: not any(map(lives, relatives)) and not any((tmp_path / "temporary").iterdir()))


COMPUTES = """
import time
from itertools import repeat
from catch_arena.tournament.execution.executors import ProcessExecutor, Worker
from catch_arena.config import ArenaConfig
executor = ProcessExecutor(Worker(ArenaConfig(), ()), 1)
executor.result(executor.run(abs, 1))
executor.run(sum, repeat(1))
print("ready", flush=True)
time.sleep(600)
"""


def test_a_worker_in_compiled_code_that_never_ends_ends_with_its_command():
    """As in a trusted agent's library: Python runs no handler of a signal there."""
    with subprocess.Popen([sys.executable, "-c", COMPUTES], stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"ready\n"
        relatives = descendants(process.pid)
        time.sleep(0.5)  # so that it is mostly in that code
        process.kill()
    assert within_a_minute(lambda: not any(map(lives, relatives)))


def within_a_minute(ended: Callable[[], bool]) -> bool:
    patience = time.monotonic() + 60
    while not ended() and time.monotonic() < patience:
        time.sleep(0.02)
    return ended()


def is_grandchild(pid: int) -> bool:
    with suppress(FileNotFoundError, ProcessLookupError):
        return b"98765" in Path(f"/proc/{pid}/cmdline").read_bytes()
    return False


def lives(pid: int) -> bool:
    """Return if a process runs; one that has ended and is not waited for yet does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_bytes().rpartition(b")")[2].split()[0] not in {b"Z", b"X"}
    except FileNotFoundError:
        return False
