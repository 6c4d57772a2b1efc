"""Hostile agents in namespaces cannot see, harm or outlive others, in a real tournament or match.

docs/howto/isolation.md has the same attacks in its table. An attacker touches only what it finds from inside
its namespaces.
"""

import os
import re
import secrets
import subprocess
import sys
import time
from textwrap import indent

import pytest
from isolation_levels import NAMESPACES
from tournament.agents import source

from catch_arena import scenario
from catch_arena.interrupts import descendants
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match_loop import play_entrants
from catch_arena.tournament.players import enter
from catch_arena.tournament.store import Store

pytestmark = [pytest.mark.hostile, pytest.mark.parametrize("level", NAMESPACES)]
PATIENT = {"init_s": 120, "step_ms": 60_000}
SHORT = scenario("duel", time_limit_s=0.5)
BEFORE = "import ctypes, os, resource, signal, socket, sys, threading, time\nfrom pathlib import Path\n"
RIVAL = """
import time
from pathlib import Path

class Agent:
    def reset(self, seed):
        self.secret = Path(__file__).with_suffix(".txt").read_text()
        Path("notes").write_text(self.secret)
        print("thinks of", self.secret)

    def act(self, view):
        time.sleep(0.02)  # an attack that goes on meets it
        return 1 if Path("notes").read_text() == self.secret else 99
"""
SEES = r"""
import re
def searched(content):
    for found in set(re.findall(rb"SECRET-[0-9a-f]{32}", content)):
        print("found", found.decode())
skipped = ("/usr", "/bin", "/sbin", "/lib", "/lib64", "/sys", "/dev", "/proc", sys.prefix, sys.base_prefix)
seen = 0
for folder, folders, files in os.walk("/"):
    folders[:] = [one for one in folders if not os.path.join(folder, one).startswith(skipped)]
    for path in (Path(folder, name) for name in files):
        try:
            content = path.read_bytes() if path.is_file() else b""
        except OSError:
            continue
        if path.suffix != ".pyc":
            print("sees", path)
        searched(content)
        seen += 1
for path in Path("/proc/sys").rglob("*"):
    try:
        os.close(os.open(path, os.O_WRONLY))
        print("can set", path)
    except OSError:
        pass
for path in Path("/proc").glob("[0-9]*/*"):
    if path.name in ("environ", "cmdline", "mountinfo"):
        try:
            searched(path.read_bytes())
        except OSError:
            pass
for pid in filter(str.isdigit, os.listdir("/proc")):
    try:
        spans = [line.split()[0].split("-") for line in open(f"/proc/{pid}/maps") if " rw" in line and "[v" not in line]
        with open(f"/proc/{pid}/mem", "rb", buffering=0) as memory:
            for begin, end in spans:
                memory.seek(int(begin, 16))
                searched(memory.read(int(end, 16) - int(begin, 16)))
    except OSError:
        pass
print("looked at", seen)
"""
KILLS = r"""
for number in (signal.SIGSTOP, signal.SIGKILL):
    for pid in [-1, 1, *range(2, 40000)]:
        if pid != os.getpid():
            try:
                os.kill(pid, number)
            except OSError:
                pass
"""
FORKS = r"""
count = 0
try:
    while count < 5000:
        if os.fork() == 0:
            while True:
                try:
                    os.fork()
                except OSError:
                    time.sleep(0.01)
        count += 1
except OSError:
    pass
time.sleep(1)
"""
FLOODS = r"""
threading.Thread(target=lambda: [os.write(1, b"x" * 65536) for _ in iter(int, 1)], daemon=True).start()
for _ in range(257):
    os.write(1, b"x" * 65536)
"""
FORGES = r"""
for file in range(3, 64):
    try:
        os.write(file, b'{"ended":99999999999999999999}\n{"action":1}\n')
    except OSError:
        pass
"""
OUTLIVES = r"""
if os.fork() == 0:
    os.setsid()
    ctypes.CDLL(None).prctl(1, 0, 0, 0, 0)
    if os.fork() == 0:
        for number in set(signal.Signals) - {signal.SIGKILL, signal.SIGSTOP}:
            signal.signal(number, signal.SIG_IGN)
        os.execvp("sleep", ["sleep", "98765"])
    os._exit(0)
time.sleep(0.5)
"""
AT_IMPORT = "ctypes.CDLL(None).prctl(1, 0, 0, 0, 0)\n"
"""The program above all matches does not end with its parent any more, as far as the agent can do that."""


THREADS = r"""
try:
    for count in range(5000):
        threading.Thread(target=time.sleep, args=(600,), daemon=True).start()
except RuntimeError:
    print("started", count)
"""


def attacker(attack, before=""):
    """Return an agent that attacks in its second step."""
    act = f"if self.step == 2:\n{indent(attack.strip(), '    ')}\nreturn 0"
    return source(act, before=BEFORE + before)


