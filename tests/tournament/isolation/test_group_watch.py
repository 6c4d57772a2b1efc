"""What all processes of an agent take together is bounded: whoever takes more is ended, and the other plays on."""

import pytest
from isolation_levels import LEVELS, NAMESPACES

from catch_arena import scenario
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.isolation.inspecting import inspector
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.isolation.starting import start_players
from catch_arena.tournament.match_loop import play

SHORT = scenario("duel", time_limit_s=1)
FREE = {"init_s": 60, "step_ms": 60_000}
AGENT = """
import os, threading, time
from pathlib import Path

class Agent:
    def reset(self, seed):
        self.tried = False

    def act(self, view):
        if not self.tried:
            self.tried = True
            self.take()
            time.sleep(30)
        return 0

    def take(self):
"""
FORKS = """
        for _ in range(60):
            if os.fork() == 0:
                time.sleep(60)
                os._exit(0)
"""
ORPHANS = """
        for _ in range(60):
            if os.fork() == 0:
                os.setsid()
                if os.fork() == 0:
                    time.sleep(60)
                os._exit(0)
            os.wait()
"""
THREADS = """
        for _ in range(60):
            threading.Thread(target=time.sleep, args=(60,), daemon=True).start()
"""
MEMORY = """
        for _ in range(6):
            if os.fork() == 0:
                hoard = os.urandom(40 << 20)
                time.sleep(60)
                os._exit(0)
"""
FILES = """
        for number in range(70_000):
            os.close(os.open(f"/tmp/{number}", os.O_CREAT))
"""


def details(tmp_path, what, **limits):
    """How an agent fails that does that, beside one that does nothing."""
    path = tmp_path / "takes.py"
    path.write_text(AGENT + what)
    with Sandbox(AgentLimits(**FREE, **limits)) as sandbox:
        entrants = enter([str(path), "idle"], inspector(sandbox))
        for _ in range(2):  # and the next match is like the first
            with start_players(entrants, sandbox) as players:
                result = play(SHORT, 1, players, ["takes", "idle"])
            assert result.forfeits == ("FORFEIT_CRASH", None)
            assert result.ranks == (2, 1)
    return result.details[0].reason


@pytest.mark.parametrize("what", [FORKS, ORPHANS, THREADS], ids=["forks", "orphans", "threads"])
@pytest.mark.parametrize("level", LEVELS)
def test_processes_and_threads_are_counted_together(tmp_path, level, what):
    """By the kernel, for a user who is not root in namespaces; else by the supervisor."""
    assert details(tmp_path, what, level=level, processes=40) in {
        "act: it had more than 40 processes and threads (processes)",
        "act raised BlockingIOError: [Errno 11] Resource temporarily unavailable",
        "act raised RuntimeError: can't start new thread",
    }


@pytest.mark.parametrize("level", LEVELS)
def test_memory_is_counted_together(tmp_path, level):
    found = details(tmp_path, MEMORY, level=level, memory_mib=100)
    assert found == "act: its processes together held more than twice 100 MiB (memory_mib)"


@pytest.mark.parametrize("level", NAMESPACES)
def test_small_files_in_memory_are_counted(tmp_path, level):
    assert details(tmp_path, FILES, level=level) == "act: it made more than 65536 files"
