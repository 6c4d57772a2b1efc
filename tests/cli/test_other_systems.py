"""Commands work, or print why not, on Windows and macOS, which are simulated on Linux by removing parts of it."""

import subprocess
import sys
import time

import pytest
from interrupts.commands import PATIENCE_S, Command

AGENT = "class Agent:\n    def reset(self, seed): pass\n    def act(self, view): return 0\n"
SPEC = 'seed = 1\n[[test]]\nname = "plays"\nscenario = "duel"\nopponents = ["idle"]\nmatches = 1\n'
WITHOUT = """
import multiprocessing.util, os, platform, platformdirs, select, selectors, signal, subprocess, sys, tempfile
for module in ("fcntl", "grp", "pwd", "resource", "termios"):
    sys.modules[module] = None
for module, names in {
    os: ("fork", "forkpty", "killpg", "getuid", "geteuid", "getpgid", "setsid", "sched_getaffinity"),
    select: ("poll", "epoll"),
    signal: ("SIGHUP", "SIGKILL", "SIGPIPE", "SIGXCPU", "SIGXFSZ", "pause", "pthread_sigmask", "setitimer"),
}.items():
    for name in names:
        delattr(module, name)
from catch_arena.__main__ import main
main(sys.argv[1:])
"""
QUICK = ["--scenario", "duel", "--set", "time_limit_s=1"]