@pytest.fixture
def hand_ins(tmp_path):
    """A folder with a rival that has a secret in the file next to it."""
    folder = tmp_path / "hand ins"
    folder.mkdir()
    (folder / "rival.py").write_text(RIVAL)
    (folder / "rival.txt").write_text(f"SECRET-{secrets.token_hex(16)}")
    return folder


def fight(hand_ins, level, attack, *, before="", matches=1, **limits):
    """Play matches of an attacker and the rival, and require that the rival is not harmed, and nothing left."""
    (hand_ins / "attacker.py").write_text(attacker(attack, before))
    elder = descendants(os.getpid())
    with Sandbox(Quotas(**(PATIENT | {"isolation": level} | limits))) as sandbox:
        entrants = enter([str(hand_ins / "attacker.py"), str(hand_ins / "rival.py")], sandbox)
        results = [play_entrants(SHORT, 1, entrants, sandbox) for _ in range(matches)]
    for result in results:
        assert result.forfeit_codes[1] is None
        assert re.fullmatch(r"thinks of SECRET-\w+\n", result.logs[1])
    assert left(elder) == set()
    return results


def left(elder):
    """Wait for all that is new, which ends a moment after its namespaces; return what does not."""
    patience = time.monotonic() + 30
    while (found := descendants(os.getpid()) - elder) and time.monotonic() < patience:
        time.sleep(0.01)
    return found


def test_it_sees_no_secret_of_others(level, hand_ins, tmp_path):
    """In a tournament by the command line, whose store, environment and user's files hold secrets."""
    home = tmp_path / "home"
    home.mkdir()
    (home / "key").write_text(f"SECRET-{secrets.token_hex(16)}")
    (hand_ins / "attacker.key").symlink_to(home / "key")
    (hand_ins / "attacker.py").write_text(attacker(SEES))
    limits = [word for limit, value in PATIENT.items() for word in ("--limit", f"{limit}={value}")]
    subprocess.run(
        [
            *(sys.executable, "-m", "catch_arena", "tournament", hand_ins / "attacker.py", hand_ins / "rival.py"),
            *("--scenario", "duel", "--set", "time_limit_s=0.3", "--rounds", "2", "--jobs", "2", "--record"),
            *("--limit", f"isolation={level}", "--limit", "log_kib=10000", *limits, "--out", "out"),
        ],
        cwd=tmp_path,
        env=os.environ | {"PASSWORD": f"SECRET-{secrets.token_hex(16)}", "HOME": str(home)},
        check=True,
        timeout=500,
    )
    log = (tmp_path / "out" / "logs" / "attacker.log").read_text()
    assert int(re.search(r"looked at (\d+)", log)[1]) > 100
    assert not re.findall(r"^(?:found|can set).*", log, re.MULTILINE)
    assert not re.findall(r"^sees .*(?:rival|home|out/|attacker\.key).*", log, re.MULTILINE)
    with Store.read(tmp_path / "out") as store:
        played = list(store.played())
    assert [code for one in played for code in one.result.forfeit_codes] == [None] * 8
    seeds = {str(seed) for one in played for seed in (one.match.seed, *one.match.agent_seeds)}
    assert not [seed for seed in seeds if seed in log]


@pytest.mark.parametrize(
    ("attack", "limits", "code"),
    [
        pytest.param(KILLS, {}, "FORFEIT_CRASH", id="kills all that it sees"),
        pytest.param(FORKS, {"step_ms": 3000, "bank_s": 0, "processes": 100}, "FORFEIT_TIMEOUT", id="forks for ever"),
        pytest.param(FLOODS, {}, "FORFEIT_CRASH", id="prints without end"),
        pytest.param(FORGES, {}, "FORFEIT_ILLEGAL", id="forges what our program says"),
        pytest.param("os.kill(os.getppid(), signal.SIGSTOP)", {}, None, id="stops our program"),
    ],
)
def test_it_harms_itself_alone(level, hand_ins, attack, limits, code):
    first, second = fight(hand_ins, level, attack, before=AT_IMPORT, matches=2, **limits)
    assert first.forfeit_codes[0] == second.forfeit_codes[0] == code


def test_its_processes_and_threads_are_bounded(level, hand_ins):
    (result,) = fight(hand_ins, level, THREADS, processes=100)
    most = 100 if os.getuid() else 130  # root is bound by the memory that their stacks take
    assert int(re.search(r"started (\d+)", result.logs[0])[1]) < most


def test_nothing_of_it_lives_on_into_the_next_match_or_after_the_tournament(level, hand_ins):
    counts = "print('processes', len([one for one in os.listdir('/proc') if one.isdigit()]))\n"
    results = fight(hand_ins, level, counts + OUTLIVES, before=AT_IMPORT, matches=2)
    assert [re.search(r"processes \d+", result.logs[0])[0] for result in results] == ["processes 3"] * 2
