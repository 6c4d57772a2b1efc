"""Commands work, or print why not, on systems like Windows, which are simulated by removing modules."""

import subprocess
import sys

import pytest

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