MAC = """
import functools, os

def refuse(event, arguments):
    reads = event in ("open", "os.listdir", "os.scandir", "stat")
    if reads and os.path.join(str(arguments[0]), "").startswith("/proc/"):
        raise FileNotFoundError(2, "No such file or directory", arguments[0])
    if event == "ctypes.dlsym" and arguments[1] == "prctl":
        raise AttributeError("prctl: symbol not found")
    assert event != "subprocess.Popen" or "bwrap" not in str(arguments[0])

def audited(function, path, *arguments, **options):
    refuse("stat", (path,))
    return function(path, *arguments, **options)

# Python raises no audit event for these; pathlib of Python 3.10 keeps them when it is imported
os.stat, os.lstat = functools.partial(audited, os.stat), functools.partial(audited, os.lstat)
import multiprocessing.spawn, resource, select, signal, subprocess, sys, sysconfig
import llvmlite.binding, platformdirs  # these and sysconfig look for libraries and folders by the platform's name

sysconfig.get_config_vars()
sys.platform = "darwin"
sys.executable = os.path.join(os.path.dirname(os.path.abspath(__file__)), "python")
multiprocessing.spawn.set_executable(sys.executable)
for module, names in {
    os: ("sched_getaffinity", "eventfd", "memfd_create", "pidfd_open", "pipe2", "posix_fadvise"),
    resource: ("prlimit",),
    select: ("epoll",),
    signal: ("pidfd_send_signal", "sigtimedwait", "sigwaitinfo"),
}.items():
    for name in names:
        if hasattr(module, name):
            delattr(module, name)

sys.addaudithook(refuse)
at = sys.argv.index("-c")
program, sys.argv, sys.path[0] = sys.argv[at + 1], ["-c", *sys.argv[at + 2 :]], ""
del __file__  # as with -c: other processes need not run this one's main module
exec(program)
"""
COMMAND = "import sys; from catch_arena.__main__ import main; main(sys.argv[1:])"
ON_MAC = "import os, sys\nassert sys.platform == 'darwin' and not hasattr(os, 'sched_getaffinity')\n"
"""Beginning of an agent that cannot be imported in a process that is not simulated."""
WAITS = """
from pathlib import Path
import time
HERE = Path(__file__).parent
class Agent:
    def reset(self, seed): pass
    def act(self, view):
        while (HERE / "go").exists():
            (HERE / "waits").touch()
            time.sleep(0.1)
        return 0
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("windows")
    (found / "mine.py").write_text(AGENT)
    (found / "spec.toml").write_text(SPEC)
    return found


def run(folder, *words):
    return subprocess.run(
        [sys.executable, "-c", WITHOUT, *words], cwd=folder, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize(
    "words",
    [
        ["match", "nearest", "idle", *QUICK],
        ["match", "mine.py", "idle", *QUICK, "--trusted", "--force", "-o", "m.replay"],
        ["tournament", "nearest", "idle", *QUICK, "--rounds", "1", "--out", "o"],
        ["report", "o"],
        ["export", "o", "-o", "m.jsonl"],
        ["compare", "nearest", "idle", *QUICK, "--jobs", "1", "--max-blocks", "1"],
        ["check-agent", "nearest", *QUICK],
        ["grade", "nearest", "--spec", "spec.toml"],
        ["agents"],
    ],
    ids=lambda words: " ".join(words[:2]),
)
def test_shipped_and_trusted_agents_play(folder, words):
    done = run(folder, *words)
    assert done.returncode == (3 if words[0] == "compare" else 0), done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "words",
    [["match", "mine.py", "idle", *QUICK], ["tournament", "mine.py", "idle", *QUICK], ["check-agent", "mine.py"]],
)
def test_an_agent_in_a_file_gets_one_line(folder, words):
    done = run(folder, *words)
    assert done.returncode == 2
    assert done.stderr.startswith("error: ")
    assert done.stderr.endswith("mine.py: agents are isolated on Linux and macOS only: give --trusted, or use WSL\n")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "subject"),
    [
        (["league", "."], "a league"),
        (["grade", ".", "--spec", "spec.toml", "--out", "../graded"], "grading of a class"),
    ],
)
def test_a_command_that_trusts_nobody_says_that_it_needs_another_system(folder, words, subject):
    done = run(folder, *words)
    assert done.returncode == 2
    assert done.stderr == f"error: {subject} isolates its agents, which works on Linux and macOS only: use WSL\n"


@pytest.fixture(scope="module")
def mac(tmp_path_factory):
    """Return a folder with `python`, which runs each process of a command as on macOS: workers and agents too."""
    found = tmp_path_factory.mktemp("mac")
    (found / "mac.py").write_text(MAC)
    (found / "python").write_text(f'#!/bin/sh\nexec "{sys.executable}" "{found}/mac.py" "$@"\n')
    (found / "python").chmod(0o755)
    (found / "mine.py").write_text(f"{ON_MAC}print('imported')\n{AGENT}")
    (found / "hangs.py").write_text(ON_MAC + AGENT.replace("return 0", "\n        while True: pass"))
    (found / "crashes.py").write_text(ON_MAC + AGENT.replace("return 0", "os.abort()"))
    (found / "waits.py").write_text(ON_MAC + WAITS)
    (found / "spec.toml").write_text(SPEC)
    return found


@pytest.mark.parametrize(
    "words",
    [
        ["match", "mine.py", "idle", *QUICK, "--force"],
        ["tournament", "mine.py", "idle", *QUICK, "--rounds", "2", "--jobs", "2", "--out", "o"],
        ["check-agent", "mine.py", *QUICK],
        ["grade", "mine.py", "--spec", "spec.toml"],
    ],
    ids=lambda words: words[0],
)
def test_agents_from_files_play_as_processes_on_macos(mac, words):
    done = run_on_mac(mac, *words)
    assert "forfeit" not in done.stdout + done.stderr


def test_an_agent_has_one_process_for_many_matches_on_macos(mac):
    run_on_mac(mac, "tournament", "mine.py", "idle", *QUICK, "--rounds", "2", "--jobs", "1", "--out", "one")
    assert (mac / "one" / "logs" / "mine.log").read_text().count("imported") == 1


def test_an_agent_that_hangs_or_crashes_forfeits_on_macos(mac):
    words = ["match", "hangs.py", "crashes.py", "mine.py", *QUICK, "--set", "hunters=3", "--limit", "bank_s=0.1"]
    done = run_on_mac(mac, *words, "-o", "faults.replay")
    late = "act took longer than step_ms (100 ms) and what was left of bank_s (0.1 s)"
    assert f"hangs (hunter_0): FORFEIT_TIMEOUT in step 1: {late}\n" in done.stdout
    assert "crashes (hunter_1): FORFEIT_CRASH in step 1: act: its process was ended by SIGABRT\n" in done.stdout
    assert "mine (hunter_2)\n" in done.stdout


def test_an_agent_that_hangs_does_not_outlive_an_interrupt_on_macos(mac):
    words = ["tournament", "waits.py", "mine.py", *QUICK, "--rounds", "500", "--jobs", "2", "--out", "long"]
    command = Command(mac, [*words, "--limit", "step_ms=1000000"], [mac / "python", "-c", COMMAND])
    patience = time.monotonic() + PATIENCE_S
    for made, then in ((mac / "long" / "tournament.sqlite", mac / "go"), (mac / "waits", mac / "waited")):
        while not made.exists() and time.monotonic() < patience:
            time.sleep(0.05)
        then.touch()
    command.interrupt()
    ended = command.ended()
    (mac / "go").unlink()
    assert (ended.status, ended.left) == (130, [])


def run_on_mac(mac, *words):
    """Run a command that succeeds, and return its outputs."""
    done = subprocess.run([mac / "python", "-c", COMMAND, *words], cwd=mac, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    level = "isolation: processes, which does not stop a hostile agent: only Linux has namespaces, and this is darwin "
    assert done.stderr.startswith(level)
    return done
