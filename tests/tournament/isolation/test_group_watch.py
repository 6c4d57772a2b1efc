"""What all processes of an agent take together is bounded: whoever takes more is ended, and the other plays on."""

import pytest
from isolation_levels import LEVELS, NAMESPACES
from tournament.isolation.greedy_agents import reason_of

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


@pytest.mark.parametrize("what", [FORKS, ORPHANS, THREADS], ids=["forks", "orphans", "threads"])
@pytest.mark.parametrize("level", LEVELS)
def test_processes_and_threads_are_counted_together(tmp_path, level, what):
    """By the kernel, for a user who is not root in namespaces; else by the supervisor."""
    assert reason_of(tmp_path, what, level=level, processes=40) in {
        "act: it had more than 40 processes and threads (processes)",
        "act raised BlockingIOError: [Errno 11] Resource temporarily unavailable",
        "act raised RuntimeError: can't start new thread",
    }


@pytest.mark.parametrize("level", LEVELS)
def test_memory_is_counted_together(tmp_path, level):
    found = reason_of(tmp_path, MEMORY, level=level, memory_mib=100)
    assert found == "act: its processes together held more than twice 100 MiB (memory_mib)"


@pytest.mark.parametrize("level", NAMESPACES)
def test_small_files_in_memory_are_counted(tmp_path, level):
    assert reason_of(tmp_path, FILES, level=level) == "act: it made more than 65536 files"
