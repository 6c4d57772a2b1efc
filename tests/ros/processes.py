"""Processes that a test starts, and that end with it."""

import fcntl
import os
import socket
import subprocess
import sys
import tempfile
import threading
from contextlib import ExitStack, contextmanager
from pathlib import Path

HERE = Path(__file__).parent
DOMAINS = range(1, 101)
"""Without 0, which people use; the ports of those above belong to the system's own range."""
LONGEST_S = 180
"""No test needs a process for longer, on any machine."""
_had = set()
"""Of this process: DDS configures each only once in a process, as whoever comes first wants it."""


@contextmanager
def own_domain():
    """A DDS domain in which no other test of this machine is: a referee there would answer for ours."""
    for domain in sorted(set(DOMAINS) - _had):
        with ExitStack() as stack:
            try:
                lock = stack.enter_context((Path(tempfile.gettempdir()) / f"catch-arena-domain-{domain}").open("w"))
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                _require_empty(domain)
            except OSError:  # somebody has it
                continue
            _had.add(domain)
            yield domain
            return
    raise AssertionError("every domain is taken")


def _require_empty(domain):
    """Raise OSError if a process is in that domain that holds no lock of ours: the first one there has this port."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 7410 + 250 * domain))


@contextmanager
def started(script, *arguments, **variables):
    """A script of this folder, or `catch-arena` where it is None."""
    command = ["-m", "catch_arena"] if script is None else [HERE / script]
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(str(HERE.parents[level]) for level in (0, 1)),
        "PYTHONUNBUFFERED": "1",
        "ROS_LOCALHOST_ONLY": "1",
        **variables,
    }
    with subprocess.Popen(
        [sys.executable, *command, *map(str, arguments)],
        env=environment,
        cwd=HERE.parents[1],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        last = threading.Timer(LONGEST_S, process.kill)  # who waits for a line of it would wait for ever
        last.start()
        try:
            yield process
        finally:
            last.cancel()
            process.kill()
